//! Builds the static site: wasm, its JavaScript, the page, every file named by its content and compressed beside it.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use wasm_bindgen_cli_support::Bindgen;

use crate::compress::{self, Effort, Sizes, fingerprint};
use crate::{process, wasm};

/// The page that shows how to embed this one.
const EXAMPLE: [&str; 2] = ["embed.html", "embed.js"];

/// `cargo xtask dist`.
pub(crate) fn command(args: &[String]) -> Result<()> {
    let mut options = wasm::Options { quick: false, build_std: false };
    for arg in args {
        match arg.as_str() {
            "--build-std" => options.build_std = true,
            other => bail!("`dist` has no option {other:?}; it has --build-std"),
        }
    }
    build(options, Effort::Small).map(|_| ())
}

/// Builds the site into `dist/`, prints its sizes, and returns the folder and the size of everything in it.
pub(crate) fn build(options: wasm::Options, effort: Effort) -> Result<(PathBuf, Sizes)> {
    let compiled = wasm::build(options)?;
    let (glue, module) = bind(&compiled)?;

    let folder = process::root().join("dist");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    std::fs::create_dir_all(folder.join("example"))?;
    let mut site = Site { folder: folder.clone(), effort, total: Sizes::default() };
    println!("{:<40} {:>10} {:>10} {:>10}", "dist/", "bytes", "gzip", "brotli");

    let module_bytes = module.len();
    let module_name = site.add_hashed("endcomfort.wasm", &module)?;
    let glue_name = site.add_hashed("endcomfort.js", glue.as_bytes())?;
    let worker = rewrite("web/worker.js", &[("./endcomfort.js", &format!("./{glue_name}"))])?;
    let worker_name = site.add_hashed("worker.js", worker.as_bytes())?;
    let boot = rewrite(
        "web/boot.js",
        &[
            ("./endcomfort.js", &format!("./{glue_name}")),
            ("./endcomfort.wasm", &format!("./{module_name}")),
            ("./worker.js", &format!("./{worker_name}")),
            ("moduleBytes: 0", &format!("moduleBytes: {module_bytes}")),
        ],
    )?;
    let boot_name = site.add_hashed("boot.js", boot.as_bytes())?;
    let style_name = site.add_hashed("style.css", read("web/style.css")?.as_bytes())?;
    let icon_name = site.add_hashed("icon.svg", read("web/icon.svg")?.as_bytes())?;
    let page = rewrite(
        "index.html",
        &[("web/boot.js", &boot_name), ("web/style.css", &style_name), ("web/icon.svg", &icon_name)],
    )?;
    site.add("index.html", page.as_bytes())?;

    for name in EXAMPLE {
        site.add(&format!("example/{name}"), read(&format!("web/example/{name}"))?.as_bytes())?;
    }
    site.add_maps()?;

    let Sizes { raw, gzip, brotli } = site.total;
    println!("{:<40} {raw:>10} {gzip:>10} {brotli:>10}", "all");
    Ok((folder, site.total))
}

/// The folder of the site as it was built last.
pub(crate) fn built() -> Result<PathBuf> {
    let folder = process::root().join("dist");
    ensure!(folder.join("index.html").is_file(), "there is no site in {} yet: leave out --as-is", folder.display());
    Ok(folder)
}

struct Site {
    folder: PathBuf,
    effort: Effort,
    total: Sizes,
}

impl Site {
    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let Sizes { raw, gzip, brotli } = compress::write(&self.folder.join(name), bytes, self.effort)?;
        println!("{name:<40} {raw:>10} {gzip:>10} {brotli:>10}");
        self.total.raw += raw;
        self.total.gzip += gzip;
        self.total.brotli += brotli;
        Ok(())
    }

    /// Adds the reachability maps, which the page fetches when they are first shown. They are compressed inside.
    fn add_maps(&mut self) -> Result<()> {
        let folder = process::root().join("robots/maps");
        let entries = std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?;
        let mut names: Vec<String> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
        names.retain(|name| name.ends_with(".reach"));
        names.sort_unstable();
        let mut total = 0;
        std::fs::create_dir_all(self.folder.join("maps"))?;
        for name in &names {
            let copied = std::fs::copy(folder.join(name), self.folder.join("maps").join(name));
            total += copied.with_context(|| format!("cannot copy {name}"))?;
        }
        println!("{:<40} {total:>10}", format!("maps/ ({} files, fetched when shown)", names.len()));
        Ok(())
    }

    /// Adds `boot.js` as `boot-1f2e3d4c5b.js` and returns that name.
    fn add_hashed(&mut self, name: &str, bytes: &[u8]) -> Result<String> {
        let (stem, extension) = name.split_once('.').context("a file of the site has an extension")?;
        let hashed = format!("{stem}-{}.{extension}", fingerprint(bytes, 10));
        self.add(&hashed, bytes)?;
        Ok(hashed)
    }
}

/// Runs wasm-bindgen and returns the JavaScript and the module.
fn bind(compiled: &Path) -> Result<(String, Vec<u8>)> {
    let folder = process::root().join("target/site/bindgen");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    let mut bindgen = Bindgen::new();
    bindgen
        .input_path(compiled)
        .out_name("endcomfort")
        .web(true)?
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true);
    bindgen.generate(&folder).with_context(|| format!("wasm-bindgen cannot read {}", compiled.display()))?;
    ensure!(
        !folder.join("snippets").exists(),
        "a dependency brings JavaScript snippets, which this site has no place for: see {}",
        folder.join("snippets").display()
    );
    let glue = std::fs::read_to_string(folder.join("endcomfort.js"))?;
    let module = std::fs::read(folder.join("endcomfort_bg.wasm"))?;
    Ok((glue, module))
}

fn read(file: &str) -> Result<String> {
    std::fs::read_to_string(process::root().join(file)).with_context(|| format!("cannot read {file}"))
}

/// The file's text with each left side replaced by its right side.
fn rewrite(file: &str, replacements: &[(&str, &str)]) -> Result<String> {
    replace_all(&read(file)?, replacements).with_context(|| format!("in {file}"))
}

fn replace_all(text: &str, replacements: &[(&str, &str)]) -> Result<String> {
    let mut text = text.to_owned();
    for (from, to) in replacements {
        ensure!(text.contains(from), "nothing says {from:?} any more, so the site would miss {to:?}");
        text = text.replace(from, to);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_that_is_gone_is_an_error_rather_than_a_broken_site() {
        assert_eq!(replace_all("src=a.js", &[("a.js", "a-1.js")]).unwrap(), "src=a-1.js");
        let error = replace_all("src=b.js", &[("a.js", "a-1.js")]).unwrap_err().to_string();
        assert!(error.contains("a.js"), "{error}");
    }
}
