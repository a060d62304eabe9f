//! The program `rijke`.
fn main() {}
