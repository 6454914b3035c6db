//! The doublet workbench.

fn main() {}
