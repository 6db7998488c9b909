//! Where the workloads are that are shared with the measured peers.

use std::path::{Path, PathBuf};

/// The arguments of the bench without cargo's own and without options.
fn arguments() -> impl Iterator<Item = String> {
    std::env::args().skip(1).filter(|argument| !argument.starts_with("--"))
}

/// The folder named by the first argument, else `shared/bench/NAME` beside the repository; `None`, with a word, when it
/// does not hold the file.
pub(crate) fn folder(name: &str, file: &str) -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/bench").join(name);
    let folder = arguments().next().map_or_else(default, PathBuf::from);
    if folder.join(file).is_file() {
        return Some(folder);
    }
    println!("{name}: skipped, {} holds no {file}; name the folder as an argument", folder.display());
    None
}

/// The number behind the folder, if there is one.
#[allow(dead_code, reason = "not every bench takes one")]
pub(crate) fn number() -> Option<u64> {
    arguments().nth(1)?.parse().ok()
}
