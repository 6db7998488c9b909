//! `view`, and no subcommand: the window.

use super::{Failure, input};
use crate::brought::disk;
use crate::studio::BuiltInStudio;
use crate::viewer::{StartOptions, Studio as _, read_link};
use crate::window;

/// Opens the window with a demo or with what a link holds.
#[derive(clap::Args, Default)]
pub(super) struct Args {
    /// Demo to open; without one and without a link the gallery opens.
    demo: Option<String>,
    /// A link that was copied in the window or on the page: an address with `#s=…`, or that part alone.
    #[arg(long, conflicts_with = "demo")]
    link: Option<String>,
    /// Files to open as if they had been dropped: a robot's folder, URDF or .zip, a cloud, a mesh, a depth image.
    #[arg(long, value_name = "PATH", num_args = 1.., conflicts_with = "link")]
    open: Vec<std::path::PathBuf>,
}

pub(super) fn run(args: Args) -> Result<(), Failure> {
    // What is wrong with the question is said first, also where there is no window to say it in.
    if let Some(link) = &args.link {
        let wrong = |error| Failure::new(format!("the link could not be opened: {error}"));
        read_link(link, &BuiltInStudio::default().demos()).map_err(wrong)?;
    }
    if let Some(name) = &args.demo {
        input::demo(name)?;
    }
    let files = files_of(&args.open)?;
    if !has_display() {
        return Err(Failure::new("there is no display to open a window on").with_details(vec![
            "in a browser: cargo xtask serve".into(),
            "as a picture: endcomfort render mustard --out mustard.png".into(),
        ]));
    }
    let gallery = args.demo.is_none() && args.link.is_none() && files.is_empty();
    let start = StartOptions { demo: args.demo, link: args.link, gallery, files, ..StartOptions::default() };
    window::open(start).map_err(Failure::new)
}

/// The files at paths: of a URDF or an archive with everything that belongs to it.
fn files_of(paths: &[std::path::PathBuf]) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut files = Vec::new();
    for path in paths {
        if disk::is_robot(path) {
            let found = disk::robot_files(path).map_err(Failure::new)?;
            files.extend(found.paths().filter_map(|path| Some((path.to_owned(), found.get(path)?.to_vec()))));
        } else {
            files.extend(disk::all_files(path).map_err(Failure::new)?);
        }
    }
    Ok(files)
}

/// On Linux a window needs an X or Wayland server; elsewhere there always is one.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || set("DISPLAY") || set("WAYLAND_DISPLAY")
}
