//! The cloud: its points in the colours that a person asked for.

use std::sync::Arc;

use endcomfort_core::job::SceneOutput;
use nalgebra::Point3;

use super::{Composer, Content, MOVED_M, Palette};
use crate::render::{ColorMap, Frame, PointsDraw, Scale, Theme};
use crate::viewer::CloudColor;

/// Address and number of the points, whether they are segmented, the cluster that is not seen, whether the others are
/// only its surroundings, what colours them, and the theme.
type CloudKey = (usize, usize, bool, Option<usize>, bool, CloudColor, Theme);

/// The points as they were coloured last.
pub(super) struct CloudCache {
    key: CloudKey,
    points: Arc<Vec<Point3<f64>>>,
    colors: Arc<Vec<[f32; 4]>>,
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
            let fate_of = |i: usize| {
                fates.map_or(palette.cloud, |fates| palette.fate(fates[i], target, hidden, input.lab.is_some()))
            };
            let colored = amount(cloud, by).zip(cloud_scale(cloud, by));
            let own = &cloud.cloud.colors;
            let color = |i: usize| {
                let fate = fate_of(i);
                let rgb = match (&colored, own.get(i)) {
                    (Some((value, scale)), _) => scale.color(value(&points[i])),
                    (None, Some(rgb)) if by == CloudColor::Own => {
                        let [r, g, b] = rgb.map(|channel| f32::from(channel) / 255.0);
                        [r, g, b, 1.0]
                    }
                    _ => return fate,
                };
                // What is not seen stays unseen.
                [rgb[0], rgb[1], rgb[2], if fate[3] > 0.0 { 1.0 } else { 0.0 }]
            };
            let colors = (0..points.len()).map(color).collect();
            self.cloud = Some(CloudCache { key, points: Arc::new(points.clone()), colors: Arc::new(colors) });
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
