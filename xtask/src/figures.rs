//! `cargo xtask figures`: the pictures of the gallery and of the README, drawn by the program itself.

use std::process::Command;

use anyhow::{Result, bail};

use crate::{process, setup};

/// A picture: where it goes, and what `endcomfort render` is asked for.
struct Figure {
    path: &'static str,
    arguments: &'static [&'static str],
}

const FIGURES: [Figure; 10] = [
    Figure { path: "objects/scenes/mustard.png", arguments: &["mustard", "--time", "13.5", "--size", "360x240"] },
    Figure { path: "objects/scenes/jar.png", arguments: &["jar", "--time", "9.6", "--size", "360x240"] },
    Figure { path: "objects/scenes/glass.png", arguments: &["glass", "--time", "14", "--size", "360x240"] },
    Figure { path: "objects/scenes/box-in.png", arguments: &["box-in", "--time", "9", "--size", "360x240"] },
    Figure { path: "objects/scenes/box-on.png", arguments: &["box-on", "--time", "12", "--size", "360x240"] },
    Figure { path: "objects/scenes/across.png", arguments: &["across", "--time", "12.5", "--size", "360x240"] },
    Figure { path: "objects/scenes/pour.png", arguments: &["pour", "--time", "33", "--size", "360x240"] },
    Figure { path: "objects/scenes/regrasp.png", arguments: &["regrasp", "--time", "36", "--size", "360x240"] },
    Figure { path: "docs/grasps.png", arguments: &["glass", "--size", "960x600", "--theme", "light"] },
    Figure { path: "docs/plan.png", arguments: &["pour", "--time", "33", "--size", "960x600"] },
];

/// Draws every picture.
pub(crate) fn command(args: &[String]) -> Result<()> {
    if let Some(arg) = args.first() {
        bail!("`figures` has no option {arg:?}");
    }
    setup::for_tests()?;
    // With the whole workspace, so that the libraries compiled for the tests serve here too.
    process::run(process::cargo().args(["build", "--workspace", "--bin", "endcomfort"]))?;
    let root = process::root();
    std::fs::create_dir_all(root.join("docs"))?;
    for figure in FIGURES {
        let mut render = Command::new(root.join("target/debug/endcomfort"));
        render.arg("render").args(figure.arguments).arg("--out").arg(root.join(figure.path));
        process::run(&mut render)?;
    }
    Ok(())
}
