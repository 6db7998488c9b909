//! No subcommand: the window.

use super::Failure;
use crate::window;

pub(super) fn run() -> Result<(), Failure> {
    if !has_display() {
        return Err(Failure::new("there is no display to open a window on").with_details(vec![
            "in a browser: cargo xtask serve".into(),
            "as a picture: endcomfort render mustard --out mustard.png".into(),
        ]));
    }
    window::open().map_err(Failure::new)
}

/// On Linux a window needs an X or Wayland server; elsewhere there always is one.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || set("DISPLAY") || set("WAYLAND_DISPLAY")
}
