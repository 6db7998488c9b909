//! Options of `render`: how the points are drawn, and where the picture is cut open.

use clap::ValueEnum;

use super::reach_options::slice;
use crate::render::Cut;
use crate::viewer::{CloudColor, CloudLook, Keep};

#[derive(clap::Args)]
#[group(skip)]
pub(super) struct Options {
    /// What colours the points of the cloud.
    #[arg(long, value_enum, default_value = "fate", help_heading = "Looking closely")]
    color_by: ColorName,
    /// Diameter of a point, millimetres.
    #[arg(long, value_name = "MM", default_value_t = 2.2, value_parser = diameter, help_heading = "Looking closely")]
    point_size: f64,
    /// Takes away what is not on this side of a plane of the world: `x<0.5`, `z>0.8`.
    #[arg(long, value_name = "AXIS<M", value_parser = cut, help_heading = "Looking closely")]
    cut: Option<Cut>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ColorName {
    /// Its cluster, the table, rejected.
    Fate,
    /// The colours that came with the cloud.
    Own,
    /// Height above the floor.
    Height,
    /// Distance from the camera.
    Distance,
}

fn diameter(text: &str) -> Result<f64, String> {
    let parsed = text.parse::<f64>().ok().filter(|mm| (0.1..=50.0).contains(mm));
    parsed.ok_or_else(|| format!("found {text:?}, wanted millimetres from 0.1 to 50"))
}

fn cut(text: &str) -> Result<Cut, String> {
    let (axis, slice) = slice(text)?;
    match slice.keep {
        Keep::Below => Ok(Cut { axis, at_m: slice.at_m, keeps_above: false }),
        Keep::Above => Ok(Cut { axis, at_m: slice.at_m, keeps_above: true }),
        Keep::All | Keep::Slice => Err(format!("found {text:?}, wanted the side that stays, as in x<0.5")),
    }
}

impl Options {
    /// How points are drawn.
    pub(super) fn cloud_look(&self) -> CloudLook {
        let by = match self.color_by {
            ColorName::Fate => CloudColor::Fate,
            ColorName::Own => CloudColor::Own,
            ColorName::Height => CloudColor::Height,
            ColorName::Distance => CloudColor::Distance,
        };
        CloudLook { by, diameter_m: (1e-3 * self.point_size) as f32 }
    }

    /// What is taken away.
    pub(super) fn cut(&self) -> Option<Cut> {
        self.cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_says_which_side_stays() {
        assert_eq!(cut("x<0.5"), Ok(Cut { axis: 0, at_m: 0.5, keeps_above: false }));
        assert_eq!(cut("z>0.8"), Ok(Cut { axis: 2, at_m: 0.8, keeps_above: true }));
        for wrong in ["z=0.8", "0.8", "w<1"] {
            assert!(cut(wrong).unwrap_err().contains("wanted"), "{wrong}");
        }
        assert!(diameter("0").unwrap_err().contains("0.1 to 50"));
    }
}
