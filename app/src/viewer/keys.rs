//! The keyboard.

use egui::{Context, Key, Modifiers};

use endcomfort_core::job::Stage;

use super::state::Step;
use super::{Command, LabCommand, NamedView, Overlay, ReachCommand, ViewerState};

/// What the help overlay lists: key, what it does.
pub(super) const LIST: [(&str, &str); 20] = [
    ("Space", "Play or pause"),
    ("Left  Right", "Back or forth by 0.1 s"),
    (",  .", "Back or forth by one sample"),
    ("Home  End", "Start or end of the plan"),
    ("Up  Down", "Select the grasp above or below"),
    ("F", "Frame everything"),
    ("O", "The camera follows the object"),
    ("P", "Presentation without panels"),
    ("V", "Fit step: as a body, by lines, by error"),
    ("R", "What the arms reach"),
    ("1  3  7", "Look from the front, the side, above"),
    ("Drag", "Turn about the point under the pointer"),
    ("Right drag, Shift drag", "Move"),
    ("Wheel, pinch", "Zoom to the pointer"),
    ("Ctrl Z", "Undo"),
    ("Ctrl Shift Z", "Redo"),
    ("Ctrl Shift S", "Copy a link to this view"),
    ("G", "All demos"),
    ("?", "This list"),
    ("Esc", "Close what is on top"),
];

/// The commands of the keys that were pressed, unless a field has the keyboard.
pub(super) fn commands(ctx: &Context, state: &ViewerState) -> Vec<Command> {
    let mut commands = Vec::new();
    let has_focus = ctx.egui_wants_keyboard_input();
    let is_taken = ctx.text_edit_focused() || egui::Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        if !is_taken && input.key_pressed(Key::Escape) {
            commands.push(Command::Escape);
        }
        if has_focus {
            return;
        }
        // The longer shortcut first: consuming Ctrl+Z also matches Ctrl+Shift+Z.
        for (modifiers, key, command) in [
            (Modifiers::COMMAND | Modifiers::SHIFT, Key::Z, Command::Redo),
            (Modifiers::COMMAND | Modifiers::SHIFT, Key::S, Command::Share),
            (Modifiers::COMMAND, Key::Y, Command::Redo),
            (Modifiers::COMMAND, Key::Z, Command::Undo),
        ] {
            if input.consume_key(modifiers, key) {
                commands.push(command);
            }
        }
        let toggled = |overlay: Overlay| if state.overlay == overlay { Overlay::None } else { overlay };
        if input.key_pressed(Key::Questionmark) {
            commands.push(Command::Show(toggled(Overlay::Help)));
        }
        if input.modifiers.any() {
            return;
        }
        for (key, command) in [
            (Key::Space, Command::SetPlaying(!state.playback.playing)),
            (Key::ArrowLeft, Command::Nudge(-0.1)),
            (Key::ArrowRight, Command::Nudge(0.1)),
            (Key::Comma, Command::StepSample { forth: false }),
            (Key::Period, Command::StepSample { forth: true }),
            (Key::Home, Command::Seek(0.0)),
            (Key::End, Command::Seek(f64::MAX)),
            (Key::ArrowUp, Command::MoveSelection(-1)),
            (Key::ArrowDown, Command::MoveSelection(1)),
            (Key::F, Command::FrameAll),
            (Key::O, Command::ToggleFollow),
            (Key::P, Command::Present(state.presentation.is_none())),
            (Key::Num1, Command::Look(NamedView::Front)),
            (Key::Num3, Command::Look(NamedView::Side)),
            (Key::Num7, Command::Look(NamedView::Top)),
            (Key::V, Command::Lab(LabCommand::NextView)),
            (Key::R, Command::Reach(if state.reaching.is_open { ReachCommand::Close } else { ReachCommand::Open })),
            (Key::G, Command::Show(toggled(Overlay::Gallery))),
        ] {
            let has_fit = state.selection.step == Step::Stage(Stage::Fit);
            if input.key_pressed(key) && (key != Key::V || has_fit) {
                commands.push(command);
            }
        }
    });
    commands
}
