//! The arm: turned modules with one-sided forks around dark drums, after the shapes of the LWA4D.
//!
//! Every link is drawn in its own frame at q = 0 (z along the straight arm), so both arms share the files.

use std::f64::consts::PI;

use super::Model;
use super::shapes::{Section, ball, lathe, lathe_with, loft, ring};
use super::surface::Surface;

/// A shell whose round foot grows into a plate beside the next joint.
struct Fork {
    /// Height and radius of the foot.
    foot: (f64, f64),
    /// Radius of the round body.
    body_r: f64,
    /// Height of the next joint's axis.
    joint_z: f64,
    /// Radius of the drum that turns there.
    drum_r: f64,
    /// Half width of the plate, which ends round about the joint.
    plate_r: f64,
    /// Inner and outer face of the plate, at negative y.
    plate_y: [f64; 2],
}

impl Fork {
    fn surface(&self) -> Surface {
        let (z0, r0) = self.foot;
        let deck = self.joint_z - self.drum_r - 0.003;
        let body = deck - z0;
        let [inner, outer] = self.plate_y;
        let r = self.body_r;
        let mut sections = vec![
            Section::circle(z0, r0 - 0.004),
            Section::circle(z0 + 0.004, r0),
            Section::circle(z0 + 0.30 * body, 0.5 * (r0 + r)),
        ];
        // The flank that will carry the plate swings out while the other side closes to a deck below the drum.
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        for t in [0.48, 0.66, 0.82, 0.93] {
            let s = ease((t - 0.40f64).max(0.0) / 0.60);
            let half = mix(r, self.plate_r, s);
            sections.push(Section::between(z0 + t * body, [-half, half], [mix(-r, outer, s), r], mix(2.0, 2.4, s)));
        }
        let plate =
            |z: f64, half: f64, y_in: f64, exponent: f64| Section::between(z, [-half, half], [outer, y_in], exponent);
        let round = 0.010;
        for (dz, t) in [(0.60, 0.08), (0.92, 0.30), (1.0, 0.62)] {
            sections.push(plate(deck - round * (1.0 - dz), self.plate_r, mix(r, inner, t), mix(2.4, 3.0, t)));
        }
        for (dz, t) in [(0.004, 0.90), (0.013, 1.0)] {
            sections.push(plate(deck + dz, self.plate_r, mix(r, inner, t), mix(3.0, 4.0, t)));
        }
        for angle in [0.0f64, 0.42, 0.80, 1.12, 1.34, 1.48] {
            let half = self.plate_r * angle.cos();
            let thin = 0.35 * (outer - inner).abs() * (1.0 - angle.cos()).powi(2);
            let z = self.joint_z + self.plate_r * angle.sin();
            sections.push(Section::between(z, [-half, half], [outer + thin, inner - thin], 4.0));
        }
        sections.sort_by(|a, b| a.z.total_cmp(&b.z));
        loft(&sections)
    }

    /// A cap on the plate's outside, at the joint's axis.
    fn cap(&self) -> Surface {
        let r = 0.72 * self.plate_r;
        let y = -self.plate_y[1];
        lathe_with(
            &[
                (r, -0.001, 0.0),
                (r, 0.0026, 0.0018),
                (0.80 * r, 0.0026, 0.001),
                (0.76 * r, 0.0012, 0.001),
                (0.0, 0.0012, 0.0),
            ],
            28,
        )
        .at(0.0, 0.0, y)
        .z_to_y()
        .turned(PI)
        .at(0.0, 0.0, self.joint_z)
    }
}

/// A drum along y that carries a neck along z.
fn drum(r: f64, y: [f64; 2], neck_r: f64, neck_z: f64) -> Surface {
    let soft = 0.34 * r;
    let body = lathe(&[
        (0.80 * r, y[0], 0.0),
        (0.90 * r, y[0], 0.1 * r),
        (r, y[0] + 0.12 * r, 0.2 * r),
        (r, y[1] - 0.25 * r, soft),
        (0.70 * r, y[1], 0.12 * r),
        (0.56 * r, y[1], 0.002),
        (0.53 * r, y[1] - 0.003, 0.002),
        (0.0, y[1] - 0.003, 0.0),
    ])
    .z_to_y();
    let neck = lathe(&[
        (0.84 * neck_r, 0.36 * neck_z, 0.0),
        (neck_r, 0.72 * neck_z, 0.03),
        (neck_r, neck_z, 0.0),
        (0.8 * neck_r, neck_z, 0.0),
    ]);
    body.with(neck)
}

/// Forearm of one arm type: the fork that holds the wrist, `length` from elbow to wrist.
fn forearm(length: f64) -> Fork {
    Fork {
        foot: (0.108, 0.0445),
        body_r: 0.0445,
        joint_z: length,
        drum_r: 0.0500,
        plate_r: 0.0420,
        plate_y: [-0.0440, -0.0715],
    }
}

/// Last link of one arm type: the collar from the wrist to the mount.
fn collar(mount: f64) -> Surface {
    lathe(&[
        (0.030, 0.0330, 0.0),
        (0.0395, 0.0480, 0.012),
        (0.0408, mount - 0.0135, 0.0),
        (0.0385, mount - 0.0105, 0.001),
        (0.0300, mount - 0.0105, 0.0),
    ])
}

fn mount_plate(mount: f64) -> Surface {
    lathe(&[
        (0.0300, mount - 0.0110, 0.0),
        (0.0405, mount - 0.0110, 0.0012),
        (0.0405, mount - 0.0005, 0.0012),
        (0.0, mount - 0.0005, 0.0),
    ])
}

pub(super) fn models() -> Vec<Model> {
    let shoulder = Fork {
        foot: (-0.0175, 0.0655),
        body_r: 0.0655,
        joint_z: 0.240,
        drum_r: 0.066,
        plate_r: 0.0615,
        plate_y: [-0.0620, -0.0930],
    };
    let upper = Fork {
        foot: (0.118, 0.0555),
        body_r: 0.0550,
        joint_z: 0.328,
        drum_r: 0.0565,
        plate_r: 0.0515,
        plate_y: [-0.0525, -0.0820],
    };
    let long = forearm(0.323);
    let short = forearm(0.2765);
    let at_drum = |radius: f64, y: f64| ring(radius, 0.0024, 0.0).z_to_y().at(0.0, y, 0.0);
    vec![
        Model::new("arm_base", "accent", ring(0.0675, 0.0034, 0.0590)),
        Model::new("arm_1", "shell", shoulder.surface()),
        Model::new("arm_1", "metal", shoulder.cap()),
        Model::new("arm_2", "joint", drum(0.0650, [-0.0605, 0.0890], 0.0575, 0.1165)),
        Model::new("arm_2", "accent", ring(0.0560, 0.0032, 0.1165).with(at_drum(0.0622, -0.0610))),
        Model::new("arm_3", "shell", upper.surface()),
        Model::new("arm_3", "metal", upper.cap()),
        Model::new("arm_4", "joint", drum(0.0555, [-0.0510, 0.0820], 0.0470, 0.1065)),
        Model::new("arm_4", "accent", ring(0.0452, 0.0029, 0.1065).with(at_drum(0.0530, -0.0515))),
        Model::new("arm_5", "shell", long.surface()),
        Model::new("arm_5", "metal", long.cap()),
        Model::new("arm_5_short", "shell", short.surface()),
        Model::new("arm_5_short", "metal", short.cap()),
        Model::new("arm_6", "joint", ball(0.0500)),
        Model::new("arm_6", "accent", ring(0.0392, 0.0026, 0.0368)),
        Model::new("arm_7", "shell", collar(0.0824)),
        Model::new("arm_7", "metal", mount_plate(0.0824)),
        Model::new("arm_7_long", "shell", collar(0.159)),
        Model::new("arm_7_long", "metal", mount_plate(0.159)),
    ]
}
