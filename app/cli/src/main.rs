//! The `aghf` program.

fn main() -> std::process::ExitCode {
    aghf_cli::commands::main()
}
