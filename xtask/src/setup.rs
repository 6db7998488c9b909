//! What a machine needs beside Rust: a browser with its driver, and a Vulkan driver that needs no GPU.
//!
//! On Debian and Ubuntu what is missing is installed; elsewhere one sentence says what to install.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail};

use crate::process;

/// Something that the tests need.
struct Need {
    /// What it is for, for a person.
    what: &'static str,
    /// Debian package.
    package: &'static str,
    present: fn() -> bool,
}

const NEEDS: [Need; 3] = [
    Need { what: "Chromium", package: "chromium", present: || process::find(&["chromium"]).is_some() },
    Need { what: "ChromeDriver", package: "chromium-driver", present: || process::find(&["chromedriver"]).is_some() },
    Need {
        what: "a Vulkan driver that draws without a GPU (lavapipe)",
        package: "mesa-vulkan-drivers",
        present: || !cfg!(target_os = "linux") || has_lavapipe(Path::new("/usr/share/vulkan/icd.d")),
    },
];

/// Installs what the tests need and this machine lacks.
pub(crate) fn for_tests() -> Result<()> {
    let missing: Vec<&Need> = NEEDS.iter().filter(|need| !(need.present)()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let packages: Vec<&str> = missing.iter().map(|need| need.package).collect();
    let what: Vec<&str> = missing.iter().map(|need| need.what).collect();
    if !install(&packages)? {
        bail!(
            "the tests need {}: please install it (Debian and Ubuntu: sudo apt-get install {})",
            what.join(", "),
            packages.join(" ")
        );
    }
    match missing.iter().find(|need| !(need.present)()) {
        Some(need) => bail!("{} is still not found after installing the package {}", need.what, need.package),
        None => Ok(()),
    }
}

/// Installs Debian packages; `false` where there is no apt-get or no right to use it.
pub(crate) fn install(packages: &[&str]) -> Result<bool> {
    let Some(apt) = process::find(&["apt-get"]) else { return Ok(false) };
    let is_root = process::output(Command::new("id").arg("-u")).as_deref() == Some("0");
    let may_sudo = || process::output(Command::new("sudo").args(["-n", "true"])).is_some();
    if !is_root && !may_sudo() {
        return Ok(false);
    }
    let apt_get = |args: &[&str]| {
        let mut command = Command::new(if is_root { apt.as_os_str() } else { "sudo".as_ref() });
        if !is_root {
            command.arg("-n").arg("env").arg("DEBIAN_FRONTEND=noninteractive").arg(&apt);
        }
        command.env("DEBIAN_FRONTEND", "noninteractive").args(args);
        process::run(&mut command)
    };
    println!("installing {}", packages.join(", "));
    let mut arguments = vec!["install", "-y", "-q", "--no-install-recommends"];
    arguments.extend(packages);
    // The lists of a fresh machine may be old or absent; packages that install without new lists need none.
    if apt_get(&arguments).is_err() {
        apt_get(&["update", "-q"])?;
        apt_get(&arguments)?;
    }
    Ok(true)
}

fn has_lavapipe(folder: &Path) -> bool {
    std::fs::read_dir(folder)
        .is_ok_and(|files| files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("lvp_icd")))
}
