//! The program `gibs`.
fn main() -> std::process::ExitCode {
    gibs::cli::main()
}
