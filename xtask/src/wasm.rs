//! Compiles the page to WebAssembly, on machines with and without rustup's standard library for it.
//!
//! In this order: the target is there; `rustup target add` brings it; Debian's `rustc-web` and `rust-web-src` are
//! there or can be installed, and the standard library is built from their sources; one sentence says what to install.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::{process, setup};

const TARGET: &str = "wasm32-unknown-unknown";

/// The compiler of Debian's package `rustc-web`.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// How the page is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Trade size and speed of the page for build time.
    pub(crate) quick: bool,
    /// Build the standard library from Debian's sources even if the target is installed.
    pub(crate) build_std: bool,
}

/// Compiles the package `endcomfort-web` and returns the wasm file.
pub(crate) fn build(options: Options) -> Result<PathBuf> {
    let profile = if options.quick { "web-quick" } else { "web" };
    let mut command = process::cargo();
    command.args(["build", "--package", "endcomfort-web", "--lib", "--target", TARGET, "--profile", profile]);
    let folder = match standard_library(options.build_std)? {
        StandardLibrary::Installed => process::root().join("target/wasm"),
        StandardLibrary::Sources { linker } => {
            command.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
            command.arg("-Zbuild-std=std,panic_abort");
            if let Some(linker) = linker {
                command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker);
            }
            process::root().join("target/wasm-std")
        }
    };
    command.arg("--target-dir").arg(&folder);
    process::run(&mut command)?;
    Ok(folder.join(TARGET).join(profile).join("endcomfort_web.wasm"))
}

/// Lints what is compiled for the browser alone.
pub(crate) fn clippy() -> Result<()> {
    if !matches!(standard_library(false)?, StandardLibrary::Installed) {
        println!("skipped: the browser's own code is linted only where the {TARGET} target is installed");
        return Ok(());
    }
    let mut command = process::cargo();
    // With the profile of the build, so that macros and build scripts are compiled once for both.
    command.args(["clippy", "--package", "endcomfort-web", "--lib", "--target", TARGET, "--profile", "web"]);
    command.arg("--target-dir");
    command.arg(process::root().join("target/wasm")).args(["--", "-D", "warnings"]);
    process::run(&mut command)
}

enum StandardLibrary {
    Installed,
    Sources { linker: Option<PathBuf> },
}

fn standard_library(force_sources: bool) -> Result<StandardLibrary> {
    if !force_sources {
        if target_is_installed() {
            return Ok(StandardLibrary::Installed);
        }
        if let Some(rustup) = process::find(&["rustup"]) {
            println!("adding the target {TARGET}");
            if process::run(Command::new(rustup).args(["target", "add", TARGET])).is_ok() && target_is_installed() {
                return Ok(StandardLibrary::Installed);
            }
        }
    }
    let has_sources =
        has_debian_sources() || { setup::install(&["rustc-web", "rust-web-src"])? && has_debian_sources() };
    if has_sources {
        return Ok(StandardLibrary::Sources { linker: linker() });
    }
    bail!(
        "there is no Rust standard library for {TARGET}: please run `rustup target add {TARGET}`, \
         or on Debian `apt-get install rustc-web rust-web-src`"
    );
}

/// Whether the compiler that cargo uses has the target.
fn target_is_installed() -> bool {
    let folder = process::output(Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]));
    folder.is_some_and(|folder| {
        std::fs::read_dir(folder)
            .is_ok_and(|files| files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libstd-")))
    })
}

fn has_debian_sources() -> bool {
    let sysroot = process::output(Command::new(DEBIAN_RUSTC).args(["--print", "sysroot"]));
    sysroot.is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/std/Cargo.toml").is_file())
}

/// A linker for wasm: the one in the toolchain of cargo's own compiler, else LLVM's on `PATH`.
fn linker() -> Option<PathBuf> {
    let libdir = process::output(Command::new("rustc").args(["--print", "target-libdir"]))?;
    let in_toolchain = Path::new(&libdir).parent()?.join("bin/rust-lld");
    if in_toolchain.is_file() { Some(in_toolchain) } else { process::find(&["wasm-ld"]) }
}
