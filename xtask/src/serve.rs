//! Serves the site on this machine: static files, compressed forms where the browser takes them, a strict policy.

use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, bail};
use tiny_http::{Header, Method, Request, Response, Server};

use crate::compress::{Effort, with_suffix};
use crate::{site, wasm};

/// What the page may do: load its own files, compile wasm, start its worker.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; \
                      img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; base-uri 'none'";

/// What the example in `example/` may do: load its own files and show the page in a frame.
const EXAMPLE_POLICY: &str = "default-src 'none'; script-src 'self'; frame-src 'self'; base-uri 'none'";

/// A page and its wasm arrive over a few connections at once.
const THREADS: usize = 4;

const FIRST_PORT: u16 = 8080;

/// `cargo xtask serve`.
pub(crate) fn command(args: &[String]) -> Result<()> {
    let mut options = wasm::Options { quick: false, build_std: false };
    let mut port = None;
    let (mut open, mut build) = (true, true);
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--quick" => options.quick = true,
            "--build-std" => options.build_std = true,
            "--no-open" => open = false,
            "--as-is" => build = false,
            "--port" => {
                let text = args.next().context("`--port` needs a number")?;
                port = Some(text.parse().with_context(|| format!("`--port {text}`: wanted a number up to 65535"))?);
            }
            other => {
                bail!("`serve` has no option {other:?}; it has --port N, --no-open, --as-is, --quick, --build-std")
            }
        }
    }
    let folder = if build { site::build(options, Effort::Quick)?.0 } else { site::built()? };
    let site = Site::start(folder, port)?;
    println!("\nEndcomfort is at {} (Ctrl+C stops it)", site.url());
    if open {
        open_browser(&site.url());
    }
    site.wait();
    Ok(())
}

/// A served folder.
pub(crate) struct Site {
    port: u16,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Site {
    /// Serves a folder on 127.0.0.1: on the port that was asked for, else on 8080 or the next free one.
    pub(crate) fn start(folder: PathBuf, port: Option<u16>) -> Result<Self> {
        let listener = match port {
            Some(port) => TcpListener::bind((Ipv4Addr::LOCALHOST, port))
                .with_context(|| format!("port {port} is taken; without --port the next free one is used"))?,
            None => (FIRST_PORT..FIRST_PORT + 100)
                .find_map(|port| TcpListener::bind((Ipv4Addr::LOCALHOST, port)).ok())
                .with_context(|| format!("the 100 ports from {FIRST_PORT} on are taken; choose one with --port"))?,
        };
        let port = listener.local_addr()?.port();
        let server = Server::from_listener(listener, None).map_err(|error| anyhow!("cannot serve: {error}"))?;
        let (server, folder) = (Arc::new(server), Arc::new(folder));
        let threads = (0..THREADS)
            .map(|_| {
                let (server, folder) = (Arc::clone(&server), Arc::clone(&folder));
                std::thread::spawn(move || {
                    while let Ok(request) = server.recv() {
                        answer(&folder, request);
                    }
                })
            })
            .collect();
        Ok(Self { port, threads })
    }

    /// Where the site is.
    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Serves until the process ends.
    fn wait(self) {
        for thread in self.threads {
            if thread.join().is_err() {
                eprintln!("a thread of the server has stopped");
            }
        }
    }
}

/// The folders of files that keep their names when their content changes.
const MAPS: &str = "maps/";
const EXAMPLE: &str = "example/";

fn answer(folder: &Path, request: Request) {
    let accepts = request
        .headers()
        .iter()
        .find(|header| header.field.equiv("Accept-Encoding"))
        .map(|header| header.value.as_str().to_owned())
        .unwrap_or_default();
    let reply = match request.method() {
        Method::Get | Method::Head => reply(folder, request.url(), &accepts),
        _ => Reply::sentence(405, "This site answers GET and HEAD."),
    };
    let mut response = Response::from_data(reply.body).with_status_code(reply.status);
    for (name, value) in &reply.headers {
        if let Ok(header) = Header::from_bytes(*name, *value) {
            response.add_header(header);
        }
    }
    // A browser that has gone away is no concern of ours.
    let _gone = request.respond(response);
}

/// What is sent back.
struct Reply {
    status: u16,
    headers: Vec<(&'static str, &'static str)>,
    body: Vec<u8>,
}

impl Reply {
    fn sentence(status: u16, text: &str) -> Self {
        Self { status, headers: vec![("Content-Type", "text/plain; charset=utf-8")], body: text.as_bytes().to_vec() }
    }
}

fn reply(folder: &Path, url: &str, accepts: &str) -> Reply {
    let missing = || Reply::sentence(404, "There is no such file on this site.");
    let Some(name) = file_name(url) else { return missing() };
    let path = folder.join(name);
    let Some((encoding, body)) = read_best(&path, accepts) else { return missing() };
    let is_example = name.starts_with(EXAMPLE);
    let keeps_its_name = name == "index.html" || name.starts_with(MAPS) || is_example;
    let mut headers = vec![
        ("Content-Type", mime_type(name)),
        ("Content-Security-Policy", if is_example { EXAMPLE_POLICY } else { POLICY }),
        ("X-Content-Type-Options", "nosniff"),
        ("Vary", "Accept-Encoding"),
        ("Cache-Control", if keeps_its_name { "no-cache" } else { "public, max-age=31536000, immutable" }),
    ];
    if let Some(encoding) = encoding {
        headers.push(("Content-Encoding", encoding));
    }
    Reply { status: 200, headers, body }
}

/// The file that an address means. The site is a flat folder with one of maps and one of an example in it, so anything with another separator,
/// a hidden name or an escape in it means nothing, and no address can lead out of the folder.
fn file_name(url: &str) -> Option<&str> {
    let path = url.split(['?', '#']).next()?.strip_prefix('/')?;
    let name = if path.is_empty() { "index.html" } else { path };
    let last = name.strip_prefix(MAPS).or_else(|| name.strip_prefix(EXAMPLE)).unwrap_or(name);
    let is_plain = last.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_'));
    (is_plain && !last.is_empty() && !last.starts_with('.')).then_some(name)
}

/// The smallest form that the browser takes: its encoding and its bytes.
fn read_best(path: &Path, accepts: &str) -> Option<(Option<&'static str>, Vec<u8>)> {
    for (encoding, suffix) in [("br", "br"), ("gzip", "gz")] {
        if takes(accepts, encoding)
            && let Ok(bytes) = std::fs::read(with_suffix(path, suffix))
        {
            return Some((Some(encoding), bytes));
        }
    }
    std::fs::read(path).ok().map(|bytes| (None, bytes))
}

/// Whether an `Accept-Encoding` header names this encoding without forbidding it (`q=0`).
fn takes(accepts: &str, encoding: &str) -> bool {
    accepts.split(',').any(|part| {
        let mut words = part.split(';').map(str::trim);
        let named = words.next() == Some(encoding);
        let quality = words.find_map(|word| word.strip_prefix("q=")).and_then(|q| q.parse::<f32>().ok());
        named && quality != Some(0.0)
    })
}

fn mime_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("svg") => "image/svg+xml",
        Some("json") => "application/json",
        Some("png") => "image/png",
        _ => "application/octet-stream",
    }
}

/// Shows the page where there is a screen; whoever has none reads the address.
fn open_browser(url: &str) {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else if std::env::var_os("DISPLAY").is_some() || std::env::var_os("WAYLAND_DISPLAY").is_some() {
        "xdg-open"
    } else {
        return;
    };
    if let Err(error) = Command::new(opener).arg(url).stdout(Stdio::null()).stderr(Stdio::null()).spawn() {
        eprintln!("cannot open a browser ({opener}: {error}); please open {url} yourself");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process;

    fn folder_with_a_page(name: &str) -> PathBuf {
        let folder = process::root().join("target/site/tests").join(name);
        std::fs::create_dir_all(&folder).unwrap();
        for (file, text) in [
            ("index.html", "page"),
            ("index.html.br", "page in brotli"),
            ("index.html.gz", "page in gzip"),
            ("a.wasm", "module"),
            (".secret", "secret"),
        ] {
            std::fs::write(folder.join(file), text).unwrap();
        }
        folder
    }

    fn header(reply: &Reply, name: &str) -> Option<&'static str> {
        reply.headers.iter().find(|(field, _)| *field == name).map(|(_, value)| *value)
    }

    #[test]
    fn the_smallest_form_that_the_browser_takes_is_sent() {
        let folder = folder_with_a_page("forms");
        for (accepts, encoding, body) in [
            ("gzip, deflate, br", Some("br"), "page in brotli"),
            ("gzip", Some("gzip"), "page in gzip"),
            ("br;q=0, gzip;q=0.5", Some("gzip"), "page in gzip"),
            ("", None, "page"),
        ] {
            let reply = reply(&folder, "/?renderer=webgl", accepts);
            assert_eq!((reply.status, header(&reply, "Content-Encoding")), (200, encoding), "for {accepts:?}");
            assert_eq!(reply.body, body.as_bytes(), "for {accepts:?}");
        }
    }

    #[test]
    fn every_file_comes_with_its_type_the_policy_and_its_lifetime() {
        let folder = folder_with_a_page("types");
        let page = reply(&folder, "/", "");
        let module = reply(&folder, "/a.wasm", "br");
        assert_eq!(header(&page, "Content-Type"), Some("text/html; charset=utf-8"));
        assert_eq!(header(&module, "Content-Type"), Some("application/wasm"));
        assert_eq!(header(&page, "Cache-Control"), Some("no-cache"));
        assert!(header(&module, "Cache-Control").unwrap().contains("immutable"));
        for reply in [page, module] {
            assert!(header(&reply, "Content-Security-Policy").unwrap().starts_with("default-src 'none'"));
        }
    }

    #[test]
    fn maps_come_from_their_own_folder_and_are_asked_for_anew() {
        let folder = folder_with_a_page("maps");
        std::fs::create_dir_all(folder.join("maps")).unwrap();
        std::fs::write(folder.join("maps/alita_left.reach"), "map").unwrap();
        let map = reply(&folder, "/maps/alita_left.reach", "br");
        assert_eq!((map.status, map.body.as_slice()), (200, b"map".as_slice()));
        // Its name stays when its content changes.
        assert_eq!(header(&map, "Cache-Control"), Some("no-cache"));
    }

    #[test]
    fn the_example_may_show_the_page_in_a_frame_and_the_page_may_show_nothing() {
        let folder = folder_with_a_page("example");
        std::fs::create_dir_all(folder.join("example")).unwrap();
        std::fs::write(folder.join("example/embed.html"), "example").unwrap();
        let example = reply(&folder, "/example/embed.html?x=1", "br");
        assert_eq!((example.status, header(&example, "Cache-Control")), (200, Some("no-cache")));
        assert!(header(&example, "Content-Security-Policy").unwrap().contains("frame-src 'self'"));
        assert!(!header(&reply(&folder, "/", ""), "Content-Security-Policy").unwrap().contains("frame-src"));
    }

    #[test]
    fn no_address_leads_out_of_the_folder() {
        let folder = folder_with_a_page("inside");
        for url in [
            "/../Cargo.toml",
            "/..",
            "/.secret",
            "/a/../a.wasm",
            "/maps/../a.wasm",
            "/maps/",
            "/example/../a.wasm",
            "/example/",
            "/%2e%2e/x",
            "//etc/passwd",
            "a.wasm",
            "/a\\b",
        ] {
            assert_eq!(reply(&folder, url, "br").status, 404, "for {url:?}");
        }
    }

    #[test]
    fn the_page_carries_the_same_policy_as_the_server() {
        // On a static host without headers of its own the page's <meta> is all there is.
        let page = std::fs::read_to_string(process::root().join("index.html")).unwrap();
        assert!(page.contains(&format!("content=\"{POLICY}\"")), "index.html states another policy than {POLICY}");
    }
}
