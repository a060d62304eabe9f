//! One module per scientific question; returns numbers, never draws.
