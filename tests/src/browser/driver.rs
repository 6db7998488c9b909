//! A running ChromeDriver.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

use anyhow::{Context as _, Result, bail};
use serde_json::Value;

use super::http;

/// A ChromeDriver process on a free port; it ends when this is dropped.
pub struct Driver {
    process: Child,
    port: u16,
}

impl Driver {
    /// Starts `chromedriver` and waits until it listens.
    ///
    /// # Errors
    /// When it is not installed, or does not say on which port it listens.
    pub fn start() -> Result<Self> {
        let mut process = Command::new("chromedriver")
            .arg("--port=0")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("chromedriver cannot be started; `cargo xtask test` installs it on Debian and Ubuntu")?;
        let mut lines = BufReader::new(process.stdout.take().context("chromedriver has no output")?).lines();
        let mut heard = Vec::new();
        while let Some(Ok(line)) = lines.next() {
            // "ChromeDriver was started successfully on port 43127."
            let port = line
                .split_once("started successfully on port ")
                .and_then(|(_, rest)| rest.trim_end_matches('.').parse().ok());
            if let Some(port) = port {
                // Whatever it says from now on is read and dropped, so that it never waits for a reader.
                std::thread::spawn(move || lines.for_each(drop));
                return Ok(Self { process, port });
            }
            heard.push(line);
        }
        let _ = process.kill();
        bail!("chromedriver did not say on which port it listens; it said:\n{}", heard.join("\n"))
    }

    /// Sends a WebDriver command and returns its `value`.
    ///
    /// # Errors
    /// What the driver answers when the command fails.
    pub fn command(&self, method: &str, path: &str, body: Option<&Value>) -> Result<Value> {
        let (status, mut answer) = http::request(self.port, method, path, body)?;
        let value = answer["value"].take();
        if status != 200 {
            let (error, message) = (value["error"].as_str(), value["message"].as_str());
            bail!("{method} {path}: {}: {}", error.unwrap_or("error"), message.unwrap_or("no message"));
        }
        Ok(value)
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
