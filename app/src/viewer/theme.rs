//! Colours, type and spacing: the tokens of both themes, and egui's style made from them.

use std::sync::Arc;

use egui::epaint::Shadow;
use egui::epaint::text::{FontTweak, VariationCoords};
use egui::{
    Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke, TextStyle, Ui, Vec2,
};

use super::font::with_tabular_figures;

/// Gap between a panel and the window, and between panels, points.
pub(super) const MARGIN: f32 = 12.0;
/// Corner radius of a panel, points.
pub(super) const RADIUS: u8 = 10;
/// Corner radius of buttons and fields, points.
pub(super) const SMALL_RADIUS: u8 = 6;
/// Size of headings of panels, points.
pub(super) const TITLE: f32 = 15.0;
/// Size of running text, points.
pub(super) const BODY: f32 = 13.0;
/// Size of secondary text, points.
pub(super) const SECONDARY: f32 = 12.0;
/// Size of small headings and captions, points.
pub(super) const SMALL: f32 = 11.0;

/// The colours of a theme: the same names in both, other values.
#[derive(Clone, Debug, PartialEq)]
pub struct Tokens {
    /// Background of the view at its centre.
    pub view_centre: Color32,
    /// Background of the view at its edge.
    pub view_edge: Color32,
    /// Fill of floating panels, slightly see-through.
    pub panel: Color32,
    /// Fill of menus and overlays, opaque.
    pub overlay: Color32,
    /// What lies behind an overlay.
    pub scrim: Color32,
    /// Fields and tracks, sunk into a panel.
    pub well: Color32,
    /// A row or a button under the pointer.
    pub hover: Color32,
    /// A selected row.
    pub selected: Color32,
    /// Hairlines.
    pub line: Color32,
    /// Text.
    pub text: Color32,
    /// Secondary text; at least 4.5 : 1 on a panel.
    pub secondary: Color32,
    /// Lines of icons and marks that say nothing alone; not for text.
    pub faint: Color32,
    /// Fit, accepted, accent.
    pub teal: Color32,
    /// Teal for text.
    pub teal_text: Color32,
    /// Text on a teal field.
    pub on_teal: Color32,
    /// Goal, transport.
    pub amber: Color32,
    /// Rejected, collision.
    pub coral: Color32,
    /// Cloud, reach, left arm.
    pub blue: Color32,
    /// Grasps, right arm.
    pub violet: Color32,
    /// Neutral data, retreat.
    pub slate: Color32,
    /// Shadow under panels.
    pub shadow: Shadow,
}

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

const fn shadow(alpha: u8) -> Shadow {
    Shadow { offset: [0, 4], blur: 18, spread: 0, color: Color32::from_black_alpha(alpha) }
}

impl Tokens {
    /// Colours for a dark room.
    pub const DARK: Self = Self {
        view_centre: rgb(0x1b2129),
        view_edge: rgb(0x0d1014),
        // #13171c at 92 %, premultiplied.
        panel: Color32::from_rgba_premultiplied(17, 21, 26, 235),
        overlay: rgb(0x161b21),
        scrim: Color32::from_black_alpha(150),
        well: rgb(0x1b2129),
        hover: rgb(0x1d242c),
        selected: rgb(0x173230),
        line: rgb(0x252d36),
        text: rgb(0xe7eaed),
        secondary: rgb(0x96a1ad),
        faint: rgb(0x5b6672),
        teal: rgb(0x3ec6b0),
        teal_text: rgb(0x3ec6b0),
        on_teal: rgb(0x0b1512),
        amber: rgb(0xf0b34a),
        coral: rgb(0xee6a5c),
        blue: rgb(0x6ca9ff),
        violet: rgb(0xb08cff),
        slate: rgb(0x7d8894),
        shadow: shadow(70),
    };

    /// Colours for a light room.
    pub const LIGHT: Self = Self {
        view_centre: rgb(0xfbfaf7),
        view_edge: rgb(0xe4e6e4),
        // #ffffff at 95 %, premultiplied.
        panel: Color32::from_rgba_premultiplied(242, 242, 242, 242),
        overlay: rgb(0xffffff),
        scrim: Color32::from_rgba_premultiplied(22, 24, 26, 110),
        well: rgb(0xf0f1f0),
        hover: rgb(0xf0f2f1),
        selected: rgb(0xdcf0ed),
        line: rgb(0xdfe2e1),
        text: rgb(0x1d2329),
        secondary: rgb(0x5f6973),
        faint: rgb(0xa3abb2),
        teal: rgb(0x0d9a85),
        teal_text: rgb(0x0a7868),
        on_teal: rgb(0x06110f),
        amber: rgb(0xc98208),
        coral: rgb(0xc23e31),
        blue: rgb(0x2f74d8),
        violet: rgb(0x7d56d6),
        slate: rgb(0x88929b),
        shadow: shadow(18),
    };

    /// The tokens of the theme that a `Ui` is drawn in.
    pub fn of(ui: &Ui) -> &'static Self {
        Self::for_dark(ui.visuals().dark_mode)
    }

    /// The tokens of the dark or the light theme.
    pub fn for_dark(dark: bool) -> &'static Self {
        if dark { &Self::DARK } else { &Self::LIGHT }
    }
}

/// Inter at a size in points.
pub(super) fn font(size: f32) -> FontId {
    FontId::new(size, FontFamily::Proportional)
}

/// Inter semibold at a size in points.
pub(super) fn strong(size: f32) -> FontId {
    FontId::new(size, FontFamily::Name(STRONG.into()))
}

const STRONG: &str = "strong";

/// Gives egui our font and our style for both themes.
pub fn install(ctx: &Context) {
    ctx.set_fonts(fonts());
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        ctx.style_mut_of(theme, |style| restyle(style, Tokens::for_dark(theme == egui::Theme::Dark)));
    }
}

fn fonts() -> FontDefinitions {
    // As `build/thin_font.rs` left it.
    let inter = Arc::new(with_tabular_figures(include_bytes!(concat!(env!("OUT_DIR"), "/inter.ttf"))));
    let face = |weight: f32| {
        let coords = VariationCoords::new([(b"wght", weight)]);
        Arc::new(FontData::from_blob(inter.clone(), 0).tweak(FontTweak {
            coords,
            hinting: Some(false),
            ..FontTweak::default()
        }))
    };
    let mut fonts = FontDefinitions::empty();
    fonts.font_data.insert("inter".to_owned(), face(400.0));
    fonts.font_data.insert("inter-strong".to_owned(), face(600.0));
    for (family, name) in [
        (FontFamily::Proportional, "inter"),
        (FontFamily::Monospace, "inter"),
        (FontFamily::Name(STRONG.into()), "inter-strong"),
    ] {
        fonts.families.insert(family, vec![name.to_owned()]);
    }
    fonts
}

fn restyle(style: &mut egui::Style, tokens: &Tokens) {
    style.text_styles = [
        (TextStyle::Heading, strong(TITLE)),
        (TextStyle::Body, font(BODY)),
        (TextStyle::Monospace, font(SECONDARY)),
        (TextStyle::Button, font(BODY)),
        (TextStyle::Small, font(SMALL)),
    ]
    .into();
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = 0.35;
    style.animation_time = 0.12;
    style.spacing.item_spacing = Vec2::new(8.0, 4.0);
    style.spacing.menu_margin = egui::Margin::same(6);
    style.spacing.tooltip_width = 320.0;
    style.spacing.scroll = egui::style::ScrollStyle {
        floating: true,
        bar_width: 7.0,
        floating_width: 3.0,
        floating_allocated_width: 0.0,
        foreground_color: false,
        fade: egui::style::ScrollFadeStyle { strength: 0.0, ..egui::style::ScrollFadeStyle::default() },
        ..egui::style::ScrollStyle::floating()
    };
    let visuals = &mut style.visuals;
    visuals.override_text_color = Some(tokens.text);
    visuals.weak_text_color = Some(tokens.secondary);
    visuals.panel_fill = tokens.view_edge;
    visuals.window_fill = tokens.overlay;
    visuals.window_stroke = Stroke::new(1.0, tokens.line);
    visuals.window_corner_radius = CornerRadius::same(RADIUS);
    visuals.menu_corner_radius = CornerRadius::same(RADIUS);
    visuals.window_shadow = tokens.shadow;
    visuals.popup_shadow = tokens.shadow;
    visuals.extreme_bg_color = tokens.well;
    visuals.faint_bg_color = tokens.hover;
    visuals.selection.bg_fill = tokens.teal.gamma_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, tokens.teal);
    visuals.text_cursor.stroke = Stroke::new(1.5, tokens.teal);
    visuals.hyperlink_color = tokens.teal_text;
    visuals.warn_fg_color = tokens.amber;
    visuals.error_fg_color = tokens.coral;
    visuals.striped = false;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, tokens.line);
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, tokens.text);
    for (widget, fill) in [
        (&mut widgets.inactive, tokens.faint.gamma_multiply(0.7)),
        (&mut widgets.hovered, tokens.faint),
        (&mut widgets.active, tokens.slate),
        (&mut widgets.open, tokens.hover),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = Stroke::NONE;
        widget.fg_stroke = Stroke::new(1.0, tokens.text);
        widget.corner_radius = CornerRadius::same(SMALL_RADIUS);
        widget.expansion = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast ratio of WCAG 2.2 between two opaque colours.
    fn contrast(a: Color32, b: Color32) -> f64 {
        let luminance = |c: Color32| {
            let linear = |v: u8| {
                let v = f64::from(v) / 255.0;
                if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
            };
            0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b())
        };
        let (x, y) = (luminance(a), luminance(b));
        (x.max(y) + 0.05) / (x.min(y) + 0.05)
    }

    #[test]
    fn every_text_colour_has_enough_contrast_on_every_surface_it_stands_on() {
        for tokens in [&Tokens::DARK, &Tokens::LIGHT] {
            // A panel lies over the view; its premultiplied colour plus the view behind it is what is seen.
            let alpha = f32::from(tokens.panel.a()) / 255.0;
            let over = |behind: Color32| {
                let mix = |p: u8, v: u8| (f32::from(p) + (1.0 - alpha) * f32::from(v)) as u8;
                Color32::from_rgb(
                    mix(tokens.panel.r(), behind.r()),
                    mix(tokens.panel.g(), behind.g()),
                    mix(tokens.panel.b(), behind.b()),
                )
            };
            for surface in [over(tokens.view_centre), over(tokens.view_edge), tokens.overlay, tokens.hover] {
                for text in [tokens.text, tokens.secondary, tokens.teal_text, tokens.coral] {
                    let ratio = contrast(text, surface);
                    assert!(ratio >= 4.5, "{text:?} on {surface:?} has only {ratio:.2}");
                }
            }
            assert!(contrast(tokens.on_teal, tokens.teal) >= 4.5);
            assert!(contrast(tokens.text, tokens.selected) >= 4.5);
            assert!(contrast(tokens.secondary, tokens.selected) >= 4.5);
        }
    }
}
