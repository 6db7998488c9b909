//! One browser window.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use serde_json::{Value, json};

use super::{Driver, Picture};

/// Names the environment variable that holds the address of the served site.
pub const SITE_VARIABLE: &str = "ENDCOMFORT_SITE";

/// Flags with which headless Chromium keeps to itself on a machine without network, screen or GPU.
const QUIET: [&str; 9] = [
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,800",
    "--force-device-scale-factor=1",
];

/// One browser at a time: software rendering takes every core there is.
static TURN: Mutex<()> = Mutex::new(());
/// How often a picture is asked for.
const SCREENSHOT_ATTEMPTS: usize = 6;
/// Time without a frame after which the page is at rest: a software renderer takes a second for some.
const REST: Duration = Duration::from_millis(1500);

/// The address of the site under test, with a closing slash.
///
/// # Errors
/// When nobody says where it is.
pub fn site() -> Result<String> {
    let address = std::env::var(SITE_VARIABLE).ok().filter(|address| !address.is_empty()).with_context(|| {
        format!(
            "{SITE_VARIABLE} does not say where the site is served: run `cargo xtask test`, or leave \
             `cargo xtask serve` running and set {SITE_VARIABLE} to the address that it prints"
        )
    })?;
    Ok(format!("{}/", address.trim_end_matches('/')))
}

/// A headless Chromium window; it closes when this is dropped.
pub struct Browser {
    driver: Driver,
    session: String,
    logs: Mutex<Vec<String>>,
    _turn: MutexGuard<'static, ()>,
}

impl Browser {
    /// A browser that draws WebGL2 in software.
    ///
    /// # Errors
    /// When ChromeDriver or Chromium cannot be started.
    pub fn with_webgl() -> Result<Self> {
        Self::start(&["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
    }

    /// A browser that offers WebGPU, in software.
    ///
    /// # Errors
    /// When ChromeDriver or Chromium cannot be started.
    pub fn with_webgpu() -> Result<Self> {
        Self::start(&[
            "--enable-unsafe-webgpu",
            "--use-webgpu-adapter=swiftshader",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--ignore-gpu-blocklist",
        ])
    }

    /// A browser without any way to draw in 3D.
    ///
    /// # Errors
    /// When ChromeDriver or Chromium cannot be started.
    pub fn without_graphics() -> Result<Self> {
        Self::start(&["--disable-gpu", "--disable-3d-apis", "--disable-software-rasterizer"])
    }

    fn start(flags: &[&str]) -> Result<Self> {
        // A test that failed with the turn in its hands leaves nothing behind that the next one minds.
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let driver = Driver::start()?;
        let arguments: Vec<&str> = QUIET.iter().chain(flags).copied().collect();
        let capabilities = json!({ "capabilities": { "alwaysMatch": {
            "browserName": "chrome",
            "goog:loggingPrefs": { "browser": "ALL" },
            "goog:chromeOptions": { "args": arguments },
            "timeouts": { "script": 120_000, "pageLoad": 60_000, "implicit": 0 },
        } } });
        let answer = driver.command("POST", "/session", Some(&capabilities)).context("no browser session")?;
        let session = answer["sessionId"].as_str().context("the session has no name")?.to_owned();
        Ok(Self { driver, session, logs: Mutex::default(), _turn: turn })
    }

    pub(super) fn command(&self, method: &str, path: &str, body: &Value) -> Result<Value> {
        self.driver.command(method, &format!("/session/{}{path}", self.session), (method == "POST").then_some(body))
    }

    /// Opens a page of the site, for example `?renderer=webgl`.
    ///
    /// # Errors
    /// When the site has no address or the page cannot be loaded.
    pub fn open(&self, page: &str) -> Result<()> {
        self.command("POST", "/url", &json!({ "url": format!("{}{page}", site()?) }))?;
        Ok(())
    }

    /// Makes every address that matches one of these patterns (`*.wasm`) unreachable for the page itself; a worker
    /// fetches for itself and is not kept from anything.
    ///
    /// # Errors
    /// When the browser does not take the patterns.
    pub fn block(&self, patterns: &[&str]) -> Result<()> {
        for (command, parameters) in
            [("Network.enable", json!({})), ("Network.setBlockedURLs", json!({ "urls": patterns }))]
        {
            self.command("POST", "/goog/cdp/execute", &json!({ "cmd": command, "params": parameters }))?;
        }
        Ok(())
    }

    /// Runs a script in every page that is opened from now on, before the page's own.
    ///
    /// # Errors
    /// When the browser does not take the script.
    pub fn before_the_page(&self, script: &str) -> Result<()> {
        let parameters = json!({ "source": script });
        let command = json!({ "cmd": "Page.addScriptToEvaluateOnNewDocument", "params": parameters });
        self.command("POST", "/goog/cdp/execute", &command)?;
        Ok(())
    }

    /// Runs the body of a JavaScript function in the page and returns what it returns.
    ///
    /// # Errors
    /// When the script throws.
    pub fn run(&self, script: &str, arguments: &[Value]) -> Result<Value> {
        self.command("POST", "/execute/sync", &json!({ "script": script, "args": arguments }))
    }

    /// Waits until a JavaScript expression is neither false, null nor undefined, and returns its value.
    ///
    /// # Errors
    /// When that does not happen in time; the error shows the page's words and its console.
    pub fn wait_for(&self, what: &str, expression: &str, patience: Duration) -> Result<Value> {
        let start = now();
        loop {
            let value = self.run(&format!("return {expression}"), &[])?;
            if !matches!(value, Value::Null | Value::Bool(false)) {
                return Ok(value);
            }
            if start.elapsed() > patience {
                let words = self.words()?;
                let status = self.run("return window.endcomfort?.status()", &[])?;
                let console = self.console()?.join("\n");
                bail!("waited {patience:?} for {what}\npage: {words}\nstatus: {status}\nconsole: {console}");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until the program has drawn its first picture.
    ///
    /// # Errors
    /// When that does not happen within a minute.
    pub fn wait_until_it_runs(&self) -> Result<()> {
        let expression = "document.getElementById('status').classList.contains('running')";
        self.wait_for("the first picture", expression, Duration::from_secs(60))?;
        Ok(())
    }

    /// Waits until the page explains why it does not run, and returns its words.
    ///
    /// # Errors
    /// When that does not happen within half a minute.
    pub fn wait_for_explanation(&self) -> Result<String> {
        let expression = "document.getElementById('status').classList.contains('failed')";
        self.wait_for("an explanation", expression, Duration::from_secs(30))?;
        self.words()
    }

    /// What the page's status element says.
    ///
    /// # Errors
    /// When the page has none.
    pub fn words(&self) -> Result<String> {
        let words = self.run("return document.getElementById('status').innerText", &[])?;
        Ok(words.as_str().context("the page has no status element")?.to_owned())
    }

    /// The state of the interface: `window.endcomfort.status()`.
    ///
    /// # Errors
    /// When the program does not run, or says what is no JSON.
    pub fn status(&self) -> Result<Value> {
        let text = self.run("return window.endcomfort.status()", &[])?;
        serde_json::from_str(text.as_str().context("the program does not run")?).context("the status is no JSON")
    }

    /// Waits until the interface's state satisfies a condition, and returns it.
    ///
    /// # Errors
    /// When that does not happen in time.
    pub fn wait_for_status(&self, what: &str, patience: Duration, holds: impl Fn(&Value) -> bool) -> Result<Value> {
        let start = now();
        loop {
            let status = self.status()?;
            if holds(&status) {
                return Ok(status);
            }
            if start.elapsed() > patience {
                bail!("waited {patience:?} for {what}; the status is {status:#}\n{}", self.console()?.join("\n"));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Waits until no frame is drawn any more: what was asked for is on the screen.
    ///
    /// # Errors
    /// When frames are still drawn after a minute.
    pub fn wait_until_it_rests(&self) -> Result<()> {
        let start = now();
        let mut drawn = Value::Null;
        loop {
            let frames = self.status()?["frames"].clone();
            if frames == drawn {
                return Ok(());
            }
            if start.elapsed() > Duration::from_secs(60) {
                bail!("frame {frames} is drawn although nothing happens; the status is {:#}", self.status()?);
            }
            drawn = frames;
            std::thread::sleep(REST);
        }
    }

    /// Drops a file onto the canvas, as a person would.
    ///
    /// # Errors
    /// When the page has no canvas.
    pub fn drop_file(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let script = "
            const transfer = new DataTransfer();
            const bytes = Uint8Array.from(arguments[1].match(/../g) ?? [], (pair) => parseInt(pair, 16));
            transfer.items.add(new File([bytes], arguments[0]));
            for (const type of ['dragover', 'drop'])
                document.getElementById('view').dispatchEvent(
                    new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));";
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.run(script, &[json!(name), json!(digits)])?;
        Ok(())
    }

    /// A screenshot, also stored in `target/screenshots/NAME.png`.
    ///
    /// # Errors
    /// When the browser sends no picture.
    pub fn screenshot(&self, name: &str) -> Result<Picture> {
        // A page that plays in software may keep the browser busy for longer than it waits for a picture.
        let mut answer = self.command("GET", "/screenshot", &Value::Null);
        for _ in 1..SCREENSHOT_ATTEMPTS {
            answer = answer.or_else(|_| self.command("GET", "/screenshot", &Value::Null));
        }
        let answer = answer?;
        let bytes = base64(answer.as_str().context("no screenshot")?).context("the screenshot is no base64")?;
        let folder = screenshots();
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(name).with_extension("png"), &bytes)?;
        Picture::from_png(&bytes)
    }

    /// Every message on the console so far, with its level: `SEVERE …`.
    ///
    /// # Errors
    /// When the driver does not give the log.
    pub fn console(&self) -> Result<Vec<String>> {
        // The driver forgets what it has given.
        let fresh = self.command("POST", "/se/log", &json!({ "type": "browser" }))?;
        let mut logs = self.logs.lock().unwrap_or_else(PoisonError::into_inner);
        for entry in fresh.as_array().into_iter().flatten() {
            let (level, message) = (entry["level"].as_str(), entry["message"].as_str());
            logs.push(format!("{} {}", level.unwrap_or("?"), message.unwrap_or("?")));
        }
        Ok(logs.clone())
    }

    /// The messages that a sound page does not cause: errors and violations of the Content-Security-Policy.
    ///
    /// # Errors
    /// When the driver does not give the log.
    pub fn complaints(&self) -> Result<Vec<String>> {
        let mut console = self.console()?;
        console.retain(|line| line.starts_with("SEVERE") || line.contains("Content Security Policy"));
        Ok(console)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.driver.command("DELETE", &format!("/session/{}", self.session), None);
    }
}

#[expect(clippy::disallowed_methods, reason = "the tests themselves do not run in a browser")]
fn now() -> Instant {
    Instant::now()
}

fn screenshots() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/screenshots")
}

/// The bytes of standard base64 (RFC 4648); `None` at a character that does not belong to it.
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0_u32);
    for character in text.bytes().filter(|&character| character != b'=') {
        let value = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_reads_the_vectors_of_rfc_4648() {
        for (text, bytes) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmFy", "foobar")] {
            assert_eq!(base64(text).unwrap(), bytes.as_bytes(), "{text:?}");
        }
        assert_eq!(base64("Zm9v\n"), None);
    }
}
