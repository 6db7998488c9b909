//! Forward kinematics, Jacobian and manipulability of a chain, one configuration or sixteen side by side.
//!
//! `det(J Jᵀ)` is the same for every reference point and frame, since both only multiply J by a matrix of determinant 1.
//! So the Jacobian is taken at the base's origin, where each column is known as soon as its joint is placed, and the
//! determinant comes from the `L D Lᵀ` factors of the Gram matrix, fixed in size. One code runs one lane or many, and
//! every lane does the same operations in the same order: an answer has the same bits alone, in a batch, with narrow
//! and wide vectors.

use nalgebra::{Matrix3, Vector3};

use super::Chain;
use super::chain::ChainJoint;
use super::trig::fast_sin_cos;
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

/// Places the tips of a chain; keeps its working memory, so that nothing is allocated per configuration.
#[derive(Clone, Debug)]
pub struct Dexterity<'a> {
    chain: &'a Chain,
    one: Lanes<1>,
    wide: Lanes<WIDE>,
}

/// Memory of L configurations; the innermost index is the configuration.
#[derive(Clone, Debug)]
struct Lanes<const L: usize> {
    /// `[ω; v]` at the origin of B, per column of `q`.
    columns: Vec<[[f64; L]; 6]>,
    R: [[f64; L]; 9],
    t: [[f64; L]; 3],
    manipulability: [f64; L],
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

/// One chunk of a batch.
struct Sixteen<'a> {
    lanes: &'a mut Lanes<WIDE>,
    chain: &'a Chain,
    q: &'a [f64],
}

impl Kernel for Sixteen<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.lanes.place(self.chain, self.q);
    }
}

#[expect(clippy::needless_range_loop, reason = "k is the configuration in every array of a lane's arithmetic")]
impl<const L: usize> Lanes<L> {
    fn new(columns: usize) -> Self {
        let zero = [0.0; L];
        Self { columns: vec![[zero; 6]; columns], R: [zero; 9], t: [zero; 3], manipulability: zero }
    }

    fn placed(&self, k: usize) -> Placed {
        let R_BH = Matrix3::from_fn(|i, j| self.R[3 * i + j][k]);
        let p_BH = Vector3::from_fn(|i, _| self.t[i][k]);
        Placed { R_BH, p_BH, manipulability: self.manipulability[k] }
    }

    /// L configurations, one after the other in `q`.
    #[inline(always)]
    fn place(&mut self, chain: &Chain, q: &[f64]) {
        let stride = self.columns.len();
        self.columns.fill([[0.0; L]; 6]);
        for (entry, row) in self.R.iter_mut().enumerate() {
            *row = [if entry % 4 == 0 { 1.0 } else { 0.0 }; L];
        }
        self.t = [[0.0; L]; 3];
        for joint in &chain.joints {
            let mut position = [0.0; L];
            for (k, position) in position.iter_mut().enumerate() {
                *position = joint.multiplier * q[k * stride + joint.column] + joint.offset;
            }
            self.fixed(&rows(&joint.X_PJ.R), &joint.X_PJ.t.into());
            if joint.slides {
                self.slide(joint, &position);
            } else {
                self.turn(joint, &position);
            }
        }
        self.fixed(&rows(&chain.X_JH.R), &chain.X_JH.t.into());
        self.measure();
    }

    /// Goes on by a constant transform.
    #[inline(always)]
    fn fixed(&mut self, X: &[f64; 9], x: &[f64; 3]) {
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
    fn turn(&mut self, joint: &ChainJoint, position: &[f64; L]) {
        let column = &mut self.columns[joint.column];
        for k in 0..L {
            let m = joint.multiplier;
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
            let (sin, cos) = fast_sin_cos(position[k]);
            for i in 0..3 {
                let (x, y) = (self.R[3 * i][k], self.R[3 * i + 1][k]);
                self.R[3 * i][k] = x * cos + y * sin;
                self.R[3 * i + 1][k] = y * cos - x * sin;
            }
        }
    }

    /// Goes on by a way along z and adds its column.
    #[inline(always)]
    fn slide(&mut self, joint: &ChainJoint, position: &[f64; L]) {
        let column = &mut self.columns[joint.column];
        for i in 0..3 {
            for k in 0..L {
                let along = self.R[3 * i + 2][k];
                column[3 + i][k] += joint.multiplier * along;
                self.t[i][k] += along * position[k];
            }
        }
    }

    /// `√det(J Jᵀ)` from the factors `L D Lᵀ` of the Gram matrix.
    #[inline(always)]
    fn measure(&mut self) {
        // Entry (i, j), j ≤ i, stands at i (i + 1) / 2 + j.
        let mut gram = [[0.0; L]; GRAM];
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
        let mut determinant = [1.0; L];
        for pivot in 0..6 {
            let diagonal = gram[pivot * (pivot + 1) / 2 + pivot];
            let mut inverse = [0.0; L];
            for k in 0..L {
                // Nothing is left below a pivot of 0, and the determinant is 0 whatever follows.
                let is_positive = diagonal[k] > f64::MIN_POSITIVE;
                inverse[k] = if is_positive { 1.0 / diagonal[k] } else { 0.0 };
                determinant[k] *= if is_positive { diagonal[k] } else { 0.0 };
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
            self.manipulability[k] = determinant[k].sqrt();
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
    fn a_singular_posture_has_no_manipulability() {
        let (robot, arm) = arms().swap_remove(1);
        let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
        let m = Dexterity::new(&chain).at(&[0.0; 7]).manipulability;
        assert!((0.0..1e-7).contains(&m), "{m}");
    }
}
