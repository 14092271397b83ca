//! What the benchmarks have in common.

use clap::Parser;

/// Reads the command line, but for the flag that cargo adds to it, and runs; an error is said in a sentence.
pub fn main<A: Parser>(run: impl Fn(&A) -> emlt::Result<()>) {
    let words = std::env::args_os().filter(|word| word != "--bench");
    if let Err(error) = run(&A::parse_from(words)) {
        eprintln!("error: {error}");
        std::process::exit(i32::from(error.exit_status()));
    }
}
