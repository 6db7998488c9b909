//! Where the panels float: one place decides all rectangles.

use egui::{Rect, pos2, vec2};
use serde::{Deserialize, Serialize};

use super::ViewerState;
use super::state::Side;
use super::theme::MARGIN;

/// Below this width, points, the side panels become drawers.
pub(super) const NARROW: f32 = 900.0;
/// Below this width, points, the top bar keeps only what is nowhere else.
const PHONE: f32 = 560.0;
const TOP_BAR: f32 = 44.0;
const TIMELINE: f32 = 122.0;
/// Least and most of what a person can make of the left panel, the right one, and the timeline, points.
const SIZES: [[f32; 2]; 3] = [[208.0, 420.0], [320.0, 720.0], [96.0, 360.0]];
/// So much of the view stays free between the panels, points.
const LEAST_FREE: f32 = 240.0;
/// Caption and line of a presentation.
const CAPTION: f32 = 104.0;

/// A panel's inner edge, which a person can drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// Of the pipeline on the left.
    Left,
    /// Of the inspector on the right.
    Right,
    /// Of the timeline.
    Timeline,
}

impl Edge {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Left, Self::Right, Self::Timeline];

    /// What a person calls the panel.
    pub fn words(self) -> &'static str {
        match self {
            Self::Left => "pipeline panel",
            Self::Right => "inspector",
            Self::Timeline => "timeline",
        }
    }
}

/// Sizes of panels that a person chose, points, by [`Edge`]; `None` is the usual one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PanelSizes(pub [Option<f32>; 3]);

impl PanelSizes {
    /// Sets a size within its range, or back to the usual one.
    pub fn set(&mut self, edge: Edge, size: Option<f32>) {
        let [least, most] = SIZES[edge as usize];
        self.0[edge as usize] = size.filter(|size| size.is_finite()).map(|size| size.max(least).min(most));
    }

    fn of(&self, edge: Edge, usual: f32) -> f32 {
        self.0[edge as usize].unwrap_or(usual)
    }
}

/// The rectangles of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) window: Rect,
    pub(super) top: Rect,
    pub(super) left: Option<Rect>,
    pub(super) right: Option<Rect>,
    pub(super) timeline: Rect,
    /// What the panels leave free of the view.
    pub(super) free: Rect,
    pub(super) is_narrow: bool,
    /// As narrow as a phone: what can be reached elsewhere leaves the top bar.
    pub(super) is_phone: bool,
}

impl Layout {
    /// With panels of the usual sizes.
    pub(super) fn new(window: Rect, drawer: Option<Side>) -> Self {
        Self::sized(window, drawer, &PanelSizes::default())
    }

    fn sized(window: Rect, drawer: Option<Side>, sizes: &PanelSizes) -> Self {
        let is_narrow = window.width() < NARROW;
        let inner = window.shrink(MARGIN);
        let top = Rect::from_min_size(inner.min, vec2(inner.width(), TOP_BAR));
        let timeline = sizes.of(Edge::Timeline, TIMELINE).min(0.5 * inner.height());
        let timeline = Rect::from_min_max(pos2(inner.left(), inner.bottom() - timeline), inner.max);
        let (y0, y1) = (top.bottom() + MARGIN, timeline.top() - MARGIN);
        let widest = inner.width();
        let left_width = if is_narrow { 256.0 } else { sizes.of(Edge::Left, 248.0) };
        let usual = (0.3125 * window.width()).max(344.0).min(408.0);
        let most = (widest - left_width - LEAST_FREE).max(SIZES[1][0]);
        let right_width = if is_narrow { 392.0 } else { sizes.of(Edge::Right, usual).min(most) };
        let left = Rect::from_min_max(pos2(inner.left(), y0), pos2(inner.left() + left_width.min(widest), y1));
        let right = Rect::from_min_max(pos2(inner.right() - right_width.min(widest), y0), pos2(inner.right(), y1));
        let shown = |side: Side| !is_narrow || drawer == Some(side);
        let free_x0 = if is_narrow { window.left() } else { left.right() };
        let free_x1 = if is_narrow { window.right() } else { right.left() };
        Self {
            window,
            top,
            left: shown(Side::Left).then_some(left),
            right: shown(Side::Right).then_some(right),
            timeline,
            free: Rect::from_min_max(pos2(free_x0, top.bottom()), pos2(free_x1, timeline.top())),
            is_narrow,
            is_phone: window.width() < PHONE,
        }
    }

    /// The rectangles of a state: those of the panels, or those of the presentation without them.
    pub(super) fn of(window: Rect, state: &ViewerState) -> Self {
        if state.presentation.is_none() {
            return Self::sized(window, state.drawer, &state.sizes);
        }
        let inner = window.shrink(MARGIN);
        let timeline = Rect::from_min_max(pos2(inner.left(), inner.bottom() - CAPTION), inner.max);
        Self {
            top: Rect::from_min_size(inner.min, vec2(inner.width(), TOP_BAR)),
            left: None,
            right: None,
            timeline,
            free: Rect::from_min_max(window.min, pos2(window.right(), timeline.top())),
            ..Self::new(window, None)
        }
    }

    /// The picture's rectangle: it covers the window and its middle is the middle of the free part, so that what the
    /// camera looks at stands between the panels.
    pub(super) fn picture(&self) -> Rect {
        let middle = self.free.center();
        let reach = |low: f32, at: f32, high: f32| (at - low).max(high - at);
        let half = vec2(
            reach(self.window.left(), middle.x, self.window.right()),
            reach(self.window.top(), middle.y, self.window.bottom()),
        );
        Rect::from_center_size(middle, 2.0 * half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_never_overlap_and_stay_in_the_window() {
        for (width, height) in [(1440.0, 900.0), (1280.0, 720.0), (900.0, 600.0), (700.0, 900.0), (360.0, 640.0)] {
            for drawer in [None, Some(Side::Left), Some(Side::Right)] {
                let window = Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height));
                for sizes in [[None; 3], [Some(999.0); 3], [Some(0.0); 3]] {
                    let mut chosen = PanelSizes::default();
                    Edge::ALL.iter().zip(sizes).for_each(|(edge, size)| chosen.set(*edge, size));
                    let layout = Layout::sized(window, drawer, &chosen);
                    let panels: Vec<Rect> = [Some(layout.top), layout.left, layout.right, Some(layout.timeline)]
                        .into_iter()
                        .flatten()
                        .collect();
                    for (i, a) in panels.iter().enumerate() {
                        assert!(window.contains_rect(*a), "{a:?} leaves {window:?}");
                        for b in &panels[i + 1..] {
                            assert!(!a.intersects(*b), "{a:?} meets {b:?} at {width} × {height}");
                        }
                    }
                    assert!(layout.picture().contains_rect(window));
                    assert!((layout.picture().center() - layout.free.center()).length() < 1e-3);
                    assert!(layout.is_narrow || layout.free.width() >= LEAST_FREE - 1.0 || width < 1000.0);
                }
            }
        }
    }
}
