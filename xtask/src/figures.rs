//! `cargo xtask figures`: the pictures of the gallery and of the README, drawn by the program itself.

use std::process::Command;

use anyhow::{Result, bail};

use crate::{process, setup, thumbnail};

/// A picture: where it goes, and what `endcomfort render` is asked for.
struct Figure {
    path: &'static str,
    arguments: &'static [&'static str],
}

/// Where the pictures of the gallery are.
const GALLERY: &str = "objects/scenes/";

const FIGURES: [Figure; 16] = [
    Figure { path: "objects/scenes/mustard.jpg", arguments: &["mustard", "--time", "13.5", "--size", "360x240"] },
    Figure { path: "objects/scenes/jar.jpg", arguments: &["jar", "--time", "9.6", "--size", "360x240"] },
    Figure { path: "objects/scenes/glass.jpg", arguments: &["glass", "--time", "14", "--size", "360x240"] },
    Figure { path: "objects/scenes/box-in.jpg", arguments: &["box-in", "--time", "9", "--size", "360x240"] },
    Figure { path: "objects/scenes/box-on.jpg", arguments: &["box-on", "--time", "12", "--size", "360x240"] },
    Figure { path: "objects/scenes/across.jpg", arguments: &["across", "--time", "12.5", "--size", "360x240"] },
    Figure { path: "objects/scenes/pour.jpg", arguments: &["pour", "--time", "33", "--size", "360x240"] },
    Figure { path: "objects/scenes/regrasp.jpg", arguments: &["regrasp", "--time", "36", "--size", "360x240"] },
    Figure {
        path: "objects/scenes/self-handover.jpg",
        arguments: &["self-handover", "--time", "29", "--size", "360x240", "--camera", "2.1,-0.2,1.9,0.3,0.0,0.85"],
    },
    Figure {
        path: "objects/scenes/butler.jpg",
        arguments: &["butler", "--time", "24", "--size", "360x240", "--camera", "1.9,-0.1,1.75,0.25,-0.62,0.95"],
    },
    Figure {
        path: "objects/scenes/kneeling.jpg",
        arguments: &["kneeling", "--time", "26", "--size", "360x240", "--camera", "1.9,-0.1,1.6,0.25,-0.6,0.8"],
    },
    Figure {
        path: "objects/scenes/stool.jpg",
        arguments: &["stool", "--time", "22", "--size", "360x240", "--camera", "2.5,0.2,1.9,0.3,-0.65,1.25"],
    },
    Figure {
        path: "objects/scenes/human.jpg",
        arguments: &["human", "--time", "19", "--size", "360x240", "--camera", "2.4,0.3,1.8,0.35,-0.75,1.15"],
    },
    Figure { path: "docs/grasps.png", arguments: &["glass", "--size", "960x600", "--theme", "light"] },
    Figure { path: "docs/plan.png", arguments: &["pour", "--time", "33", "--size", "960x600"] },
    Figure {
        path: "docs/handover.png",
        arguments: &["butler", "--time", "24", "--size", "960x600", "--camera", "1.9,-0.1,1.75,0.25,-0.62,0.95"],
    },
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
        let is_thumbnail = figure.path.starts_with(GALLERY);
        let drawn = root.join(if is_thumbnail { "target/thumbnail.png" } else { figure.path });
        render.arg("render").args(figure.arguments).arg("--out").arg(&drawn);
        process::run(&mut render)?;
        if is_thumbnail {
            thumbnail::shrink(&drawn, &root.join(figure.path))?;
        }
    }
    Ok(())
}
