//! The native program: the window, and the command line that does the same without one.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    endcomfort::cli::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {}
