//! The `emlt` program; see [`emlt::cli`].

fn main() -> std::process::ExitCode {
    emlt::cli::main()
}
