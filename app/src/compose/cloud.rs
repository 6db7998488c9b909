//! The cloud: its points in the colours that a person asked for.

use std::sync::Arc;

use endcomfort_core::job::SceneOutput;
use endcomfort_core::segment::PointFate;
use nalgebra::Point3;

use super::{Composer, Content, MOVED_M, Palette};
use crate::render::{ColorMap, Frame, PointsDraw, Scale, Theme, bytes_of};
use crate::viewer::CloudColor;

/// Address and number of the points, whether they are segmented, the cluster that is not seen, whether the others are
/// only its surroundings, what colours them, and the theme.
type CloudKey = (usize, usize, bool, Option<usize>, bool, CloudColor, Theme);

/// The points as they were coloured last.
pub(super) struct CloudCache {
    key: CloudKey,
    points: Arc<Vec<Point3<f64>>>,
    colors: Arc<Vec<[u8; 4]>>,
}

/// The scale of what colours the points, metres; `None` where colours are no amounts.
pub fn cloud_scale(cloud: &SceneOutput, by: CloudColor) -> Option<Scale> {
    let value = amount(cloud, by)?;
    Some(Scale::covering(ColorMap::Viridis, cloud.cloud.points.iter().map(value)))
}

/// Gives the amount that colours a point, metres.
type Amount = Box<dyn Fn(&Point3<f64>) -> f64>;

fn amount(cloud: &SceneOutput, by: CloudColor) -> Option<Amount> {
    match by {
        CloudColor::Height => Some(Box::new(|p_W| p_W.z)),
        CloudColor::Distance => {
            let eye = Point3::from(cloud.cloud.X_FC?.translation.vector);
            Some(Box::new(move |p_W| (p_W - eye).norm()))
        }
        CloudColor::Fate | CloudColor::Own => None,
    }
}

/// The colour of each point by what became of it. Each fate is looked up once: there are few, and points many.
fn fate_colors(fates: &[PointFate], color: impl Fn(PointFate) -> [f32; 4]) -> Vec<[u8; 4]> {
    let mut colors = vec![[0; 4]; fates.len()];
    let mut known: Vec<(PointFate, [u8; 4])> = Vec::new();
    let mut last = 0;
    for index in 0..fates.len() {
        let fate = fates[index];
        if known.get(last).is_none_or(|(known, _)| *known != fate) {
            last = known.iter().position(|(known, _)| *known == fate).unwrap_or(known.len());
            if last == known.len() {
                known.push((fate, bytes_of(color(fate))));
            }
        }
        colors[index] = known[last].1;
    }
    colors
}

fn opaque([r, g, b, _]: [f32; 4]) -> [f32; 4] {
    [r, g, b, 1.0]
}

impl Composer {
    pub(super) fn add_cloud(&mut self, frame: &mut Frame, cloud: &SceneOutput, input: &Content<'_>, palette: &Palette) {
        let points = &cloud.cloud.points;
        let moved = match (input.X_WO, input.X_WO_start) {
            (Some(now), Some(start)) => (now.translation.vector - start.translation.vector).norm() > MOVED_M,
            _ => false,
        };
        // A moved object has left its points behind; an examined fit draws them itself.
        let target = input.segment.map(|s| s.target);
        let hidden = input.lab.as_ref().map(|lab| lab.cluster).or(target.filter(|_| moved));
        let by = input.cloud_look.by;
        let (is_segmented, is_lab) = (input.segment.is_some(), input.lab.is_some());
        let key = (points.as_ptr() as usize, points.len(), is_segmented, hidden, is_lab, by, input.theme);
        if self.cloud.as_ref().is_none_or(|cache| cache.key != key) {
            let fates = input.segment.map(|s| s.fates.as_slice()).filter(|fates| fates.len() == points.len());
            let mut colors = match fates {
                Some(fates) => fate_colors(fates, |fate| palette.fate(fate, target, hidden, input.lab.is_some())),
                None => vec![bytes_of(palette.cloud); points.len()],
            };
            // What is not seen stays unseen.
            let seen = colors.iter_mut().zip(points).enumerate().filter(|(_, (color, _))| color[3] > 0);
            if let Some((value, scale)) = amount(cloud, by).zip(cloud_scale(cloud, by)) {
                seen.for_each(|(_, (color, point))| *color = bytes_of(opaque(scale.color(value(point)))));
            } else if by == CloudColor::Own {
                let own = &cloud.cloud.colors;
                seen.filter_map(|(i, (color, _))| Some((color, own.get(i)?)))
                    .for_each(|(color, [r, g, b])| *color = [*r, *g, *b, 255]);
            }
            // The same points in other colours are the same points.
            let kept = self.cloud.take().filter(|cache| (cache.key.0, cache.key.1) == (key.0, key.1));
            let points = kept.map_or_else(|| Arc::new(points.clone()), |cache| cache.points);
            self.cloud = Some(CloudCache { key, points, colors: Arc::new(colors) });
        }
        if let Some(cache) = &self.cloud {
            frame.points.push(PointsDraw {
                points: cache.points.clone(),
                colors: cache.colors.clone(),
                diameter_m: input.cloud_look.diameter_m,
            });
        }
    }
}
