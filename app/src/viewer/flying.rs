//! Flying: keys that move the camera while they are held.

use egui::{Key, Ui};
use nalgebra::Vector3;

use crate::render::Camera;

/// Distances to the target that the camera flies in a second.
const SPEED: f64 = 0.8;
/// How much faster it flies while Shift is held.
const FASTER: f64 = 3.0;

/// The keys and where they lead: right, up, forward.
const KEYS: [(Key, [f64; 3]); 6] = [
    (Key::W, [0.0, 0.0, 1.0]),
    (Key::S, [0.0, 0.0, -1.0]),
    (Key::A, [-1.0, 0.0, 0.0]),
    (Key::D, [1.0, 0.0, 0.0]),
    (Key::Q, [0.0, -1.0, 0.0]),
    (Key::E, [0.0, 1.0, 0.0]),
];

/// Moves the camera as long as keys are held; says whether it did.
pub(super) fn fly(ui: &Ui, camera: &mut Camera) -> bool {
    if ui.ctx().egui_wants_keyboard_input() || egui::Popup::is_any_open(ui.ctx()) {
        return false;
    }
    let (way, is_fast, dt_s) = ui.input(|input| {
        let mut way = [0.0; 3];
        if !input.modifiers.command && !input.modifiers.alt {
            for (_, step) in KEYS.iter().filter(|(key, _)| input.key_down(*key)) {
                (0..3).for_each(|axis| way[axis] += step[axis]);
            }
        }
        (way, input.modifiers.shift, f64::from(input.stable_dt).min(0.1))
    });
    let [right, up, forward] = way;
    // Up and forward keep to the world, so that a look down does not lead into the floor.
    let ahead =
        Vector3::new(-camera.backward().x, -camera.backward().y, 0.0).try_normalize(1e-6).unwrap_or(camera.up());
    let way = camera.right() * right + Vector3::z() * up + ahead * forward;
    if way.norm_squared() == 0.0 {
        return false;
    }
    camera.target += way * (camera.distance_m * SPEED * dt_s * if is_fast { FASTER } else { 1.0 });
    true
}
