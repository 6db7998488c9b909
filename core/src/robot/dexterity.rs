//! Forward kinematics, Jacobian and manipulability of a chain, one configuration or sixteen side by side.
//!
//! `det(J Jᵀ)` is the same for every reference point and frame, since both only multiply J by a matrix of determinant 1.
//! So the Jacobian is taken at the base's origin, where each column is known as soon as its joint is placed, and the
//! determinant comes from the `L D Lᵀ` factors of the Gram matrix, fixed in size. One code runs one lane or many, and
//! every lane does the same operations in the same order: an answer has the same bits alone, in a batch, with narrow
//! and wide vectors. The same code in single precision is twice as fast, for searches whose winners are placed again.

use nalgebra::{Matrix3, Vector3};

use super::Chain;
use super::chain::ChainJoint;
use super::trig::{fast_sin_cos, fast_sin_cos_single};
use crate::simd::{Kernel, widest};

/// Configurations side by side in a batch.
const WIDE: usize = 16;
/// Entries of a symmetric 6 × 6 matrix.
const GRAM: usize = 21;

/// Where the tip of a chain is at a configuration, in the base frame B, and how freely it moves there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Rotation of the tip.
    pub R_BH: Matrix3<f64>,
    /// Position of the tip, metres.
    pub p_BH: Vector3<f64>,
    /// Manipulability `√det(J Jᵀ)` (5.1).
    pub manipulability: f64,
}

/// As [`Placed`], in single precision: position to some 1e-6 m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rough {
    /// Rotation of the tip, row by row.
    pub(crate) R_BH: [f32; 9],
    pub(crate) p_BH: [f32; 3],
    pub(crate) manipulability: f32,
}

/// Places the tips of a chain; keeps its working memory, so that nothing is allocated per configuration.
#[derive(Clone, Debug)]
pub struct Dexterity<'a> {
    chain: &'a Chain,
    one: Lanes<f64, 1>,
    wide: Lanes<f64, WIDE>,
}

/// As [`Dexterity`], in single precision and in whole batches only.
#[derive(Clone, Debug)]
pub(crate) struct RoughDexterity<'a> {
    chain: &'a Chain,
    wide: Lanes<f32, WIDE>,
}

/// A number of either precision.
trait Real:
    Copy
    + PartialOrd
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::AddAssign
    + std::ops::SubAssign
    + std::ops::MulAssign
{
    const ZERO: Self;
    const ONE: Self;
    const LEAST: Self;
    fn of(value: f64) -> Self;
    fn root(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const LEAST: Self = Self::MIN_POSITIVE;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        fast_sin_cos(self)
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const LEAST: Self = Self::MIN_POSITIVE;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        fast_sin_cos_single(self)
    }
}

/// Memory of L configurations; the innermost index is the configuration.
#[derive(Clone, Debug)]
struct Lanes<T, const L: usize> {
    /// `[ω; v]` at the origin of B, per column of `q`.
    columns: Vec<[[T; L]; 6]>,
    R: [[T; L]; 9],
    t: [[T; L]; 3],
    manipulability: [T; L],
}

impl<'a> Dexterity<'a> {
    /// For this chain.
    pub fn new(chain: &'a Chain) -> Self {
        Self { chain, one: Lanes::new(chain.dofs().len()), wide: Lanes::new(chain.dofs().len()) }
    }

    /// One configuration; `q` has one value per degree of freedom of the chain.
    pub fn at(&mut self, q: &[f64]) -> Placed {
        self.one.place(self.chain, q);
        self.one.placed(0)
    }

    /// Many configurations, one after the other in `q`; what is left over by a whole number of them is not looked at.
    pub fn all(&mut self, q: &[f64], placed: &mut Vec<Placed>) {
        placed.clear();
        let chunks = q.chunks_exact(WIDE * self.chain.dofs().len());
        let rest = chunks.remainder().chunks_exact(self.chain.dofs().len());
        for chunk in chunks {
            widest(Sixteen { lanes: &mut self.wide, chain: self.chain, q: chunk });
            placed.extend((0..WIDE).map(|k| self.wide.placed(k)));
        }
        placed.extend(rest.map(|q| self.at(q)));
    }
}

impl<'a> RoughDexterity<'a> {
    /// For this chain.
    pub(crate) fn new(chain: &'a Chain) -> Self {
        Self { chain, wide: Lanes::new(chain.dofs().len()) }
    }

    /// Many configurations, a whole number of sixteens; what is left over is not looked at.
    pub(crate) fn all(&mut self, q: &[f64], placed: &mut Vec<Rough>) {
        placed.clear();
        for chunk in q.chunks_exact(WIDE * self.chain.dofs().len()) {
            widest(Sixteen { lanes: &mut self.wide, chain: self.chain, q: chunk });
            let Lanes { R, t, manipulability, .. } = &self.wide;
            placed.extend((0..WIDE).map(|k| Rough {
                R_BH: R.each_ref().map(|entry| entry[k]),
                p_BH: t.each_ref().map(|entry| entry[k]),
                manipulability: manipulability[k],
            }));
        }
    }
}

/// One chunk of a batch.
struct Sixteen<'a, T> {
    lanes: &'a mut Lanes<T, WIDE>,
    chain: &'a Chain,
    q: &'a [f64],
}

impl<T: Real> Kernel for Sixteen<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.lanes.place(self.chain, self.q);
    }
}

impl<const L: usize> Lanes<f64, L> {
    fn placed(&self, k: usize) -> Placed {
        let R_BH = Matrix3::from_fn(|i, j| self.R[3 * i + j][k]);
        let p_BH = Vector3::from_fn(|i, _| self.t[i][k]);
        Placed { R_BH, p_BH, manipulability: self.manipulability[k] }
    }
}

#[expect(clippy::needless_range_loop, reason = "k is the configuration in every array of a lane's arithmetic")]
impl<T: Real, const L: usize> Lanes<T, L> {
    fn new(columns: usize) -> Self {
        let zero = [T::ZERO; L];
        Self { columns: vec![[zero; 6]; columns], R: [zero; 9], t: [zero; 3], manipulability: zero }
    }

    /// L configurations, one after the other in `q`.
    #[inline(always)]
    fn place(&mut self, chain: &Chain, q: &[f64]) {
        let stride = self.columns.len();
        self.columns.fill([[T::ZERO; L]; 6]);
        for (entry, row) in self.R.iter_mut().enumerate() {
            *row = [if entry % 4 == 0 { T::ONE } else { T::ZERO }; L];
        }
        self.t = [[T::ZERO; L]; 3];
        for joint in &chain.joints {
            let mut position = [T::ZERO; L];
            for (k, position) in position.iter_mut().enumerate() {
                *position = T::of(joint.multiplier * q[k * stride + joint.column] + joint.offset);
            }
            self.fixed(&rows(&joint.X_PJ.R).map(T::of), &<[f64; 3]>::from(joint.X_PJ.t).map(T::of));
            if joint.slides {
                self.slide(joint, &position);
            } else {
                self.turn(joint, &position);
            }
        }
        self.fixed(&rows(&chain.X_JH.R).map(T::of), &<[f64; 3]>::from(chain.X_JH.t).map(T::of));
        self.measure();
    }

    /// Goes on by a constant transform.
    #[inline(always)]
    fn fixed(&mut self, X: &[T; 9], x: &[T; 3]) {
        for i in 0..3 {
            for k in 0..L {
                let (a, b, c) = (self.R[3 * i][k], self.R[3 * i + 1][k], self.R[3 * i + 2][k]);
                self.t[i][k] += a * x[0] + b * x[1] + c * x[2];
                self.R[3 * i][k] = a * X[0] + b * X[3] + c * X[6];
                self.R[3 * i + 1][k] = a * X[1] + b * X[4] + c * X[7];
                self.R[3 * i + 2][k] = a * X[2] + b * X[5] + c * X[8];
            }
        }
    }

    /// Goes on by a turn about z and adds its column: ω along the axis, v of the origin.
    #[inline(always)]
    fn turn(&mut self, joint: &ChainJoint, position: &[T; L]) {
        let column = &mut self.columns[joint.column];
        for k in 0..L {
            let m = T::of(joint.multiplier);
            let (x, y, z) = (m * self.R[2][k], m * self.R[5][k], m * self.R[8][k]);
            let (px, py, pz) = (self.t[0][k], self.t[1][k], self.t[2][k]);
            column[0][k] += x;
            column[1][k] += y;
            column[2][k] += z;
            column[3][k] += py * z - pz * y;
            column[4][k] += pz * x - px * z;
            column[5][k] += px * y - py * x;
        }
        for k in 0..L {
            let (sin, cos) = position[k].sin_cos();
            for i in 0..3 {
                let (x, y) = (self.R[3 * i][k], self.R[3 * i + 1][k]);
                self.R[3 * i][k] = x * cos + y * sin;
                self.R[3 * i + 1][k] = y * cos - x * sin;
            }
        }
    }

    /// Goes on by a way along z and adds its column.
    #[inline(always)]
    fn slide(&mut self, joint: &ChainJoint, position: &[T; L]) {
        let column = &mut self.columns[joint.column];
        for i in 0..3 {
            for k in 0..L {
                let along = self.R[3 * i + 2][k];
                column[3 + i][k] += T::of(joint.multiplier) * along;
                self.t[i][k] += along * position[k];
            }
        }
    }

    /// `√det(J Jᵀ)` from the factors `L D Lᵀ` of the Gram matrix.
    #[inline(always)]
    fn measure(&mut self) {
        // Entry (i, j), j ≤ i, stands at i (i + 1) / 2 + j.
        let mut gram = [[T::ZERO; L]; GRAM];
        for column in &self.columns {
            for i in 0..6 {
                for j in 0..=i {
                    let entry = &mut gram[i * (i + 1) / 2 + j];
                    for k in 0..L {
                        entry[k] += column[i][k] * column[j][k];
                    }
                }
            }
        }
        let mut determinant = [T::ONE; L];
        for pivot in 0..6 {
            let diagonal = gram[pivot * (pivot + 1) / 2 + pivot];
            let mut inverse = [T::ZERO; L];
            for k in 0..L {
                // Nothing is left below a pivot of 0, and the determinant is 0 whatever follows.
                let is_positive = diagonal[k] > T::LEAST;
                inverse[k] = if is_positive { T::ONE / diagonal[k] } else { T::ZERO };
                determinant[k] *= if is_positive { diagonal[k] } else { T::ZERO };
            }
            for i in pivot + 1..6 {
                let below = gram[i * (i + 1) / 2 + pivot];
                for j in pivot + 1..=i {
                    let across = gram[j * (j + 1) / 2 + pivot];
                    let entry = &mut gram[i * (i + 1) / 2 + j];
                    for k in 0..L {
                        entry[k] -= below[k] * inverse[k] * across[k];
                    }
                }
            }
        }
        for k in 0..L {
            self.manipulability[k] = determinant[k].root();
        }
    }
}

/// Row by row.
fn rows(R: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|entry| R[(entry / 3, entry % 3)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::{Arm, Robot, samples};

    fn arms() -> Vec<(Robot, Arm)> {
        let mut arms = Vec::new();
        for robot in [samples::crichton(), samples::alita()] {
            for arm in robot.arms.clone() {
                arms.push((robot.clone(), robot.arm_with_torso(&arm)));
                arms.push((robot.clone(), arm));
            }
        }
        arms
    }

    fn random_configurations(chain: &Chain, count: usize) -> Vec<f64> {
        let mut rng = Rng::new(9, 0);
        let draw = |_| chain.limits().iter().map(|l| rng.uniform(l.lower, l.upper)).collect::<Vec<_>>();
        (0..count).flat_map(draw).collect()
    }

    #[test]
    fn pose_and_manipulability_are_those_of_the_whole_robot() {
        for (robot, arm) in arms() {
            let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
            let mut dexterity = Dexterity::new(&chain);
            for q in random_configurations(&chain, 300).chunks_exact(chain.dofs().len()) {
                let mut full = vec![0.0; robot.dof_count()];
                arm.dofs.iter().zip(q).for_each(|(&dof, value)| full[dof] = *value);
                let X_WL = robot.link_poses(&full);
                let X_BH = X_WL[arm.base_link].inverse() * X_WL[arm.hand.tcp_link];
                let placed = dexterity.at(q);
                assert!((placed.p_BH - X_BH.translation.vector).norm() < 1e-13);
                assert!((placed.R_BH - X_BH.rotation.to_rotation_matrix().into_inner()).norm() < 1e-13);
                let wanted = robot.manipulability(&arm, &X_WL);
                // Both lose half of the digits near a singular posture: an error of ε in det is ε / (2 m) in m.
                let tolerance = (1e-14 / wanted.max(1e-9)).min(1e-7) + 1e-12;
                assert!((placed.manipulability - wanted).abs() < tolerance, "{} {wanted}", placed.manipulability);
            }
        }
    }

    #[test]
    fn a_batch_has_the_bits_of_its_configurations_one_by_one() {
        for (robot, arm) in arms() {
            let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
            let mut dexterity = Dexterity::new(&chain);
            let q = random_configurations(&chain, 5 * WIDE + 3);
            let mut batch = Vec::new();
            dexterity.all(&q, &mut batch);
            let alone: Vec<Placed> = q.chunks_exact(chain.dofs().len()).map(|q| dexterity.at(q)).collect();
            assert_eq!(batch, alone);
        }
    }

    #[test]
    fn single_precision_is_near() {
        for (robot, arm) in arms() {
            let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
            let q = random_configurations(&chain, 20 * WIDE);
            let (mut rough, mut placed) = (Vec::new(), Vec::new());
            RoughDexterity::new(&chain).all(&q, &mut rough);
            Dexterity::new(&chain).all(&q, &mut placed);
            assert_eq!(rough.len(), placed.len());
            for (rough, placed) in rough.iter().zip(&placed) {
                for i in 0..3 {
                    assert!((f64::from(rough.p_BH[i]) - placed.p_BH[i]).abs() < 3e-6);
                    (0..3).for_each(|j| assert!((f64::from(rough.R_BH[3 * i + j]) - placed.R_BH[(i, j)]).abs() < 5e-6));
                }
                assert!((f64::from(rough.manipulability) - placed.manipulability).abs() < 3e-4);
            }
        }
    }

    #[test]
    fn a_singular_posture_has_no_manipulability() {
        let (robot, arm) = arms().swap_remove(1);
        let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
        let m = Dexterity::new(&chain).at(&[0.0; 7]).manipulability;
        assert!((0.0..1e-7).contains(&m), "{m}");
    }
}
