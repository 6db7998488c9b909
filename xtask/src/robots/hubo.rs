//! Hubo: white shells over dark joints, a visor with two eyes.

use std::f64::consts::{PI, TAU};

use super::Model;
use super::shapes::{Section, lathe_with, loft_with};
use super::surface::{Surface, V3};

/// Points around the trunk, around limbs, the visor, and fingers.
const TRUNK: usize = 16;
const LIMB: usize = 11;
const VISOR: usize = 24;
const FINGER: usize = 7;

/// A body about z whose sections are rounded rectangles: height, half depth, half width.
fn shell(rows: &[(f64, f64, f64)], exponent: f64, around: usize) -> Surface {
    let section = |&(z, x, y): &(f64, f64, f64)| Section::between(z, [-x, x], [-y, y], exponent);
    loft_with(&rows.iter().map(section).collect::<Vec<_>>(), around)
}

/// A body of revolution about z: height and radius.
fn round(rows: &[(f64, f64)], around: usize) -> Surface {
    shell(&rows.iter().map(|&(z, r)| (z, r, r)).collect::<Vec<_>>(), 2.0, around)
}

fn ellipsoid(semi: [f64; 3], around: usize) -> Surface {
    let rows = [-1.4f64, -0.9, -0.4, 0.0, 0.4, 0.9, 1.4].map(|a| {
        let (sin, cos) = a.sin_cos();
        (semi[2] * sin, semi[0] * cos, semi[1] * cos)
    });
    shell(&rows, 2.0, around)
}

/// A drum along y with softened rims.
fn drum(r: f64, half: f64) -> Surface {
    lathe_with(&[(0.0, -half, 0.0), (r, -half, 0.0024), (r, half, 0.0024), (0.0, half, 0.0)], LIMB).z_to_y()
}

/// A disc that looks along x.
fn disc(r: f64, thickness: f64) -> Surface {
    lathe_with(&[(r, 0.0, 0.0), (r, thickness, 0.0012), (0.0, thickness, 0.0)], LIMB).z_to_x()
}

fn torso() -> [Surface; 3] {
    let chest = shell(
        &[
            (-0.1680, 0.0680, 0.0860),
            (-0.1350, 0.0970, 0.1260),
            (-0.1000, 0.1140, 0.1440),
            (-0.0600, 0.1210, 0.1520),
            (-0.0200, 0.1140, 0.1460),
            (0.0150, 0.0960, 0.1300),
            (0.0400, 0.0720, 0.1100),
            (0.0570, 0.0420, 0.0780),
            (0.0610, 0.0250, 0.0500),
        ],
        2.3,
        TRUNK,
    );
    let waist =
        round(&[(-0.2500, 0.0400), (-0.2350, 0.0560), (-0.2150, 0.0660), (-0.2000, 0.0700), (-0.1550, 0.0780)], LIMB);
    [chest, waist, disc(0.0170, 0.0030).at(0.1185, 0.0, -0.0500)]
}

/// A window that lies on the ball of the head (radius 0.1 m about 0.02 m): a rounded rectangle seen from the middle.
fn visor() -> Surface {
    let rows: Vec<Vec<V3>> = [(0.097, 1.0), (0.1015, 0.985), (0.1022, 0.93), (0.1022, 0.5), (0.1022, 0.001)]
        .iter()
        .map(|&(radius, share)| {
            (0..VISOR)
                .map(|j| {
                    let (sin, cos) = (TAU * j as f64 / VISOR as f64).sin_cos();
                    let rounded = |x: f64| x.signum() * x.abs().powf(0.55);
                    let (side, up) = (0.92 * share * rounded(cos), 0.06 + 0.30 * share * rounded(sin));
                    [radius * up.cos() * side.cos(), radius * up.cos() * side.sin(), 0.02 + radius * up.sin()]
                })
                .collect()
        })
        .collect();
    Surface::closed_rows(&rows)
}

fn head() -> [Surface; 3] {
    let helmet = shell(
        &[
            (-0.0700, 0.0340, 0.0360),
            (-0.0450, 0.0710, 0.0740),
            (-0.0150, 0.0910, 0.0920),
            (0.0200, 0.0980, 0.0970),
            (0.0550, 0.0920, 0.0910),
            (0.0850, 0.0730, 0.0720),
            (0.1050, 0.0500, 0.0490),
            (0.1155, 0.0260, 0.0255),
            (0.1178, 0.0110, 0.0110),
        ],
        2.05,
        TRUNK,
    );
    let neck = round(&[(-0.1180, 0.0330), (-0.1000, 0.0390), (-0.0500, 0.0400)], LIMB);
    let eye = |y: f64| disc(0.0105, 0.0018).turned(y.signum() * 0.30).at(0.0962, y, 0.0270);
    [helmet, visor().with(neck), eye(0.0300).with(eye(-0.0300))]
}

/// The cap of the shoulder looks outwards, to +y.
fn shoulder() -> [Surface; 2] {
    let cap = round(
        &[
            (-0.0200, 0.0440),
            (-0.0160, 0.0535),
            (0.0, 0.0580),
            (0.0200, 0.0545),
            (0.0390, 0.0430),
            (0.0520, 0.0250),
            (0.0575, 0.0070),
        ],
        LIMB + 2,
    )
    .z_to_y();
    let collar = round(&[(-0.0560, 0.0200), (-0.0500, 0.0320), (-0.0300, 0.0480), (-0.0120, 0.0500)], LIMB).z_to_y();
    [cap, collar]
}

fn finger(y: f64, rows: &[(f64, f64)]) -> Surface {
    round(rows, FINGER).at(0.0, y, 0.0)
}

fn knuckle(y: f64) -> Surface {
    lathe_with(&[(0.0, -0.0105, 0.0), (0.0112, -0.0105, 0.001), (0.0112, 0.0105, 0.001), (0.0, 0.0105, 0.0)], FINGER)
        .z_to_y()
        .at(0.0, y, 0.0)
}

/// Inner and outer part of fingers side by side: shell and knuckles, and the shell of the tips.
fn fingers(places: &[f64]) -> [Surface; 3] {
    let all = |part: &dyn Fn(f64) -> Surface| places.iter().map(|&y| part(y)).reduce(Surface::with).unwrap_or_default();
    let inner = [(0.0060, 0.0085), (0.0085, 0.0104), (0.0250, 0.0108), (0.0370, 0.0102), (0.0400, 0.0080)];
    let outer =
        [(0.0050, 0.0080), (0.0080, 0.0100), (0.0240, 0.0104), (0.0370, 0.0090), (0.0425, 0.0060), (0.0445, 0.0020)];
    [all(&|y| finger(y, &inner)), all(&|y| knuckle(y)), all(&|y| finger(y, &outer))]
}

fn foot() -> [Surface; 2] {
    let plate = |rows: &[(f64, f64, f64, f64)]| {
        let section =
            |&(z, heel, toe, half): &(f64, f64, f64, f64)| Section::between(z, [heel, toe], [-half, half], 3.0);
        loft_with(&rows.iter().map(section).collect::<Vec<_>>(), LIMB)
    };
    let upper = plate(&[
        (-0.0870, -0.0770, 0.1370, 0.0660),
        (-0.0800, -0.0790, 0.1390, 0.0680),
        (-0.0660, -0.0780, 0.1330, 0.0670),
        (-0.0500, -0.0740, 0.1120, 0.0640),
        (-0.0400, -0.0680, 0.0860, 0.0590),
        (-0.0340, -0.0560, 0.0620, 0.0500),
    ]);
    let sole = plate(&[
        (-0.0948, -0.0760, 0.1360, 0.0650),
        (-0.0930, -0.0790, 0.1390, 0.0680),
        (-0.0860, -0.0790, 0.1390, 0.0680),
    ]);
    [upper, sole.with(drum(0.0370, 0.0320))]
}

pub(super) fn models() -> Vec<Model> {
    let [torso_shell, torso_joint, torso_accent] = torso();
    let [head_shell, head_joint, head_accent] = head();
    let [shoulder_shell, shoulder_joint] = shoulder();
    let [fingers_1, fingers_joint, fingers_2] = fingers(&[-0.02, 0.02]);
    let [thumb_1, thumb_joint, thumb_2] = fingers(&[0.0]);
    let [foot_shell, foot_joint] = foot();
    let pelvis = [
        (-0.1560, 0.0450, 0.0950),
        (-0.1450, 0.0580, 0.1100),
        (-0.1150, 0.0780, 0.1290),
        (-0.0850, 0.0840, 0.1360),
        (-0.0550, 0.0780, 0.1290),
        (-0.0300, 0.0620, 0.1120),
        (-0.0200, 0.0480, 0.0960),
    ];
    let cap = |side: f64| disc(0.0200, 0.0024).turned(side * 0.5 * PI).at(0.0, side * 0.0270, 0.0);
    vec![
        Model::new("hubo_pelvis", "shell", shell(&pelvis, 2.2, TRUNK)),
        Model::new("hubo_torso", "shell", torso_shell),
        Model::new("hubo_torso", "joint", torso_joint),
        Model::new("hubo_torso", "accent", torso_accent),
        Model::new("hubo_head", "shell", head_shell),
        Model::new("hubo_head", "joint", head_joint),
        Model::new("hubo_head", "accent", head_accent),
        Model::new("hubo_shoulder", "shell", shoulder_shell),
        Model::new("hubo_shoulder", "joint", shoulder_joint),
        Model::new(
            "hubo_upper",
            "shell",
            round(
                &[
                    (-0.1640, 0.0290),
                    (-0.1600, 0.0340),
                    (-0.1400, 0.0385),
                    (-0.1000, 0.0415),
                    (-0.0600, 0.0420),
                    (-0.0350, 0.0390),
                    (-0.0150, 0.0270),
                ],
                LIMB + 2,
            ),
        ),
        Model::new("hubo_elbow", "joint", drum(0.0390, 0.0270)),
        Model::new("hubo_elbow", "accent", cap(1.0).with(cap(-1.0))),
        Model::new(
            "hubo_fore",
            "shell",
            round(
                &[
                    (-0.1560, 0.0270),
                    (-0.1520, 0.0310),
                    (-0.1300, 0.0360),
                    (-0.0900, 0.0410),
                    (-0.0600, 0.0415),
                    (-0.0380, 0.0380),
                    (-0.0300, 0.0310),
                ],
                LIMB + 2,
            ),
        ),
        Model::new(
            "hubo_fore",
            "accent",
            round(&[(-0.1570, 0.0290), (-0.1560, 0.0325), (-0.1520, 0.0330), (-0.1500, 0.0300)], LIMB),
        ),
        Model::new("hubo_wrist", "joint", ellipsoid([0.0330, 0.0330, 0.0330], LIMB)),
        Model::new(
            "hubo_palm",
            "shell",
            shell(
                &[
                    (-0.0870, 0.0230, 0.0250),
                    (-0.0820, 0.0260, 0.0300),
                    (-0.0620, 0.0300, 0.0390),
                    (-0.0400, 0.0320, 0.0420),
                    (-0.0150, 0.0320, 0.0420),
                    (-0.0040, 0.0300, 0.0405),
                    (0.0005, 0.0260, 0.0370),
                ],
                3.2,
                LIMB + 2,
            ),
        ),
        Model::new("hubo_fingers_1", "shell", fingers_1),
        Model::new("hubo_fingers_1", "joint", fingers_joint),
        Model::new("hubo_fingers_2", "shell", fingers_2),
        Model::new("hubo_thumb_1", "shell", thumb_1),
        Model::new("hubo_thumb_1", "joint", thumb_joint),
        Model::new("hubo_thumb_2", "shell", thumb_2),
        Model::new(
            "hubo_thigh",
            "shell",
            round(
                &[
                    (-0.2780, 0.0360),
                    (-0.2720, 0.0440),
                    (-0.2400, 0.0540),
                    (-0.1700, 0.0640),
                    (-0.1000, 0.0680),
                    (-0.0500, 0.0650),
                    (-0.0250, 0.0560),
                    (-0.0150, 0.0420),
                ],
                LIMB + 2,
            ),
        ),
        Model::new("hubo_thigh", "joint", drum(0.0430, 0.0340)),
        Model::new(
            "hubo_shank",
            "shell",
            round(
                &[
                    (-0.2760, 0.0280),
                    (-0.2700, 0.0340),
                    (-0.2300, 0.0420),
                    (-0.1500, 0.0500),
                    (-0.0900, 0.0530),
                    (-0.0500, 0.0490),
                    (-0.0380, 0.0410),
                    (-0.0330, 0.0300),
                ],
                LIMB + 2,
            ),
        ),
        Model::new("hubo_shank", "joint", drum(0.0430, 0.0340)),
        Model::new("hubo_foot", "shell", foot_shell),
        Model::new("hubo_foot", "joint", foot_joint),
    ]
}
