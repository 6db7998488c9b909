//! Which robot acts: one of the program's own, or one that is brought as URDF, folder or archive.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use endcomfort_core::guest::{ArmWish, GuestRobot, Proposal, READY, Wishes};
use endcomfort_core::mesh_file::MeshUnit;
use endcomfort_core::robot::Placement;
use endcomfort_core::scene::{Scene, TableTop};

use super::{Failure, input};
use crate::{assets, brought};

#[derive(clap::Args, Clone)]
pub(super) struct RobotOptions {
    /// Robot, instead of the scene's own: crichton, alita, or yours as a URDF, a folder, a .zip or a .robot.json.
    #[arg(long)]
    pub(super) robot: Option<String>,
    #[command(flatten)]
    pub(super) arms: ArmOptions,
    /// Unit of a mesh file (.obj, .stl, .glb) in place of a scene; default: guessed from its size.
    #[arg(long, value_enum)]
    pub(super) unit: Option<UnitName>,
}

/// The unit of a mesh file.
#[derive(Clone, Copy, clap::ValueEnum)]
pub(super) enum UnitName {
    M,
    Cm,
    Mm,
}

impl From<UnitName> for MeshUnit {
    fn from(name: UnitName) -> Self {
        match name {
            UnitName::M => Self::Metres,
            UnitName::Cm => Self::Centimetres,
            UnitName::Mm => Self::Millimetres,
        }
    }
}

/// What is not said in the files of a robot of one's own.
#[derive(clap::Args, Clone, Default)]
pub(super) struct ArmOptions {
    /// Link that carries the first joint of an arm; once for each arm. Default: found, or the root.
    #[arg(long, value_name = "LINK", help_heading = "A robot of your own")]
    arm_base: Vec<String>,
    /// Link at the end of an arm; once for each arm. Default: found.
    #[arg(long, value_name = "LINK", help_heading = "A robot of your own")]
    arm_tip: Vec<String>,
    /// Frame in that link, z out of the arm, x along the closing direction: x,y,z in metres, roll,pitch,yaw in degrees.
    /// It is the hand frame of the arm's own fingers, or where the hand is mounted.
    #[arg(
        long,
        value_name = "X,Y,Z,R,P,Y",
        value_parser = input::numbers::<6>,
        allow_hyphen_values = true,
        requires = "arm_tip",
        help_heading = "A robot of your own"
    )]
    tcp: Vec<[f64; 6]>,
    /// Hand description (.json) for arms without fingers [default: a parallel gripper].
    #[arg(long, value_name = "FILE", help_heading = "A robot of your own")]
    arm_hand: Option<PathBuf>,
    /// Where its root stands in the world: x,y,z in metres, yaw in degrees. Default: behind the table.
    #[arg(
        long,
        value_name = "X,Y,Z,YAW",
        value_parser = input::numbers::<4>,
        allow_hyphen_values = true,
        help_heading = "A robot of your own"
    )]
    stand: Option<[f64; 4]>,
    /// Writes what was chosen into NAME.robot.json beside the robot, where it is found again.
    #[arg(long, help_heading = "A robot of your own")]
    remember: bool,
}

impl RobotOptions {
    /// Gives a scene the robot that is asked for.
    pub(super) fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let Some(name) = &self.robot else { return self.arms.refuse_alone() };
        if assets::ROBOT_NAMES.contains(&name.as_str()) {
            scene.robot.clone_from(name);
            return self.arms.refuse_alone();
        }
        let path = Path::new(name);
        if !brought::disk::is_robot(path) {
            let known = assets::ROBOT_NAMES.join(" and ");
            return Err(Failure::new(format!(
                "no robot {name:?}; there are {known}, or yours: a .urdf, a .zip, a folder or a .robot.json"
            )));
        }
        let guest = self.arms.guest(path, &scene.table)?;
        hand_over(scene, &guest)
    }
}

/// Lets a robot that was brought act in a scene.
pub(super) fn hand_over(scene: &mut Scene, guest: &GuestRobot) -> Result<(), Failure> {
    let library = assets::library();
    let failed = |error: endcomfort_core::library::LibraryError| Failure::new(error.to_string());
    scene.robot = library.welcome(&Arc::new(guest.clone())).map_err(failed)?;
    if let Some(guest) = library.guest(&scene.robot) {
        guest.notes.iter().for_each(|note| eprintln!("{note}"));
    }
    let robot = library.robot(&scene.robot).map_err(failed)?;
    READY.clone_into(&mut scene.posture);
    scene.torso = false;
    if robot.arm(scene.arm.name()).is_none() {
        scene.arm = scene.arm.other();
    }
    Ok(())
}

impl ArmOptions {
    /// Options without a robot that they could be about.
    pub(super) fn refuse_alone(&self) -> Result<(), Failure> {
        let is_said = self.stand.is_some() || !self.arm_tip.is_empty() || !self.arm_base.is_empty() || self.remember;
        if is_said || self.arm_hand.is_some() {
            return Err(Failure::new(
                "--arm-base, --arm-tip, --tcp, --arm-hand, --stand and --remember are about a robot of your own: give it \
                 with --robot FILE.urdf",
            ));
        }
        Ok(())
    }

    /// The robot of a path, with what is asked for and what was found.
    pub(super) fn guest(&self, path: &Path, table: &TableTop) -> Result<GuestRobot, Failure> {
        let shown = path.display();
        let Proposal { guest, notes, problem } = self.proposal(path, table)?;
        notes.iter().for_each(|note| eprintln!("{note}"));
        if let Some(problem) = problem {
            return Err(Failure::new(format!("{shown}: {problem}: --arm-base LINK --arm-tip LINK")).with_details(notes));
        }
        if self.remember {
            let file = beside(path, &guest);
            let text = serde_json::to_string_pretty(&guest.description)
                .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
            std::fs::write(&file, text).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
            eprintln!("wrote {}", file.display());
        }
        Ok(guest)
    }

    /// As [`ArmOptions::guest`], also when no arm was found.
    pub(super) fn proposal(&self, path: &Path, table: &TableTop) -> Result<Proposal, Failure> {
        let files = brought::disk::robot_files(path).map_err(Failure::new)?;
        let hand = self.arm_hand.as_deref().map(input::hand).transpose()?;
        brought::proposed(&files, &self.wishes()?, table, hand.as_ref())
            .map_err(|error| Failure::new(format!("{}: {error}", path.display())))
    }

    fn wishes(&self) -> Result<Wishes, Failure> {
        if self.arm_base.len() > self.arm_tip.len() || self.tcp.len() > self.arm_tip.len() || self.arm_tip.len() > 2 {
            let (bases, tips, tcps) = (self.arm_base.len(), self.arm_tip.len(), self.tcp.len());
            return Err(Failure::new(format!(
                "found {bases} times --arm-base, {tips} times --arm-tip and {tcps} times --tcp, wanted --arm-tip once \
                 for each of one or two arms, the others at most as often"
            )));
        }
        let wish = |(index, tip): (usize, &String)| ArmWish {
            base_link: self.arm_base.get(index).cloned(),
            tip_link: tip.clone(),
            tcp: self.tcp.get(index).map(placement),
        };
        let stand = self.stand.map(|[x, y, z, yaw_deg]| placement(&[x, y, z, 0.0, 0.0, yaw_deg]));
        Ok(Wishes { arms: self.arm_tip.iter().enumerate().map(wish).collect(), stand })
    }
}

/// Metres and degrees as a pose.
fn placement(&[x, y, z, roll, pitch, yaw]: &[f64; 6]) -> Placement {
    Placement { xyz: [x, y, z], rpy: [roll, pitch, yaw].map(f64::to_radians) }
}

/// The file in which the choice is kept: beside a URDF, in a folder, beside an archive.
fn beside(path: &Path, guest: &GuestRobot) -> PathBuf {
    let name = format!("{}.robot.json", guest.title());
    if path.is_dir() { path.join(name) } else { path.with_file_name(name) }
}
