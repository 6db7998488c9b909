//! Requests and updates as bytes, for `postMessage`.
//!
//! MessagePack with field names: compact for clouds (each list of numbers is one piece of bytes), and self-describing,
//! which the internally tagged enums of a scene file need ([`endcomfort_core::scene::Task`]) and most other binary
//! formats do not offer.

use serde::{Serialize, de::DeserializeOwned};

/// A message that is not what the other side would send.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WireError {
    /// The value cannot be written.
    #[error("cannot write a message: {0}")]
    Write(#[from] rmp_serde::encode::Error),
    /// The bytes are no such value.
    #[error("cannot read a message of {length} bytes: {cause}")]
    Read {
        /// Length of the message.
        length: usize,
        /// What the reader found.
        cause: rmp_serde::decode::Error,
    },
}

/// A request or an update as bytes.
///
/// # Errors
/// [`WireError::Write`] if the value cannot be represented.
pub fn to_bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, WireError> {
    Ok(rmp_serde::to_vec_named(value)?)
}

/// A request or an update from its bytes.
///
/// # Errors
/// [`WireError::Read`] if the bytes are not such a value.
pub fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    rmp_serde::from_slice(bytes).map_err(|cause| WireError::Read { length: bytes.len(), cause })
}

#[cfg(test)]
mod tests {
    use super::*;
    use endcomfort_core::cloud::{PixelGrid, PointCloud};
    use endcomfort_core::job::{
        DroppedCloud, MapMethod, MapRequest, Output, Refusal, Request, SceneOutput, SegmentOutput, SetShape, Stage,
        Update,
    };
    use endcomfort_core::scene::{ArmChoice, Obstacle, PlacedObject, Scene, TableTop, Task};
    use endcomfort_core::segment::{Plane, PointFate};
    use endcomfort_core::superquadric::Superquadric;
    use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

    fn pose(x: f64) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::new(x, 0.1, 0.9), UnitQuaternion::from_euler_angles(x, 0.3, -2.0))
    }

    fn scene(task: Task) -> Scene {
        Scene {
            version: 1,
            name: "mustard".into(),
            title: "Alita picks the mustard bottle".into(),
            summary: String::new(),
            robot: "alita".into(),
            arm: ArmChoice::Left,
            posture: "ready".into(),
            joints: Default::default(),
            table: TableTop { center_m: [0.6, 0.0], size_m: [0.8, 1.2], height_m: 0.74, thickness_m: 0.04 },
            objects: vec![PlacedObject { object: "mustard_bottle".into(), X_WO: pose(0.6) }],
            obstacles: vec![Obstacle { name: "box".into(), size_m: Vector3::new(0.2, 0.2, 0.1), X_WB: pose(0.4) }],
            X_WC: pose(-0.2),
            task,
            seed: u64::MAX,
            segment: Default::default(),
            fit: Default::default(),
            grasp: Default::default(),
            rank: Default::default(),
            motion: Default::default(),
            torso: false,
            handover: None,
            hand: None,
        }
    }

    #[test]
    fn requests_of_both_tasks_arrive_as_they_were_sent() {
        for task in [Task::pick(0), Task::place(0, pose(0.7))] {
            let sent = Request {
                revision: 7,
                scene: scene(task),
                robot: None,
                objects: Vec::new(),
                cloud: Some(DroppedCloud { name: "a.pcd".into(), bytes: vec![0, 255, 10] }),
                cluster: Some(2),
                grasp: None,
                shape: Some(SetShape {
                    cluster: 2,
                    superquadric: Superquadric::new(0.04, 0.03, 0.1, 0.2, 1.0, pose(0.6)).unwrap(),
                }),
                first: Stage::Fit,
                last: Stage::Rank,
                compare: Some(1),
                map: Some(MapRequest {
                    arms: vec!["left".into()],
                    torso: true,
                    voxel_m: 0.025,
                    orientations: 272,
                    method: MapMethod::Forward { samples: 4_000_000 },
                }),
            };
            let got: Request = from_bytes(&to_bytes(&sent).unwrap()).unwrap();
            assert_eq!((got.revision, got.scene, got.cloud), (sent.revision, sent.scene, sent.cloud));
            assert_eq!((got.cluster, got.grasp, got.shape), (sent.cluster, sent.grasp, sent.shape));
            assert_eq!((got.first, got.last, got.compare), (sent.first, sent.last, sent.compare));
            assert_eq!(got.map, sent.map);
        }
    }

    #[test]
    fn a_cloud_arrives_to_the_last_bit() {
        let points: Vec<Point3<f64>> = (1..2000).map(|i| Point3::new(1.0 / f64::from(i), -0.1, f64::from(i))).collect();
        let cloud = PointCloud {
            colors: vec![[1, 2, 200]; points.len()],
            grid: Some(PixelGrid { width: 640, height: 480, pixels: (0..1999).collect() }),
            points,
            X_FC: Some(pose(0.5)),
        };
        let sent = Update::Done {
            revision: 3,
            elapsed_ms: 1.5,
            output: Box::new(Output::Scene(SceneOutput { cloud: cloud.clone(), notes: vec!["a note".into()] })),
        };
        let Update::Done { output, .. } = from_bytes(&to_bytes(&sent).unwrap()).unwrap() else { panic!() };
        let Output::Scene(SceneOutput { cloud: got, .. }) = *output else { panic!() };
        assert_eq!(got.points, cloud.points);
        assert_eq!(got.colors, cloud.colors);
        assert_eq!(got.grid.unwrap().pixels, cloud.grid.unwrap().pixels);
        assert_eq!(got.X_FC, cloud.X_FC);
    }

    #[test]
    fn fates_and_refusals_arrive() {
        let fates = vec![PointFate::Table, PointFate::Cluster(3), PointFate::OffTable, PointFate::SmallCluster];
        let sent = Output::Segment(SegmentOutput {
            table: Plane { normal: Vector3::z_axis(), offset_m: 0.74 },
            fates: fates.clone(),
            clusters: vec![vec![Point3::new(0.1, 0.2, 0.3)]],
            target: 0,
        });
        let Output::Segment(got) = from_bytes(&to_bytes(&sent).unwrap()).unwrap() else { panic!() };
        assert_eq!(got.fates, fates);
        let refusal = Refusal::new("no table").with_details(vec!["plane 1: 12 points".into()]);
        let sent = Update::Refused { revision: 9, stage: Stage::Segment, refusal: refusal.clone() };
        let Update::Refused { refusal: got, .. } = from_bytes(&to_bytes(&sent).unwrap()).unwrap() else { panic!() };
        assert_eq!(got, refusal);
    }

    #[test]
    fn a_message_that_is_cut_short_is_an_error() {
        let bytes = to_bytes(&Update::Finished { revision: 4 }).unwrap();
        let error = from_bytes::<Update>(&bytes[..bytes.len() - 1]).unwrap_err();
        assert!(error.to_string().contains(&format!("{} bytes", bytes.len() - 1)), "{error}");
    }
}
