//! Running a request stage by stage.

use std::sync::Arc;

use super::handover::HandoverInput;
use super::legs::TaskInput;
use super::memory::{Memory, text};
use super::{handover, lab, map, perceive, rank};
use crate::grasp::{Grasp, RankBy};
use crate::job::{
    FitOutput, GraspsOutput, Output, RankOutput, Refusal, Request, SceneOutput, SegmentOutput, Stage, Update,
};
use crate::library::Library;
use crate::task::{Partners, Plan, Workcell};
use crate::watch::Watch;

/// Runs requests and remembers what each stage gave last.
pub struct Pipeline {
    library: Arc<Library>,
    scene: Memory<SceneOutput>,
    segment: Memory<SegmentOutput>,
    fit: Memory<FitOutput>,
    /// The fits with the shape that a person set among them.
    shaped: Memory<FitOutput>,
    grasps: Memory<(Workcell, Vec<Grasp>)>,
    rank: Memory<Vec<Grasp>>,
    plan: Memory<(Plan, Option<Partners>)>,
}

impl Pipeline {
    /// A pipeline with an empty memory.
    pub fn new(library: Arc<Library>) -> Self {
        Self {
            library,
            scene: Memory::default(),
            segment: Memory::default(),
            fit: Memory::default(),
            shaped: Memory::default(),
            grasps: Memory::default(),
            rank: Memory::default(),
            plan: Memory::default(),
        }
    }

    /// Runs a request to its last stage and tells `emit` what happens, ending with [`Update::Finished`].
    ///
    /// The answer depends on the request alone. Times are read from the watch's clock.
    pub fn run(&mut self, request: &Request, watch: &Watch<'_>, emit: &mut (dyn FnMut(Update) + Send)) {
        let revision = request.revision;
        request.objects.iter().for_each(|object| self.library.bring(object));
        // Another instance of the program may have sent it: this one makes the robot from its files then.
        if let Some(guest) = request.robot.as_ref().filter(|_| self.library.guest(&request.scene.robot).is_none())
            && let Err(error) = self.library.welcome(guest)
        {
            emit(Update::Refused { revision, stage: request.first, refusal: Refusal::new(error.to_string()) });
            emit(Update::Finished { revision });
            return;
        }
        if let Some(cluster) = request.compare {
            self.compare(request, cluster, *watch, emit);
            emit(Update::Finished { revision });
            return;
        }
        if let Some(wanted) = &request.map {
            map::build(&request.scene, wanted, revision, &self.library, *watch, emit);
            emit(Update::Finished { revision });
            return;
        }
        let mut is_ranked = false;
        for stage in Stage::ALL.into_iter().filter(|stage| (request.first..=request.last).contains(stage)) {
            if watch.should_stop() {
                break;
            }
            emit(Update::Progress { revision, stage, fraction: 0.0, note: stage.title().to_owned() });
            let started = watch.now_ms();
            match self.stage(request, stage, *watch) {
                Ok(output) => {
                    is_ranked |= stage == Stage::Rank;
                    let elapsed_ms = watch.now_ms() - started;
                    emit(Update::Done { revision, elapsed_ms, output: Box::new(output) });
                }
                Err(refusal) => {
                    emit(Update::Refused { revision, stage, refusal });
                    break;
                }
            }
        }
        if is_ranked && request.scene.rank.by != RankBy::Score {
            self.tell_qualities(request, *watch, emit);
        }
        emit(Update::Finished { revision });
    }

    /// What takes too long to wait for before a plan.
    fn tell_qualities(&mut self, request: &Request, watch: Watch<'_>, emit: &mut (dyn FnMut(Update) + Send)) {
        let scene = &request.scene;
        let fits = if request.shape.is_some() { self.shaped.last() } else { self.fit.last() };
        let (Some((cell, _)), Some(grasps), Some(fits)) = (self.grasps.last(), self.rank.last(), fits) else { return };
        let Some(Ok(target)) = fits.fits.get(fits.target) else { return };
        let started = watch.now_ms();
        let qualities = rank::qualities(cell, grasps, target, scene, watch);
        if !watch.should_stop() {
            let elapsed_ms = watch.now_ms() - started;
            let output = Box::new(Output::Quality(qualities));
            emit(Update::Done { revision: request.revision, elapsed_ms, output });
        }
    }

    /// Fits a cluster with each objective, all other settings as they are.
    fn compare(&mut self, request: &Request, cluster: usize, watch: Watch<'_>, emit: &mut (dyn FnMut(Update) + Send)) {
        let revision = request.revision;
        if let Err(refusal) = self.stage(request, Stage::Segment, watch) {
            emit(Update::Refused { revision, stage: Stage::Segment, refusal });
            return;
        }
        let (Some(seen), Some(segments)) = (self.scene.last(), self.segment.last()) else { return };
        lab::compare(&request.scene, seen, segments, cluster, watch, &mut |elapsed_ms, output| {
            emit(Update::Done { revision, elapsed_ms, output: Box::new(Output::Objective(Box::new(output))) });
        });
    }

    /// Robot, obstacles and object of the last request that came as far as grasps.
    pub fn workcell(&self) -> Option<&Workcell> {
        self.grasps.last().map(|(cell, _)| cell)
    }

    /// The workcell in which a phase of the last plan happens: of the arm that moves then, everything else being where it
    /// is then.
    pub fn workcell_during(&self, phase: usize) -> Option<Workcell> {
        let (plan, partners) = self.plan.last()?;
        match partners {
            Some(partners) => Some(partners.during(plan, phase)),
            None => self.workcell().cloned(),
        }
    }

    /// The output of one stage; earlier stages are in memory already or are computed now.
    fn stage(&mut self, request: &Request, stage: Stage, watch: Watch<'_>) -> Result<Output, Refusal> {
        let (scene, dropped) = (&request.scene, request.cloud.as_ref());
        let library = &self.library;

        let mut inputs = vec![
            text(&(&scene.table, &scene.objects, &scene.obstacles, &scene.X_WC, scene.seed)),
            // A file is known by its name, length and content.
            dropped.map_or_else(String::new, |file| {
                format!("{} {} {:x}", file.name, file.bytes.len(), digest(&file.bytes))
            }),
        ];
        if dropped.is_some() {
            inputs.push(text(&scene.segment));
        }
        let seen = self.scene.get(inputs.clone(), || perceive::scene_output(scene, dropped, library, watch))?;
        if stage == Stage::Scene {
            return Ok(Output::Scene(seen.clone()));
        }

        inputs.push(text(&(&scene.segment, request.cluster, scene.task.object)));
        let segments = self
            .segment
            .get(inputs.clone(), || perceive::segment_output(scene, seen, dropped.is_some(), request.cluster, watch))?;
        if stage == Stage::Segment {
            return Ok(Output::Segment(segments.clone()));
        }

        inputs.push(text(&scene.fit));
        let mut fits = self.fit.get(inputs.clone(), || perceive::fit_output(scene, seen, segments, watch))?;
        if let Some(shape) = &request.shape {
            inputs.push(text(shape));
            fits = self.shaped.get(inputs.clone(), || lab::with_shape(fits, segments, shape))?;
        }
        if stage == Stage::Fit {
            return Ok(Output::Fit(fits.clone()));
        }

        // From here on the scene is the acting arm's.
        let acting = handover::acting(scene, library)?;
        let scene = acting.as_ref();
        inputs.push(text(&(
            &scene.robot,
            scene.arm,
            &scene.handover,
            scene.torso,
            &scene.hand,
            &scene.posture,
            &scene.joints,
            &scene.task,
            &scene.grasp,
        )));
        let (cell, grasps) = self.grasps.get(inputs.clone(), || {
            let cell = rank::workcell(scene, fits, &segments.clusters, dropped.is_some(), library)?;
            let Some(Ok(target)) = fits.fits.get(fits.target) else {
                return Err(rank::no_fit());
            };
            let points = &segments.clusters[fits.target];
            let touched = rank::touched(scene, target, points, dropped.is_some(), library)?;
            let grasps = rank::grasp_candidates(&cell, target, touched, &scene.grasp)?;
            Ok((cell, grasps))
        })?;
        if stage == Stage::Grasps {
            return Ok(Output::Grasps(GraspsOutput {
                arm: cell.arm().name.clone(),
                grasps: grasps.clone(),
                X_WO_start: cell.X_WO_start,
                X_WO_goal: rank::X_WO_goal(scene, fits, dropped.is_some()),
            }));
        }

        inputs.push(text(&(&scene.rank, scene.motion.straight_ways())));
        let ranked = self.rank.get(inputs.clone(), || {
            let Some(Ok(target)) = fits.fits.get(fits.target) else { return Err(rank::no_fit()) };
            rank::ranked(cell, grasps, target, scene, watch)
        })?;
        let accepted = ranked.iter().filter(|grasp| grasp.is_accepted()).count();
        if stage == Stage::Rank {
            return Ok(Output::Rank(RankOutput { grasps: ranked.clone(), accepted }));
        }

        inputs.push(text(&(&scene.motion, request.grasp)));
        let (plan, _) = self.plan.get(inputs, || {
            let Some(Ok(target)) = fits.fits.get(fits.target) else { return Err(rank::no_fit()) };
            let points = &segments.clusters[fits.target];
            let touched = || rank::touched(scene, target, points, dropped.is_some(), library);
            if let Some(handover) = &scene.handover {
                let wanted = |grasp: &&Grasp| request.grasp.is_none_or(|id| grasp.id == id);
                let grasps: Vec<Grasp> = grasps.iter().filter(wanted).cloned().collect();
                let is_dropped = dropped.is_some();
                let (giver, grasps, touched) = (cell, grasps.as_slice(), &touched);
                let input = HandoverInput { giver, grasps, target, touched, scene, handover, library, is_dropped };
                return input.plan(watch).map(|(plan, partners)| (plan, Some(partners)));
            }
            TaskInput { cell, ranked, chosen: request.grasp, target, touched: &touched, scene, watch }
                .plan()
                .map(|plan| (plan, None))
        })?;
        Ok(Output::Plan(Box::new(plan.clone())))
    }
}

/// FNV-1a: tells two files of one name and length apart.
fn digest(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
