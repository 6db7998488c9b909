//! Prepares what the interface carries: its font, thinned to what is shown.

#[path = "build/thin_font.rs"]
mod thin_font;

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build/thin_font.rs");
    let folder = std::env::var_os("OUT_DIR").map(PathBuf::from);
    let (Some(folder), Some(font)) = (folder, thin_font::thin(ttf_inter::REGULAR)) else {
        println!("cargo::error=the font of the interface cannot be thinned");
        return;
    };
    if let Err(error) = std::fs::write(folder.join("inter.ttf"), font) {
        println!("cargo::error=the font of the interface cannot be written: {error}");
    }
}
