mod robots;

fn main() -> anyhow::Result<()> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    match std::env::args().nth(1).as_deref() {
        Some("robots") => robots::run(&root),
        _ => anyhow::bail!("usage: cargo xtask robots"),
    }
}
