//! Headless `doublet` binary.

fn main() {}
