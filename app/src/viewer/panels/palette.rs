//! The palette: everything that can be done, found by some of the letters of its name.

use egui::{Align, Context, Id, Key, Modal, Modifiers, Rect, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2};

use super::Out;
use crate::viewer::actions::{self, Action};
use crate::viewer::fields::search;
use crate::viewer::theme::{BODY, SECONDARY, SMALL_RADIUS, Tokens, font};
use crate::viewer::widgets::{elided, overlay_frame, paragraph, text_in};
use crate::viewer::{Command, Overlay, ViewerState};

const WIDTH: f32 = 560.0;
const ROW: f32 = 32.0;
/// Rows that are seen at once.
const SEEN: f32 = 11.0;

/// What was typed, and which row the arrows have reached.
#[derive(Clone, Default)]
struct Asked {
    words: String,
    row: usize,
}

/// The palette that opens next has these words in its field already.
pub(in crate::viewer) fn start_with(ctx: &Context, words: String) {
    ctx.data_mut(|data| data.insert_temp(asked_id(), Asked { words, row: 0 }));
}

fn asked_id() -> Id {
    Id::unique("Palette")
}

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let id = asked_id();
    let mut asked: Asked = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let frame = overlay_frame(tokens, 12);
    let window = ui.max_rect();
    let (up, down, enter) = ui.input_mut(|input| {
        let mut taken = |key| input.consume_key(Modifiers::NONE, key);
        (taken(Key::ArrowUp), taken(Key::ArrowDown), taken(Key::Enter))
    });
    let mut chosen = None;
    let modal = Modal::new(id).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        let width = WIDTH.min(window.width() - 60.0);
        ui.set_width(width);
        ui.spacing_mut().item_spacing.y = 2.0;
        let name = "Find anything";
        let field = ui.scope_id().with(name);
        ui.memory_mut(|memory| memory.request_focus(field));
        if let Some(words) = search(ui, name, "What would you like to do?", &asked.words, width) {
            asked = Asked { words, row: 0 };
        }
        ui.add_space(6.0);
        let found = found(state, &asked.words);
        let last = found.len().saturating_sub(1);
        asked.row = match (up, down) {
            (true, _) => asked.row.checked_sub(1).unwrap_or(last),
            (_, true) if asked.row >= last => 0,
            (_, true) => asked.row + 1,
            _ => asked.row.min(last),
        };
        if found.is_empty() {
            let _none = paragraph(ui, "Nothing is called so.", BODY, tokens.secondary);
        }
        let height = (SEEN * ROW).min(window.height() - 200.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            for (index, action) in found.iter().enumerate() {
                let is_at = index == asked.row;
                let response = row(ui, action, is_at);
                if is_at && (up || down) {
                    response.scroll_to_me(None);
                }
                if response.clicked() || (is_at && enter) {
                    chosen = Some(action.command.clone());
                }
            }
        });
    });
    let is_over = chosen.is_some() || modal.should_close();
    if is_over {
        out.push(Command::Show(Overlay::None));
        ui.data_mut(|data| data.remove::<Asked>(id));
    } else {
        ui.data_mut(|data| data.insert_temp(id, asked));
    }
    out.commands.extend(chosen);
}

/// What can be done now and has the letters in its name, the best first.
fn found(state: &ViewerState, words: &str) -> Vec<Action> {
    let mut found: Vec<(u32, Action)> = actions::with_keys(state)
        .into_iter()
        .chain(actions::without_keys(state))
        .filter(|action| action.is_possible && action.command != Command::Show(Overlay::None))
        .filter(|action| action.command != Command::Escape)
        .filter_map(|action| Some((cost(words, &format!("{} {}", action.title, action.topic.title()))?, action)))
        .collect();
    // A stable sort: equal ones stay in the order of the list.
    found.sort_by_key(|(cost, _)| *cost);
    found.into_iter().map(|(_, action)| action).collect()
}

/// How far apart the letters of `words` stand in `text`, in their order; `None` if they do not all occur. The start of a
/// word costs nothing, letters that are passed over cost one each.
fn cost(words: &str, text: &str) -> Option<u32> {
    let text: Vec<char> = text.to_lowercase().chars().collect();
    let mut cost = 0;
    for word in words.to_lowercase().split_whitespace() {
        let word: Vec<char> = word.chars().collect();
        cost += (0..text.len()).filter_map(|from| cost_from(&word, &text, from)).min()?;
    }
    Some(cost)
}

/// As [`cost`] for one word whose first letter stands at a place.
fn cost_from(word: &[char], text: &[char], from: usize) -> Option<u32> {
    let starts_word = from == 0 || !text[from - 1].is_alphanumeric();
    let mut cost = if starts_word { 0 } else { 4 };
    let mut at = from;
    for (index, letter) in word.iter().enumerate() {
        let passed = text[at..].iter().position(|other| other == letter)?;
        if index == 0 && passed > 0 {
            return None;
        }
        cost += passed as u32;
        at += passed + 1;
    }
    Some(cost)
}

fn row(ui: &mut Ui, action: &Action, is_at: bool) -> egui::Response {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::MenuItem, true, is_at, action.title.as_ref()));
    if is_at || response.hovered() {
        ui.painter().rect_filled(rect, SMALL_RADIUS, if is_at { tokens.hover } else { tokens.well });
    }
    let mut right = rect.right() - 10.0;
    if let Some(shortcut) = action.shortcut {
        let galley = ui.painter().layout_no_wrap(shortcut.name.to_owned(), font(SECONDARY), tokens.secondary);
        right -= galley.size().x;
        ui.painter().galley(pos2(right, rect.center().y - 0.5 * galley.size().y), galley, tokens.secondary);
        right -= 14.0;
    }
    let topic = elided(ui, action.topic.title(), font(SECONDARY), tokens.faint, 60.0);
    let title = Rect::from_min_max(pos2(rect.left() + 74.0, rect.top()), pos2(right, rect.bottom()));
    ui.painter().galley(pos2(rect.left() + 10.0, rect.center().y - 0.5 * topic.size().y), topic, tokens.faint);
    let _text = text_in(ui, title, Align::Min, &action.title, font(BODY), tokens.text);
    response.on_hover_cursor(egui::CursorIcon::PointingHand)
}

#[cfg(test)]
mod tests {
    use super::cost;

    #[test]
    fn letters_are_found_in_their_order_and_starts_of_words_first() {
        assert_eq!(cost("", "Frame everything"), Some(0));
        assert_eq!(cost("frame", "Frame everything"), Some(0));
        assert!(cost("fev", "Frame everything").is_some());
        assert_eq!(cost("xyz", "Frame everything"), None);
        assert!(cost("top", "To the top") < cost("top", "Stop the computation"));
        assert!(cost("every frame", "Frame everything").is_some(), "words may come in any order");
        assert!(cost("öffne", "ÖFFNE").is_some(), "case is no matter of ASCII alone");
    }
}
