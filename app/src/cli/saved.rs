//! What tables and plots are made of: the pipeline's results on a demo, a scene or a cloud.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use endcomfort_core::job::{FitOutput, ObjectiveFit, Output, Refusal, SegmentOutput, Stage};
use endcomfort_core::reach::ReachMap;
use endcomfort_core::robot::Robot;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::{Plan, Try};

use super::depth_options::DepthOptions;
use super::{Common, Failure, input, robot_options};
use crate::export::Results;
use crate::{assets, jobs};

/// Which scene.
#[derive(clap::Args)]
pub(super) struct Of {
    /// A demo, a scene file, a cloud file, a depth image (16-bit PNG) or a mesh (.obj, .stl, .glb).
    scene: String,
    #[command(flatten)]
    robot: robot_options::RobotOptions,
    #[command(flatten)]
    depth: DepthOptions,
}

/// Everything that was found.
pub(super) struct Found {
    pub(super) scene: Scene,
    robot: Arc<Robot>,
    outputs: Vec<Output>,
    objectives: Vec<(f64, ObjectiveFit)>,
    refusal: Option<Refusal>,
    maps: [Option<ReachMap>; 2],
}

impl Of {
    /// Runs the pipeline as far as a stage, or as far as it goes.
    ///
    /// * `compares`: fits the target with every objective as well.
    pub(super) fn find(&self, stage: Stage, compares: bool, common: &Common) -> Result<Found, Failure> {
        let mut request = input::request(&self.scene, &self.robot, &self.depth, common)?;
        let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
        let (outputs, refusal) = jobs::run_as_far_as_possible(&request, stage);
        if let Some(refusal) = &refusal {
            eprintln!("{}", Failure::from(refusal.clone()));
        }
        let mut objectives = Vec::new();
        if compares {
            let fit = outputs.iter().find_map(|output| if let Output::Fit(fit) = output { Some(fit) } else { None });
            request.compare = Some(fit.ok_or_else(|| Failure::new("there is no fit"))?.target);
            objectives = jobs::compare(&request)?;
        }
        Ok(Found { scene: request.scene, robot, outputs, objectives, refusal, maps: [None, None] })
    }

    /// The stored reachability maps of the scene's robot.
    pub(super) fn maps(&self, common: &Common) -> Result<Found, Failure> {
        let request = input::request(&self.scene, &self.robot, &self.depth, common)?;
        let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
        let map = |arm: &str| {
            let map = assets::library().reach_map(&request.scene.robot, arm);
            map.map_err(|error| Failure::new(error.to_string()))
        };
        let maps = [Some(map("left")?), Some(map("right")?)];
        Ok(Found { scene: request.scene, robot, outputs: Vec::new(), objectives: Vec::new(), refusal: None, maps })
    }
}

impl Found {
    /// As tables and plots take it.
    pub(super) fn results(&self) -> Results<'_> {
        let mut results = Results {
            robot: &self.robot,
            segment: None::<&SegmentOutput>,
            fit: None::<&FitOutput>,
            objectives: &self.objectives,
            plan: None::<&Plan>,
            tries: &[] as &[Try],
            maps: self.maps.each_ref().map(Option::as_ref),
        };
        for output in &self.outputs {
            match output {
                Output::Segment(segment) => results.segment = Some(segment),
                Output::Fit(fit) => results.fit = Some(fit),
                Output::Plan(plan) => (results.plan, results.tries) = (Some(&**plan), &plan.tries),
                _ => {}
            }
        }
        if let Some(refusal) = &self.refusal {
            results.tries = &refusal.tries;
        }
        results
    }
}

/// Writes the text to the file, or to standard output without one.
pub(super) fn write(text: &str, file: Option<&PathBuf>) -> Result<(), Failure> {
    let Some(file) = file else {
        print!("{text}");
        return Ok(());
    };
    let shown = Path::new(file).display();
    std::fs::write(file, text).map_err(|error| Failure::new(format!("{shown}: {error}")))?;
    eprintln!("wrote {shown} ({} bytes)", text.len());
    Ok(())
}
