//! A robot that somebody brought, whole: its files, and what was chosen for it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::files::file_name;
use super::{Blob, RobotDescription};
use crate::robot::Resolve;

/// Name of the posture from which such a robot starts.
pub const READY: &str = "ready";

/// A robot's files, its meshes by the names that the URDF gives them, and its description.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GuestRobot {
    /// What the URDF does not say.
    pub description: RobotDescription,
    /// Text of the URDF.
    pub urdf: String,
    /// Text of the SRDF, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub srdf: Option<String>,
    /// Mesh files; empty where a format is not read.
    pub meshes: BTreeMap<String, Blob>,
}

impl GuestRobot {
    /// Name in scenes: that of the URDF, and a fingerprint of everything about the robot, as in `arm@0f3c52a1`.
    pub fn name(&self) -> String {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |bytes: &[u8]| {
            // FNV-1a; the length keeps neighbours apart.
            for &byte in (bytes.len() as u64).to_le_bytes().iter().chain(bytes) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
            }
        };
        // A description always has text: its keys are texts and its numbers finite.
        add(&serde_json::to_vec(&self.description).unwrap_or_default());
        add(self.urdf.as_bytes());
        add(self.srdf.as_deref().unwrap_or_default().as_bytes());
        for (file, Blob(bytes)) in &self.meshes {
            add(file.as_bytes());
            add(bytes);
        }
        format!("{}@{:08x}", self.title(), (hash ^ (hash >> 32)) as u32)
    }

    /// What a person calls it: the name of its URDF without the ending.
    pub fn title(&self) -> &str {
        let file = file_name(&self.description.urdf);
        file.rsplit_once('.').map_or(file, |(stem, _)| stem)
    }

    /// The part of a scene's robot name that a person reads; the whole name for a robot of the program's own.
    pub fn title_of(name: &str) -> &str {
        name.rsplit_once('@').map_or(name, |(title, _)| title)
    }

    /// Content of a mesh: the robot's own, or for the hand that it was given one that travels inside the program.
    pub(super) fn mesh(&self, uri: &str, own: &Resolve<'_>) -> Option<Vec<u8>> {
        match self.meshes.get(uri) {
            Some(Blob(bytes)) => Some(bytes.clone()),
            None => uri.starts_with("package://endcomfort/").then(|| own(uri)).flatten(),
        }
    }
}
