//! The 255 colours of a GIF, learned from pictures of the whole animation, so that nothing flickers.

use color_quant::NeuQuant;
use image::RgbaImage;

/// Colours; one index is left for what is see-through.
const COLORS: usize = 255;
/// Pixels of one picture that are learned from.
const LEARNED_PIXELS: usize = 40_000;
/// Of so many pixels that are learned from, one trains the network at a time: its own scale from 1 (best) to 30.
const SAMPLING: i32 = 3;
/// Bits of each channel that tell colours apart when they are looked up.
const BITS: u32 = 6;

/// Colours of pictures to come.
#[derive(Default)]
pub(super) struct Learner {
    pixels: Vec<u8>,
}

impl Learner {
    /// Looks at a picture, at evenly spread pixels of it.
    pub(super) fn look_at(&mut self, picture: &RgbaImage) {
        let count = picture.width() as usize * picture.height() as usize;
        // Odd, so that it falls on every column in turn.
        let step = (count / LEARNED_PIXELS).max(1) | 1;
        for pixel in picture.pixels().step_by(step).filter(|pixel| pixel.0[3] >= 128) {
            let [r, g, b, _] = pixel.0;
            self.pixels.extend([r, g, b, 255]);
        }
    }

    /// The palette for all that was seen.
    pub(super) fn learn(mut self) -> Palette {
        if self.pixels.is_empty() {
            self.pixels.extend([0, 0, 0, 255]);
        }
        let found = NeuQuant::new(SAMPLING, COLORS, &self.pixels).color_map_rgba();
        let colors = found.chunks_exact(4).map(|color| [color[0], color[1], color[2]]).collect();
        Palette { colors, nearest: vec![None; 1 << (3 * BITS)] }
    }
}

/// Colours by their index, and the nearest one to every other.
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    /// By the upper bits of red, green and blue; filled as it is needed.
    nearest: Vec<Option<u8>>,
}

impl Palette {
    /// The index of what is see-through.
    pub(super) const CLEAR: u8 = COLORS as u8;

    /// Red, green and blue of every colour, one after the other; the see-through one is last.
    pub(super) fn bytes(&self) -> Vec<u8> {
        self.colors.iter().flatten().copied().chain([0, 0, 0]).collect()
    }

    /// The colour that is nearest to that of a pixel; see-through below half of the opacity.
    pub(super) fn index_of(&mut self, [r, g, b, alpha]: [u8; 4]) -> u8 {
        if alpha < 128 {
            return Self::CLEAR;
        }
        let upper = |channel: u8| usize::from(channel >> (8 - BITS));
        let cell = upper(r) << (2 * BITS) | upper(g) << BITS | upper(b);
        if let Some(index) = self.nearest[cell] {
            return index;
        }
        // Of the middle of the cell, so that it does not matter which of its colours came first.
        let middle = |channel: u8| i32::from(channel >> (8 - BITS) << (8 - BITS) | 1 << (7 - BITS));
        let wanted = [middle(r), middle(g), middle(b)];
        let apart = |color: &[u8; 3]| -> i32 {
            wanted.iter().zip(color).map(|(wanted, found)| (wanted - i32::from(*found)).pow(2)).sum()
        };
        let best = (0..self.colors.len()).min_by_key(|&index| apart(&self.colors[index])).unwrap_or(0);
        self.nearest[cell] = Some(best as u8);
        best as u8
    }
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    #[test]
    fn colors_that_were_seen_come_back_nearly_the_same() {
        // A ramp of 64 greys and a red patch.
        let picture = RgbaImage::from_fn(64, 32, |x, y| match y {
            0..16 => Rgba([4 * x as u8, 4 * x as u8, 4 * x as u8, 255]),
            _ => Rgba([200, 20, 30, 255]),
        });
        let mut learner = Learner::default();
        learner.look_at(&picture);
        let mut palette = learner.learn();
        assert_eq!(palette.bytes().len(), 3 * 256);
        for pixel in picture.pixels() {
            let index = palette.index_of(pixel.0);
            let found = palette.colors[usize::from(index)];
            // A cell is 4 levels wide, and the network places its colours about as finely.
            assert!(found.iter().zip(pixel.0).all(|(a, b)| a.abs_diff(b) <= 6), "{found:?} for {pixel:?}");
        }
        assert_eq!(palette.index_of([1, 2, 3, 100]), Palette::CLEAR);
    }

    #[test]
    fn nothing_at_all_still_gives_a_palette() {
        let mut palette = Learner::default().learn();
        assert!(palette.index_of([0, 0, 0, 255]) != Palette::CLEAR);
    }
}
