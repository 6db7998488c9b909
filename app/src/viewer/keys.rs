//! The keyboard.

use egui::{Context, Event, Key, Modifiers};

use super::actions::{self, Shortcut};
use super::panels::palette;
use super::{Command, Overlay, ViewerState};

/// The commands of the keys that were pressed, unless a field has the keyboard.
pub(super) fn commands(ctx: &Context, state: &ViewerState) -> Vec<Command> {
    let is_searching = state.overlay == Overlay::Palette;
    if !is_searching && let Some(words) = ctx.input_mut(typed_ahead) {
        palette::start_with(ctx, words);
    }
    // The palette's field takes the keyboard when it is drawn; until then the keys are not for the page either.
    let has_focus = is_searching || ctx.egui_wants_keyboard_input();
    let is_taken = ctx.text_edit_focused() || egui::Popup::is_any_open(ctx);
    let mut commands = Vec::new();
    for action in actions::with_keys(state) {
        let Some(Shortcut { modifiers, key, .. }) = action.shortcut else { continue };
        let is_heard = match key {
            Key::Escape => !is_taken,
            // The palette opens from anywhere, also from a field.
            Key::K if modifiers.command => true,
            _ => !has_focus,
        };
        if is_heard && ctx.input_mut(|input| pressed(input, modifiers, key)) && action.is_possible {
            commands.push(action.command);
        }
    }
    // The other key for it.
    if !has_focus && ctx.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Y)) {
        commands.push(Command::Redo);
    }
    commands
}

/// What was typed behind the chord of the palette within one frame, `None` without the chord. It is meant for the field
/// that the next frame will show, and where frames are long it can be a whole word.
fn typed_ahead(input: &mut egui::InputState) -> Option<String> {
    let opens =
        |event: &Event| matches!(event, Event::Key { key: Key::K, pressed: true, modifiers, .. } if modifiers.command);
    let chord = input.events.iter().position(opens)?;
    let mut words = String::new();
    let behind = input.events.split_off(chord + 1);
    input.events.extend(behind.into_iter().filter(|event| match event {
        Event::Text(text) => {
            words.push_str(text);
            false
        }
        Event::Key { pressed, .. } => !pressed,
        _ => true,
    }));
    Some(words)
}

/// A chord counts once, the longer one first: consuming Ctrl+Z also matches Ctrl+Shift+Z. A single key counts if nothing
/// is held with it, but for what some keyboards need to make it.
fn pressed(input: &mut egui::InputState, modifiers: Modifiers, key: Key) -> bool {
    if modifiers.any() {
        return input.consume_key(modifiers, key);
    }
    // What was held when the key went down: by the end of a long frame it may have been let go.
    let may_be_held = matches!(key, Key::Questionmark | Key::Escape);
    input.events.iter().any(|event| match event {
        Event::Key { key: pressed, pressed: true, modifiers, .. } => {
            *pressed == key && (may_be_held || !modifiers.any())
        }
        _ => false,
    })
}
