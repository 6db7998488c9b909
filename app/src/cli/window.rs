//! `view`, and no subcommand: the window.

use super::{Failure, input};
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
    if !has_display() {
        return Err(Failure::new("there is no display to open a window on").with_details(vec![
            "in a browser: cargo xtask serve".into(),
            "as a picture: endcomfort render mustard --out mustard.png".into(),
        ]));
    }
    let gallery = args.demo.is_none() && args.link.is_none();
    let start = StartOptions { demo: args.demo, link: args.link, gallery, ..StartOptions::default() };
    window::open(start).map_err(Failure::new)
}

/// On Linux a window needs an X or Wayland server; elsewhere there always is one.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || set("DISPLAY") || set("WAYLAND_DISPLAY")
}
