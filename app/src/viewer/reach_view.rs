//! How reachability maps are shown: whose voxels, what colours them, and which of them.

use nalgebra::Vector3;

/// Whose voxels are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReachArms {
    /// Those of the left arm.
    Left,
    /// Those of the right arm.
    Right,
    /// Those that either arm reaches, with the greater value where both do.
    #[default]
    Both,
    /// Those that both arms reach, with the smaller value.
    Overlap,
}

impl ReachArms {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Both, Self::Overlap];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Left => "Left",
            Self::Right => "Right",
            Self::Both => "Both",
            Self::Overlap => "Overlap",
        }
    }

    /// Whether the map of the left arm (0) or of the right one (1) is needed.
    pub fn needs(self, arm: usize) -> bool {
        match self {
            Self::Left => arm == 0,
            Self::Right => arm == 1,
            Self::Both | Self::Overlap => true,
        }
    }
}

/// What colours the voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReachQuantity {
    /// Mean manipulability of the reached orientations.
    Manipulability,
    /// Share of the orientations that is reached.
    #[default]
    Fraction,
}

impl ReachQuantity {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Fraction, Self::Manipulability];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Manipulability => "mean manipulability",
            Self::Fraction => "orientations reached",
        }
    }

    /// Unit of the numbers that a person reads, and how many of it are 1.
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Manipulability => ("", 1.0),
            Self::Fraction => ("%", 100.0),
        }
    }
}

/// Which voxels a plane across an axis of the world leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// All of them.
    #[default]
    All,
    /// Those before the plane.
    Below,
    /// Those beyond it.
    Above,
    /// Those that it cuts.
    Slice,
}

impl Keep {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::All, Self::Below, Self::Above, Self::Slice];
}

/// A plane across an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// What it leaves.
    pub keep: Keep,
    /// Where it stands, metres.
    pub at_m: f64,
}

impl Slice {
    /// Whether a voxel is left: its centre stands at `at_m` and it reaches `half_m` to either side.
    pub fn leaves(&self, at_m: f64, half_m: f64) -> bool {
        match self.keep {
            Keep::All => true,
            Keep::Below => at_m <= self.at_m,
            Keep::Above => at_m >= self.at_m,
            Keep::Slice => (at_m - self.at_m).abs() <= half_m,
        }
    }
}

/// How reachability maps are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachView {
    /// Whose voxels.
    pub arms: ReachArms,
    /// What colours them.
    pub quantity: ReachQuantity,
    /// Whether equal ratios of it are equally far apart in colour.
    pub is_log: bool,
    /// Voxels with less of it are left out.
    pub least: f64,
    /// Planes across x, y and z of the world.
    pub slices: [Slice; 3],
    /// Whether voxels with little of it are see-through.
    pub fades: bool,
}

impl Default for ReachView {
    /// Both arms, cut open: the outside of a map is its poorest part and hides the rest.
    fn default() -> Self {
        let off = |at_m: f64| Slice { keep: Keep::All, at_m };
        Self {
            arms: ReachArms::default(),
            quantity: ReachQuantity::default(),
            is_log: false,
            least: 0.0,
            slices: [Slice { keep: Keep::Below, at_m: 0.3 }, off(0.0), off(1.0)],
            fades: false,
        }
    }
}

impl ReachView {
    /// Whether a voxel is left by all planes: its centre in the world, and how far it reaches along each axis.
    pub fn leaves(&self, p_W: &Vector3<f64>, half_m: &Vector3<f64>) -> bool {
        (0..3).all(|axis| self.slices[axis].leaves(p_W[axis], half_m[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_leaves_what_is_asked_of_it() {
        let left = |keep: Keep| {
            let slice = Slice { keep, at_m: 0.1 };
            [0.0, 0.08, 0.12, 0.2].map(|at_m| slice.leaves(at_m, 0.025))
        };
        assert_eq!(left(Keep::All), [true; 4]);
        assert_eq!(left(Keep::Below), [true, true, false, false]);
        assert_eq!(left(Keep::Above), [false, false, true, true]);
        assert_eq!(left(Keep::Slice), [false, true, true, false]);
    }

    #[test]
    fn a_voxel_must_pass_all_three_planes() {
        let mut view = ReachView { slices: [Slice { keep: Keep::All, at_m: 0.0 }; 3], ..ReachView::default() };
        view.slices[0].keep = Keep::Above;
        view.slices[2] = Slice { keep: Keep::Slice, at_m: 1.0 };
        let half = Vector3::repeat(0.025);
        assert!(view.leaves(&Vector3::new(0.2, -5.0, 1.01), &half));
        assert!(!view.leaves(&Vector3::new(-0.2, 0.0, 1.01), &half));
        assert!(!view.leaves(&Vector3::new(0.2, 0.0, 1.05), &half));
    }
}
