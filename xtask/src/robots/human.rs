//! A person as a calm mannequin: shirt, trousers, a head without a face, hands of four fingers and a thumb.

use super::Model;
use super::shapes::{Section, loft_with};
use super::surface::Surface;

/// Points around the trunk, around limbs, and around fingers.
const TRUNK: usize = 16;
const LIMB: usize = 11;
const FINGER: usize = 6;

/// A section symmetric to the middle of the body: height, back and front, half the width.
fn across(&(z, back, front, half): &(f64, f64, f64, f64)) -> Section {
    Section::between(z, [back, front], [-half, half], 2.2)
}

fn trunk(rows: &[(f64, f64, f64, f64)], around: usize) -> Surface {
    loft_with(&rows.iter().map(across).collect::<Vec<_>>(), around)
}

/// A limb along z: height, shift to the front, radius.
fn limb(rows: &[(f64, f64, f64)], around: usize) -> Surface {
    let section = |&(z, x, r): &(f64, f64, f64)| Section::between(z, [x - r, x + r], [-r, r], 2.0);
    loft_with(&rows.iter().map(section).collect::<Vec<_>>(), around)
}

/// Shirt, from the hem to the collar.
fn torso() -> Surface {
    trunk(
        &[
            (-0.4020, -0.0730, 0.0730, 0.1320),
            (-0.3800, -0.0840, 0.0860, 0.1460),
            (-0.3400, -0.0880, 0.0920, 0.1500),
            (-0.2850, -0.0830, 0.0830, 0.1430),
            (-0.2300, -0.0880, 0.0910, 0.1510),
            (-0.1800, -0.0930, 0.0940, 0.1600),
            (-0.1300, -0.1020, 0.1010, 0.1680),
            (-0.0900, -0.0960, 0.0940, 0.1680),
            (-0.0550, -0.0730, 0.0700, 0.1480),
            (-0.0250, -0.0500, 0.0480, 0.1640),
            (0.0000, -0.0440, 0.0430, 0.1720),
            (0.0220, -0.0420, 0.0400, 0.1560),
            (0.0380, -0.0380, 0.0360, 0.1000),
            (0.0520, -0.0280, 0.0260, 0.0640),
        ],
        TRUNK,
    )
}

fn pelvis() -> Surface {
    trunk(
        &[
            (-0.0800, -0.0360, 0.0360, 0.0950),
            (-0.0400, -0.0680, 0.0660, 0.1360),
            (0.0000, -0.0850, 0.0820, 0.1580),
            (0.0400, -0.0880, 0.0840, 0.1560),
            (0.0850, -0.0860, 0.0840, 0.1440),
            (0.1200, -0.0800, 0.0800, 0.1340),
            (0.1450, -0.0650, 0.0650, 0.1180),
        ],
        TRUNK,
    )
}

fn head() -> Surface {
    let neck = trunk(&[(-0.0450, -0.0460, 0.0420, 0.0440), (0.0800, -0.0480, 0.0400, 0.0440)], LIMB);
    let skull = trunk(
        &[
            (0.0290, -0.0150, 0.0545, 0.0320),
            (0.0450, -0.0420, 0.0655, 0.0460),
            (0.0750, -0.0680, 0.0820, 0.0590),
            (0.1100, -0.0840, 0.0865, 0.0680),
            (0.1500, -0.0880, 0.0860, 0.0725),
            (0.1850, -0.0800, 0.0770, 0.0660),
            (0.2130, -0.0610, 0.0570, 0.0510),
            (0.2310, -0.0350, 0.0310, 0.0290),
            (0.2370, -0.0140, 0.0120, 0.0120),
        ],
        TRUNK,
    );
    neck.with(skull)
}

fn hair() -> Surface {
    trunk(
        &[
            (0.0820, -0.0740, -0.0420, 0.0460),
            (0.0950, -0.0830, -0.0340, 0.0550),
            (0.1300, -0.0905, -0.0160, 0.0650),
            (0.1620, -0.0900, 0.0200, 0.0725),
            (0.1980, -0.0760, 0.0720, 0.0650),
            (0.2150, -0.0640, 0.0600, 0.0540),
            (0.2340, -0.0380, 0.0340, 0.0320),
            (0.2410, -0.0130, 0.0110, 0.0110),
        ],
        TRUNK,
    )
}

fn palm() -> Surface {
    let section = |&(z, x0, x1, half): &(f64, f64, f64, f64)| Section::between(z, [x0, x1], [-half, half], 2.8);
    let rows = [
        (0.0115, -0.0190, 0.0075, 0.0220),
        (0.0200, -0.0220, 0.0065, 0.0280),
        (0.0350, -0.0255, 0.0050, 0.0350),
        (0.0600, -0.0270, 0.0030, 0.0395),
        (0.0800, -0.0265, 0.0030, 0.0395),
        (0.0885, -0.0230, 0.0000, 0.0360),
    ];
    loft_with(&rows.iter().map(section).collect::<Vec<_>>(), LIMB)
}

/// Four fingers side by side, each from its joint to the next.
fn fingers(rows: &[(f64, f64, f64)]) -> Surface {
    [-0.0285, -0.0095, 0.0095, 0.0285]
        .into_iter()
        .map(|y| limb(rows, FINGER).at(0.0, y, 0.0))
        .reduce(Surface::with)
        .unwrap_or_default()
}

fn shoe() -> Surface {
    let section = |&(z, x0, x1, half): &(f64, f64, f64, f64)| Section::between(z, [x0, x1], [-half, half], 2.6);
    let rows = [
        (-0.0685, -0.0540, 0.1780, 0.0380),
        (-0.0640, -0.0590, 0.1870, 0.0430),
        (-0.0520, -0.0595, 0.1885, 0.0435),
        (-0.0360, -0.0590, 0.1780, 0.0425),
        (-0.0210, -0.0560, 0.1420, 0.0400),
        (-0.0090, -0.0500, 0.0900, 0.0370),
        (0.0040, -0.0400, 0.0420, 0.0360),
        (0.0300, -0.0300, 0.0300, 0.0300),
    ];
    loft_with(&rows.iter().map(section).collect::<Vec<_>>(), LIMB)
}

pub(super) fn models() -> Vec<Model> {
    let shoulder = [
        (-0.1000, 0.0390),
        (-0.0800, 0.0450),
        (-0.0500, 0.0475),
        (-0.0200, 0.0505),
        (0.0, 0.0515),
        (0.0200, 0.0480),
        (0.0380, 0.0360),
        (0.0500, 0.0160),
    ];
    let round = |rows: &[(f64, f64)]| limb(&rows.iter().map(|&(z, r)| (z, 0.0, r)).collect::<Vec<_>>(), LIMB);
    let ball = |r: f64| round(&[-1.3f64, -0.7, 0.0, 0.7, 1.3].map(|a| (r * a.sin(), r * a.cos())));
    vec![
        Model::new("human_pelvis", "dark", pelvis()),
        Model::new("human_torso", "cloth", torso()),
        Model::new("human_head", "skin", head()),
        Model::new("human_head", "dark", hair()),
        Model::new("human_shoulder", "cloth", round(&shoulder)),
        Model::new(
            "human_upper",
            "cloth",
            round(&[
                (-0.3250, 0.0340),
                (-0.3000, 0.0385),
                (-0.2000, 0.0415),
                (-0.0900, 0.0455),
                (-0.0600, 0.0400),
                (-0.0450, 0.0280),
            ]),
        ),
        Model::new("human_elbow", "cloth", ball(0.0388)),
        Model::new(
            "human_fore",
            "skin",
            limb(
                &[
                    (-0.2560, 0.0, 0.0250),
                    (-0.2250, 0.0, 0.0260),
                    (-0.1500, 0.0, 0.0320),
                    (-0.0800, 0.0, 0.0375),
                    (-0.0450, 0.0, 0.0375),
                    (-0.0150, 0.0, 0.0270),
                ],
                LIMB,
            ),
        ),
        Model::new("human_wrist", "skin", ball(0.0262)),
        Model::new("human_palm", "skin", palm()),
        Model::new(
            "human_fingers_1",
            "skin",
            fingers(&[
                (-0.0060, 0.0, 0.0070),
                (0.0, 0.0, 0.0095),
                (0.0240, 0.0, 0.0093),
                (0.0450, 0.0, 0.0088),
                (0.0500, 0.0, 0.0060),
            ]),
        ),
        Model::new(
            "human_fingers_2",
            "skin",
            fingers(&[
                (-0.0050, 0.0, 0.0060),
                (0.0, 0.0, 0.0088),
                (0.0240, 0.0, 0.0086),
                (0.0440, 0.0, 0.0076),
                (0.0520, 0.0, 0.0048),
                (0.0545, 0.0, 0.0020),
            ]),
        ),
        Model::new(
            "human_thumb_1",
            "skin",
            limb(
                &[
                    (-0.0100, 0.0, 0.0080),
                    (0.0, 0.0, 0.0130),
                    (0.0300, 0.0, 0.0125),
                    (0.0550, 0.0, 0.0108),
                    (0.0610, 0.0, 0.0070),
                ],
                FINGER + 2,
            ),
        ),
        Model::new(
            "human_thumb_2",
            "skin",
            limb(
                &[
                    (-0.0050, 0.0, 0.0070),
                    (0.0, 0.0, 0.0108),
                    (0.0280, 0.0, 0.0105),
                    (0.0500, 0.0, 0.0088),
                    (0.0580, 0.0, 0.0055),
                    (0.0605, 0.0, 0.0020),
                ],
                FINGER + 2,
            ),
        ),
        Model::new(
            "human_thigh",
            "dark",
            round(&[
                (-0.4180, 0.0440),
                (-0.3900, 0.0520),
                (-0.3200, 0.0590),
                (-0.2000, 0.0690),
                (-0.0900, 0.0750),
                (-0.0200, 0.0740),
                (0.0300, 0.0640),
                (0.0600, 0.0420),
            ]),
        ),
        Model::new(
            "human_shank",
            "dark",
            limb(
                &[
                    (-0.4250, 0.0, 0.0330),
                    (-0.3800, 0.0, 0.0360),
                    (-0.2600, 0.0, 0.0430),
                    (-0.1400, -0.002, 0.0500),
                    (-0.0600, 0.0, 0.0490),
                    (0.0, 0.0, 0.0490),
                    (0.0280, 0.0, 0.0400),
                    (0.0450, 0.0, 0.0190),
                ],
                LIMB,
            ),
        ),
        Model::new("human_foot", "dark", shoe()),
    ]
}
