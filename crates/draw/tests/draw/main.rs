//! Figures as files.

mod pdf;
