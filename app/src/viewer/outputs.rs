//! The results of the stages, each with the revision it was computed from.

use std::ops::Deref;
use std::sync::Arc;

use endcomfort_core::grasp::{Grasp, Quality};
use endcomfort_core::job::{FitOutput, GraspsOutput, Output, RankOutput, SceneOutput, SegmentOutput, Stage};
use endcomfort_core::scene::Scene;
use endcomfort_core::task::Plan;
use nalgebra::Isometry3;

/// A result and the revision of the document that it belongs to.
#[derive(Debug)]
pub struct Dated<T> {
    /// Revision of the document.
    pub revision: u64,
    /// The result, shared with whoever draws it.
    pub value: Arc<T>,
}

impl<T> Clone for Dated<T> {
    fn clone(&self) -> Self {
        Self { revision: self.revision, value: self.value.clone() }
    }
}

impl<T> Deref for Dated<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// What the stages have given so far; an older result stays until a newer one stands.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The cloud.
    pub scene: Option<Dated<SceneOutput>>,
    /// Table and clusters.
    pub segment: Option<Dated<SegmentOutput>>,
    /// Superquadrics.
    pub fit: Option<Dated<FitOutput>>,
    /// Candidates before the arm is asked.
    pub grasps: Option<Dated<GraspsOutput>>,
    /// Candidates, ranked.
    pub rank: Option<Dated<RankOutput>>,
    /// The plan.
    pub plan: Option<Dated<Plan>>,
    /// Whether the ranking is one of the present candidates.
    ranks_these: bool,
}

impl Outputs {
    /// Name of the arm that grasps: as it was found, or as the scene has it.
    pub fn arm_name<'a>(&'a self, scene: &'a Scene) -> &'a str {
        self.grasps.as_ref().map_or(scene.arm.name(), |grasps| &grasps.arm)
    }

    /// Puts a result in its place and says which stage it was, if it was one.
    pub(super) fn put(&mut self, revision: u64, output: Output) -> Option<Stage> {
        fn dated<T>(revision: u64, value: T) -> Option<Dated<T>> {
            Some(Dated { revision, value: Arc::new(value) })
        }
        Some(match output {
            Output::Scene(value) => {
                self.scene = dated(revision, value);
                Stage::Scene
            }
            Output::Segment(value) => {
                self.segment = dated(revision, value);
                Stage::Segment
            }
            Output::Fit(value) => {
                self.fit = dated(revision, value);
                Stage::Fit
            }
            Output::Grasps(value) => {
                self.grasps = dated(revision, value);
                self.ranks_these = false;
                Stage::Grasps
            }
            Output::Rank(value) => {
                self.rank = dated(revision, value);
                self.ranks_these = true;
                Stage::Rank
            }
            Output::Plan(value) => {
                self.plan = dated(revision, *value);
                Stage::Plan
            }
            Output::Quality(qualities) => {
                if let Some(rank) = self.rank.as_mut().filter(|rank| rank.revision == revision) {
                    Quality::put_all(&qualities, &mut Arc::make_mut(&mut rank.value).grasps);
                }
                return None;
            }
            // The lab and the maps take them before anybody puts them here.
            Output::Objective(_) | Output::Map(_) => return None,
        })
    }

    /// The results of the stages before `reach` belong to a newer revision too, as far as they are complete. Gives the
    /// first stage whose result does not.
    pub(super) fn keep_before(&mut self, reach: Stage, old: u64, new: u64) -> Stage {
        let is_kept = |stage: &Stage| *stage < reach && self.revision(*stage) == Some(old);
        let kept: Vec<Stage> = Stage::ALL.into_iter().take_while(is_kept).collect();
        for &stage in &kept {
            if let Some(revision) = self.revision_mut(stage) {
                *revision = new;
            }
        }
        // No stage lies before itself, so at least the plan is not kept.
        Stage::ALL.get(kept.len()).copied().unwrap_or(Stage::Plan)
    }

    fn revision_mut(&mut self, stage: Stage) -> Option<&mut u64> {
        match stage {
            Stage::Scene => self.scene.as_mut().map(|dated| &mut dated.revision),
            Stage::Segment => self.segment.as_mut().map(|dated| &mut dated.revision),
            Stage::Fit => self.fit.as_mut().map(|dated| &mut dated.revision),
            Stage::Grasps => self.grasps.as_mut().map(|dated| &mut dated.revision),
            Stage::Rank => self.rank.as_mut().map(|dated| &mut dated.revision),
            Stage::Plan => self.plan.as_mut().map(|dated| &mut dated.revision),
        }
    }

    /// Drops the results of a stage and of all that follow from it.
    pub(super) fn drop_from(&mut self, stage: Stage) {
        for later in Stage::ALL.into_iter().filter(|&later| later >= stage) {
            match later {
                Stage::Scene => self.scene = None,
                Stage::Segment => self.segment = None,
                Stage::Fit => self.fit = None,
                Stage::Grasps => self.grasps = None,
                Stage::Rank => self.rank = None,
                Stage::Plan => self.plan = None,
            }
        }
    }

    /// Revision of a stage's result, if there is one.
    pub fn revision(&self, stage: Stage) -> Option<u64> {
        match stage {
            Stage::Scene => self.scene.as_ref().map(|dated| dated.revision),
            Stage::Segment => self.segment.as_ref().map(|dated| dated.revision),
            Stage::Fit => self.fit.as_ref().map(|dated| dated.revision),
            Stage::Grasps => self.grasps.as_ref().map(|dated| dated.revision),
            Stage::Rank => self.rank.as_ref().map(|dated| dated.revision),
            Stage::Plan => self.plan.as_ref().map(|dated| dated.revision),
        }
    }

    /// The candidates as far as they are known: ranked if the ranking is theirs, else as they were made.
    pub fn candidates(&self) -> &[Grasp] {
        match (&self.rank, &self.grasps) {
            (Some(rank), _) if self.ranks_these => &rank.grasps,
            (_, Some(grasps)) => &grasps.grasps,
            (_, None) => &[],
        }
    }

    /// Whether the candidates are ranked.
    pub fn is_ranked(&self) -> bool {
        self.ranks_these && self.rank.is_some()
    }

    /// Whether accepted grasps still wait for what is told after the plan.
    pub(super) fn lacks_qualities(&self) -> bool {
        let mut accepted = self.rank.iter().flat_map(|rank| &rank.grasps).filter(|grasp| grasp.is_accepted());
        accepted.any(|grasp| grasp.volume.is_none())
    }

    /// The candidate of this number.
    pub fn candidate(&self, id: u32) -> Option<&Grasp> {
        self.candidates().iter().find(|grasp| grasp.id == id)
    }

    /// Position among the accepted ones from 1, when the ranking knows the grasp as accepted.
    pub fn rank_of(&self, id: u32) -> Option<usize> {
        let rank = self.rank.as_ref().filter(|_| self.ranks_these)?;
        rank.grasps.iter().take(rank.accepted).position(|grasp| grasp.id == id).map(|index| index + 1)
    }

    /// Pose of the object frame O in the world at the start.
    pub fn X_WO_start(&self) -> Option<&Isometry3<f64>> {
        self.grasps.as_ref().map(|grasps| &grasps.value.X_WO_start)
    }
}
