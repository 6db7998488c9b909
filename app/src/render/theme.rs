//! The two themes: background, grid and light.

use serde::{Deserialize, Serialize};

/// Dark or light, as in the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// Dark: for screens and demonstrations.
    #[default]
    Dark,
    /// Light: for print and bright rooms.
    Light,
}

/// What a theme means to the shaders. Colours of the background and grid are sRGB, lights are linear.
pub(super) struct Look {
    pub(super) background_center: [f32; 3],
    pub(super) background_edge: [f32; 3],
    /// Grid colour and the opacity of its main lines.
    pub(super) grid: [f32; 4],
    /// Opacity of full shadow on the floor.
    pub(super) floor_shadow: f32,
    /// Warm directional light that casts the shadows.
    pub(super) key: [f32; 3],
    /// Cool light from the other side, without shadows.
    pub(super) fill: [f32; 3],
    /// Ambient light from above.
    pub(super) sky: [f32; 3],
    /// Ambient light from below.
    pub(super) ground: [f32; 3],
}

impl Theme {
    pub(super) fn look(self) -> Look {
        match self {
            Self::Dark => Look {
                background_center: rgb(0x1b, 0x21, 0x29),
                background_edge: rgb(0x0d, 0x10, 0x14),
                grid: [0.30, 0.37, 0.45, 0.42],
                floor_shadow: 0.5,
                key: [1.10, 1.02, 0.91],
                fill: [0.11, 0.145, 0.21],
                sky: [0.19, 0.215, 0.255],
                ground: [0.06, 0.057, 0.055],
            },
            Self::Light => Look {
                background_center: rgb(0xfb, 0xfa, 0xf7),
                background_edge: rgb(0xe4, 0xe6, 0xe4),
                grid: [0.62, 0.65, 0.65, 0.60],
                floor_shadow: 0.17,
                key: [0.80, 0.76, 0.70],
                fill: [0.12, 0.135, 0.16],
                sky: [0.33, 0.345, 0.37],
                ground: [0.20, 0.195, 0.19],
            },
        }
    }
}

fn rgb(r: u8, g: u8, b: u8) -> [f32; 3] {
    [r, g, b].map(|c| f32::from(c) / 255.0)
}
