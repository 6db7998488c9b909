//! What the arms carry: force sensor, three-fingered SDH, parallel gripper with flat fingers.

use super::Model;
use super::shapes::{Section, lathe, lathe_with, loft, rounded_box};
use super::surface::Surface;

/// Height of the finger's first axis above the palm frame.
const PROXIMAL_Z: f64 = 0.091;

/// Sensor and tool changer, from the flange upwards.
fn force_sensor() -> (Surface, Surface) {
    let sensor = lathe(&[
        (0.0395, 0.0, 0.0),
        (0.0425, 0.0030, 0.001),
        (0.0425, 0.0270, 0.0015),
        (0.0395, 0.0295, 0.001),
        (0.0395, 0.0335, 0.0),
    ]);
    let changer = lathe(&[
        (0.0380, 0.0325, 0.0),
        (0.0440, 0.0335, 0.002),
        (0.0440, 0.0485, 0.0),
        (0.0420, 0.0495, 0.0),
        (0.0420, 0.0525, 0.0),
        (0.0440, 0.0535, 0.0),
        (0.0440, 0.0665, 0.0015),
        (0.0, 0.0665, 0.0),
    ]);
    (sensor, changer)
}

fn palm() -> Surface {
    loft(&[
        Section::circle(-0.0070, 0.0400),
        Section::circle(-0.0062, 0.0415),
        Section::circle(-0.0030, 0.0425),
        Section::between(0.0080, [-0.0500, 0.0430], [-0.0490, 0.0490], 2.4),
        Section::between(0.0200, [-0.0590, 0.0440], [-0.0560, 0.0560], 2.7),
        Section::between(0.0340, [-0.0625, 0.0445], [-0.0585, 0.0585], 3.6),
        Section::between(0.0600, [-0.0625, 0.0445], [-0.0585, 0.0585], 3.6),
        Section::between(0.0680, [-0.0615, 0.0435], [-0.0575, 0.0575], 3.6),
        Section::between(0.0720, [-0.0590, 0.0410], [-0.0550, 0.0550], 3.6),
        Section::between(0.0735, [-0.0550, 0.0370], [-0.0515, 0.0515], 3.6),
    ])
}

/// The round foot of a finger with two cheeks that hold its first axis.
fn knuckle() -> Surface {
    let foot = lathe_with(
        &[
            (0.0165, 0.0560, 0.0),
            (0.0215, 0.0740, 0.006),
            (0.0215, 0.0800, 0.003),
            (0.0150, 0.0835, 0.002),
            (0.0, 0.0835, 0.0),
        ],
        22,
    );
    let cheek = |y: f64| {
        let pin = lathe_with(
            &[(0.0, -0.0024, 0.0), (0.0112, -0.0024, 0.001), (0.0112, 0.0024, 0.001), (0.0, 0.0024, 0.0)],
            16,
        );
        rounded_box([0.0200, 0.0044, 0.0140], 0.0018).at(0.0, y, 0.0830).with(pin.z_to_y().at(0.0, y, PROXIMAL_Z))
    };
    foot.with(cheek(0.0166)).with(cheek(-0.0166))
}

/// The barrel about the axis of a finger joint.
fn barrel(r: f64, half: f64) -> Surface {
    lathe_with(&[(0.0, -half, 0.0), (r, -half, 0.002), (r, half, 0.002), (0.0, half, 0.0)], 20).z_to_y()
}

fn phalanx(sections: &[(f64, f64, f64, f64)]) -> Surface {
    let section =
        |&(z, back, front, half): &(f64, f64, f64, f64)| Section::between(z, [-back, front], [-half, half], 3.2);
    loft(&sections.iter().map(section).collect::<Vec<_>>())
}

fn pad(x: f64, z: [f64; 2], half: f64) -> Surface {
    rounded_box([0.0050, 2.0 * half, z[1] - z[0]], 0.0022).at(x - 0.0025, 0.0, 0.5 * (z[0] + z[1]))
}

fn proximal() -> [Surface; 3] {
    let body = phalanx(&[
        (0.0080, 0.0095, 0.0095, 0.0110),
        (0.0105, 0.0118, 0.0118, 0.0128),
        (0.0200, 0.0128, 0.0128, 0.0134),
        (0.0480, 0.0124, 0.0124, 0.0128),
        (0.0680, 0.0120, 0.0120, 0.0122),
        (0.0775, 0.0106, 0.0106, 0.0112),
        (0.0800, 0.0080, 0.0080, 0.0090),
    ]);
    let axle = barrel(0.0138, 0.0140);
    let far = barrel(0.0110, 0.0138).at(0.0, 0.0, 0.0865);
    [body, axle.with(far), pad(0.0148, [0.0190, 0.0680], 0.0108)]
}

fn distal() -> [Surface; 3] {
    let body = phalanx(&[
        (0.0070, 0.0090, 0.0090, 0.0105),
        (0.0100, 0.0116, 0.0112, 0.0126),
        (0.0200, 0.0124, 0.0118, 0.0132),
        (0.0400, 0.0112, 0.0120, 0.0126),
        (0.0540, 0.0084, 0.0122, 0.0114),
        (0.0620, 0.0044, 0.0118, 0.0098),
        (0.0660, 0.0000, 0.0106, 0.0080),
        (0.0675, -0.0030, 0.0090, 0.0056),
    ]);
    [body, barrel(0.0136, 0.0118), pad(0.0146, [0.0150, 0.0630], 0.0112)]
}

/// Body of the parallel gripper: closing direction along x.
fn gripper() -> [Surface; 4] {
    let body = loft(&[
        Section::circle(0.0000, 0.0375),
        Section::circle(0.0010, 0.0390),
        Section::circle(0.0060, 0.0400),
        Section::between(0.0140, [-0.0500, 0.0500], [-0.0390, 0.0390], 2.8),
        Section::between(0.0220, [-0.0545, 0.0545], [-0.0395, 0.0395], 4.0),
        Section::between(0.0320, [-0.0555, 0.0555], [-0.0395, 0.0395], 5.0),
        Section::between(0.0560, [-0.0555, 0.0555], [-0.0395, 0.0395], 5.0),
        Section::between(0.0590, [-0.0548, 0.0548], [-0.0388, 0.0388], 5.0),
        Section::between(0.0600, [-0.0530, 0.0530], [-0.0370, 0.0370], 5.0),
    ]);
    let head = rounded_box([0.1100, 0.0770, 0.0190], 0.0035).at(0.0, 0.0, 0.0680);
    let rail = |y: f64| rounded_box([0.1040, 0.0070, 0.0050], 0.0015).at(0.0, y, 0.0770);
    let line = rounded_box([0.1118, 0.0797, 0.0024], 0.0011).at(0.0, 0.0, 0.0592);
    [body, head, rail(0.0150).with(rail(-0.0150)), line]
}

/// One jaw with its flat finger; the gripping face is x = 0 and looks towards -x.
fn jaw() -> [Surface; 3] {
    let carriage = rounded_box([0.0230, 0.0440, 0.0105], 0.0020).at(0.0125, 0.0, 0.0058);
    let finger = loft(&[
        Section::between(0.0080, [0.0030, 0.0150], [-0.0150, 0.0150], 5.0),
        Section::between(0.0100, [0.0024, 0.0170], [-0.0160, 0.0160], 5.0),
        Section::between(0.0200, [0.0024, 0.0150], [-0.0130, 0.0130], 5.0),
        Section::between(0.0320, [0.0024, 0.0124], [-0.0123, 0.0123], 5.0),
        Section::between(0.0800, [0.0024, 0.0112], [-0.0120, 0.0120], 5.0),
        Section::between(0.1020, [0.0024, 0.0092], [-0.0115, 0.0115], 4.0),
        Section::between(0.1080, [0.0026, 0.0074], [-0.0095, 0.0095], 4.0),
        Section::between(0.1100, [0.0032, 0.0056], [-0.0070, 0.0070], 4.0),
    ]);
    let pad = rounded_box([0.0040, 0.0220, 0.0700], 0.0014).at(0.0020, 0.0, 0.0710);
    [carriage, finger, pad]
}

pub(super) fn models() -> Vec<Model> {
    let (sensor, changer) = force_sensor();
    let [proximal_shell, proximal_joint, proximal_pad] = proximal();
    let [distal_shell, distal_joint, distal_pad] = distal();
    let [gripper_shell, gripper_joint, gripper_rails, gripper_line] = gripper();
    let [carriage, finger, jaw_pad] = jaw();
    vec![
        Model::new("ft_sensor", "metal", sensor),
        Model::new("ft_sensor", "joint", changer),
        Model::new("sdh_palm", "joint", palm()),
        Model::new("sdh_knuckle", "metal", knuckle()),
        Model::new("sdh_proximal", "shell", proximal_shell),
        Model::new("sdh_proximal", "joint", proximal_joint),
        Model::new("sdh_proximal", "rubber", proximal_pad),
        Model::new("sdh_distal", "shell", distal_shell),
        Model::new("sdh_distal", "joint", distal_joint),
        Model::new("sdh_distal", "rubber", distal_pad),
        Model::new("gripper", "shell", gripper_shell),
        Model::new("gripper", "joint", gripper_joint),
        Model::new("gripper", "metal", gripper_rails),
        Model::new("gripper", "accent", gripper_line),
        Model::new("jaw", "joint", carriage),
        Model::new("jaw", "shell", finger),
        Model::new("jaw", "rubber", jaw_pad),
    ]
}
