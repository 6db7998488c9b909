//! Figures of equal width: egui cannot ask a font for its `tnum` feature, so the font is made to apply it always.

/// The font with its tabular figures switched on for good.
///
/// In the font's `GSUB` table the feature `tnum` (tabular figures) gets the tag `rclt` (required contextual
/// alternates), which every shaper applies without being asked (OpenType 1.9, chapter 2 "Script list table and feature
/// list table"). A font without that feature, or bytes that are no font, come back as they are.
pub(super) fn with_tabular_figures(font: &[u8]) -> Vec<u8> {
    let mut bytes = font.to_vec();
    for at in tabular_tags(font).unwrap_or_default() {
        if let Some(tag) = bytes.get_mut(at..at + 4) {
            tag.copy_from_slice(b"rclt");
        }
    }
    bytes
}

/// Where the tag `tnum` stands in the feature list.
fn tabular_tags(font: &[u8]) -> Option<Vec<usize>> {
    let tables = u16_at(font, 4)? as usize;
    let directory = (0..tables).map(|i| 12 + 16 * i);
    let gsub_entry = directory.into_iter().find(|&at| font.get(at..at + 4) == Some(b"GSUB"))?;
    let gsub = u32_at(font, gsub_entry + 8)? as usize;
    let features = gsub + u16_at(font, gsub + 6)? as usize;
    let count = u16_at(font, features)? as usize;
    let records = (0..count).map(|i| features + 2 + 6 * i);
    Some(records.filter(|&at| font.get(at..at + 4) == Some(b"tnum")).collect())
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;

    #[test]
    fn all_digits_are_equally_wide_once_the_style_is_installed() {
        let mut harness =
            egui_kittest::Harness::builder().with_context_setup(crate::viewer::theme::install).build_ui(|_| ());
        harness.run();
        let width = |text: &str, id: egui::FontId| {
            let lay = |fonts: &mut egui::epaint::text::FontsView<'_>| {
                fonts.layout_no_wrap(text.to_owned(), id, egui::Color32::WHITE).size().x
            };
            harness.ctx.fonts_mut(lay)
        };
        for id in [crate::viewer::theme::font(13.0), crate::viewer::theme::strong(13.0)] {
            let ones = width("1111111111", id.clone());
            let zeros = width("0000000000", id.clone());
            assert!((ones - zeros).abs() < 0.1, "{ones} against {zeros}");
            // Letters keep their own widths, so the test sees a proportional font.
            assert!(width("iiiiiiiiii", id.clone()) < 0.6 * width("mmmmmmmmmm", id));
        }
    }

    #[test]
    fn bytes_that_are_no_font_come_back_as_they_are() {
        assert_eq!(with_tabular_figures(b"not a font"), b"not a font");
        assert_eq!(with_tabular_figures(&[]), Vec::<u8>::new());
    }
}
