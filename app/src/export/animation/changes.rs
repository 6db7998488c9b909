//! What differs from one frame to the next.

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Area {
    /// The whole of a picture.
    pub(super) fn whole(width: usize, height: usize) -> Self {
        Self { left: 0, top: 0, width, height }
    }

    /// The smallest area that holds every pixel that differs; without any, the first pixel. Both pictures have rows of
    /// `width` pixels.
    pub(super) fn of_changes<T: PartialEq>(before: &[T], now: &[T], width: usize) -> Self {
        let mut rows = before.chunks(width).zip(now.chunks(width)).enumerate();
        let mut area: Option<[usize; 4]> = None;
        for (y, (old, new)) in rows.by_ref().filter(|(_, (old, new))| old != new) {
            let differs = |x: &usize| old[*x] != new[*x];
            let first = (0..width).find(differs).unwrap_or(0);
            let last = (0..width).rev().find(differs).unwrap_or(0);
            let [left, top, right, _] = area.unwrap_or([first, y, last, y]);
            area = Some([left.min(first), top, right.max(last), y]);
        }
        let [left, top, right, bottom] = area.unwrap_or([0; 4]);
        Self { left, top, width: right - left + 1, height: bottom - top + 1 }
    }

    /// Indices of its pixels in a picture with rows of `width` pixels, row by row.
    pub(super) fn indices(self, width: usize) -> impl Iterator<Item = usize> {
        let rows = self.top..self.top + self.height;
        rows.flat_map(move |y| (self.left..self.left + self.width).map(move |x| y * width + x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_holds_every_change_and_no_more() {
        let before = [0; 20];
        let mut now = before;
        (now[7], now[16]) = (1, 1);
        // Rows of five: pixel 7 is (2, 1), pixel 16 is (1, 3).
        let area = Area::of_changes(&before, &now, 5);
        assert_eq!(area, Area { left: 1, top: 1, width: 2, height: 3 });
        assert_eq!(area.indices(5).collect::<Vec<_>>(), [6, 7, 11, 12, 16, 17]);
        let none = Area::of_changes(&before, &before, 5);
        assert_eq!(none, Area { left: 0, top: 0, width: 1, height: 1 });
    }
}
