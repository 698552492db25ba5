//! The `aghf` binary.

fn main() -> std::process::ExitCode {
    aghf::cli::main()
}
