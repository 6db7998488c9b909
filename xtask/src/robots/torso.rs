//! What stands on the floor: pedestal, torso, and the camera bar that looks at the table.

use std::f64::consts::FRAC_PI_2;

use super::Model;
use super::shapes::{bent_tube, lathe, lathe_with, ring, rounded_box};
use super::surface::Surface;

/// Pedestal from the floor to the turning torso at 1.09 m.
fn pedestal() -> Surface {
    lathe(&[
        (0.2360, 0.0, 0.0),
        (0.2400, 0.0030, 0.0),
        (0.2400, 0.0180, 0.010),
        (0.1350, 0.0400, 0.060),
        (0.0860, 0.1000, 0.080),
        (0.0760, 0.5600, 0.400),
        (0.0820, 0.9800, 0.300),
        (0.0900, 1.0860, 0.004),
        (0.0, 1.0860, 0.0),
    ])
}

/// Torso in its own frame, the origin on the line between the shoulders.
fn torso() -> Surface {
    let core = lathe(&[
        (0.0870, -0.1370, 0.0),
        (0.0900, -0.1340, 0.0),
        (0.0860, -0.0400, 0.080),
        (0.0860, 0.0550, 0.030),
        (0.0640, 0.0860, 0.020),
        (0.0, 0.0900, 0.0),
    ]);
    let mast = bent_tube([0.030, 0.0, 0.060], [0.050, 0.0, 0.140], [0.136, 0.0, 0.131], 0.0110);
    core.with(mast)
}

/// Shoulder sleeve along y: pale, from one arm to the other.
fn sleeve() -> Surface {
    lathe(&[
        (0.0640, -0.1050, 0.0),
        (0.0690, -0.1050, 0.002),
        (0.0720, 0.0, 0.500),
        (0.0690, 0.1050, 0.002),
        (0.0640, 0.1050, 0.0),
    ])
    .z_to_y()
}

/// Camera bar in the frame of the camera body: x forward, the depth lens at the origin.
fn camera() -> [Surface; 3] {
    let body = rounded_box([0.0340, 0.1800, 0.0270], 0.0100).at(-0.0150, -0.0280, 0.0);
    let lens = |y: f64, r: f64| {
        lathe_with(
            &[
                (r, -0.0020, 0.0),
                (r, 0.0016, 0.0006),
                (0.74 * r, 0.0024, 0.0006),
                (0.66 * r, 0.0008, 0.0004),
                (0.0, 0.0008, 0.0),
            ],
            12,
        )
        .z_to_x()
        .at(0.0014, y, 0.0)
    };
    let lenses = lens(0.0, 0.0085).with(lens(-0.0280, 0.0065)).with(lens(-0.0750, 0.0085));
    let light = lathe_with(&[(0.0022, -0.004, 0.0), (0.0022, 0.0006, 0.0003), (0.0, 0.0006, 0.0)], 12)
        .turned(FRAC_PI_2)
        .z_to_x()
        .at(0.0022, 0.0350, 0.0);
    [body, lenses, light]
}

pub(super) fn models() -> Vec<Model> {
    let [body, lenses, light] = camera();
    vec![
        Model::new("pedestal", "joint", pedestal()),
        Model::new("pedestal", "accent", ring(0.0885, 0.0030, 1.0895)),
        Model::new("torso", "joint", torso()),
        Model::new("torso", "shell", sleeve()),
        Model::new("camera", "joint", body),
        Model::new("camera", "metal", lenses),
        Model::new("camera", "accent", light),
    ]
}
