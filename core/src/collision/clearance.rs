//! A checker that keeps things apart by more than contact.

use super::build::squared_distance_to_box;
use super::checker::{Checker, Scratch};
use super::frames::Rigid;
use super::narrow::signed_distance;
use super::sieve::Sieve;
use super::solid::Solid;

/// How far two ways of asking GJK for one distance may differ, metres: it stalls this near to the answer.
const SLACK_M: f64 = 2e-5;

impl Checker {
    /// A checker that calls a configuration free only if everything that its joints move stays farther than
    /// `clearance_m` from everything else.
    ///
    /// A pair that is nearer than that at one of the configurations `near` must only stay as far apart as there, to
    /// 0.12 mm, and never less than `least_m`: a hand that starts beside a table may leave it. Intended contacts keep
    /// their own rule, and pairs that no joint moves are not asked for more than before.
    ///
    /// Moving bodies are grown by the clearance, so that every question takes as long as before and proofs along a
    /// motion hold for the clearance. Its distances are those of the grown bodies.
    pub(crate) fn keeping_clear(&self, clearance_m: f64, least_m: f64, near: &[&[f64]]) -> Self {
        let grown = clearance_m.max(0.0);
        let mut kept = self.clone();
        for cluster in &mut kept.clusters {
            // Things out of the arm's reach may be within the clearance of it.
            cluster.against.append(&mut cluster.out_of_reach);
        }
        // What each pair keeps: the clearance, or its least distance at the configurations.
        let wanted = grown + self.margin_m + SLACK_M;
        let mut from_fixed: Vec<Vec<f64>> = kept.clusters.iter().map(|c| vec![wanted; c.against.len()]).collect();
        let mut from_moving = vec![wanted; kept.pairs.len()];
        let mut scratch = Scratch::default();
        for q in near.iter().filter(|q| self.is_configuration(q)) {
            kept.place(&mut scratch, q);
            for (index, distances) in from_fixed.iter_mut().enumerate() {
                for (which, distance) in distances.iter_mut().enumerate() {
                    *distance = kept.fixed_distance(&scratch, index, which, *distance);
                }
            }
            for (index, distance) in from_moving.iter_mut().enumerate() {
                *distance = kept.moving_distance(&scratch, index, *distance);
            }
        }
        // Free means farther apart than the margin.
        let kept_m = |distance: f64| (distance - self.margin_m - SLACK_M).max(least_m).max(0.0).min(grown);
        for (cluster, distances) in kept.clusters.iter_mut().zip(&from_fixed) {
            for ((_, depth_m), distance) in cluster.against.iter_mut().zip(distances) {
                *depth_m += if *depth_m > 0.0 { grown } else { grown - kept_m(*distance) };
            }
            cluster.bound += grown;
            cluster.solids.iter_mut().for_each(|solid| grow(solid, grown));
        }
        for (pair, distance) in kept.pairs.iter_mut().zip(&from_moving) {
            // Both of them have grown.
            pair.depth_m += if pair.depth_m > 0.0 { 2.0 * grown } else { 2.0 * grown - kept_m(*distance) };
        }
        // The sieve knows the grown bodies but no allowed depth: what is allowed to be near it leaves to the exact checker.
        kept.sieve = Sieve::new(&kept);
        kept
    }

    /// The smallest distance of anything the joints move to anything else, metres, up to `most_m`; intended contacts
    /// are left out. Minus infinity where `q` is no configuration.
    pub(crate) fn room_m(&self, scratch: &mut Scratch, q: &[f64], most_m: f64) -> f64 {
        if !self.is_configuration(q) {
            return f64::NEG_INFINITY;
        }
        self.place(scratch, q);
        let mut room_m = most_m;
        for (index, cluster) in self.clusters.iter().enumerate() {
            for (which, _) in cluster.against.iter().enumerate().filter(|(_, (_, depth_m))| *depth_m == 0.0) {
                room_m = self.fixed_distance(scratch, index, which, room_m);
            }
        }
        for (index, _) in self.pairs.iter().enumerate().filter(|(_, pair)| pair.depth_m == 0.0) {
            room_m = self.moving_distance(scratch, index, room_m);
        }
        room_m
    }

    /// Distance of a cluster to one of the things it may meet that stand still, or `most_m` if that is less.
    fn fixed_distance(&self, scratch: &Scratch, cluster: usize, which: usize, most_m: f64) -> f64 {
        let center = scratch.centers[cluster];
        let cluster = &self.clusters[cluster];
        let fixed = &self.fixed[cluster.against[which].0];
        let reach = cluster.bound + most_m;
        if reach <= 0.0 || squared_distance_to_box(&center, &fixed.lower, &fixed.upper) > reach * reach {
            return most_m;
        }
        let X_WF = &scratch.X_WF[cluster.frame];
        let distance = |solid| signed_distance(solid, X_WF, &fixed.solid, &Rigid::identity());
        cluster.solids.iter().map(distance).fold(most_m, f64::min)
    }

    /// Distance of two clusters that move relative to each other, or `most_m` if that is less.
    fn moving_distance(&self, scratch: &Scratch, pair: usize, most_m: f64) -> f64 {
        let pair = &self.pairs[pair];
        let (a, b) = (&self.clusters[pair.a], &self.clusters[pair.b]);
        if (scratch.centers[pair.a] - scratch.centers[pair.b]).norm() - a.bound - b.bound > most_m {
            return most_m;
        }
        let (X_WA, X_WB) = (&scratch.X_WF[a.frame], &scratch.X_WF[b.frame]);
        let pairs = a.solids.iter().flat_map(|a| b.solids.iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| signed_distance(a, X_WA, b, X_WB)).fold(most_m, f64::min)
    }
}

fn grow(solid: &mut Solid, by_m: f64) {
    solid.radius += by_m;
    solid.bound += by_m;
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;
    use crate::collision::testing::{random_q, two_arm_robot};
    use crate::collision::{CarriedObject, CollisionModel, ConvexHull, Exhaustive, MayTouch, World};
    use crate::rng::Rng;

    fn scene() -> World {
        let mut world = World::new();
        world.add_box("table", Vector3::new(0.75, 1.5, 0.04), &Isometry3::translation(0.6, 0.0, 0.67)).unwrap();
        world.add_cylinder("can", 0.05, 0.2, &Isometry3::translation(0.5, 0.4, 0.8)).unwrap();
        world
    }

    #[test]
    fn free_with_a_clearance_is_what_the_judge_measures() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let world = scene();
        let judge = Exhaustive::new(&model, &world, None, &[]).unwrap();
        let rest = vec![0.0; 18];
        let checker = Checker::for_arm(&model, &world, None, &[], 0, &rest).unwrap();
        let mut rng = Rng::new(5, 0);
        let mut scratch = Scratch::default();
        let arm = &robot.arms[0].dofs;
        let (mut free, mut near) = (0, 0);
        for clearance_m in [0.0, 0.01, 0.05, 0.2] {
            let kept = checker.keeping_clear(clearance_m, 0.0, &[]);
            for _ in 0..400 {
                let drawn = random_q(&robot, &mut rng);
                let q: Vec<f64> = arm.iter().map(|&dof| drawn[dof]).collect();
                let room = checker.room_m(&mut scratch, &q, 1.0);
                let mut full = rest.clone();
                arm.iter().zip(&q).for_each(|(&dof, value)| full[dof] = *value);
                let judged = judge.distance_m(&full);
                // The judge also looks at what stands still; where that is not the nearest, both measure the same.
                assert!(judged <= room + 5e-5 || room <= 0.0, "ours {room}, the judge {judged}");
                if (room - clearance_m - 1e-4).abs() > 1e-4 {
                    let is_free = kept.is_free(&mut scratch, &q);
                    assert_eq!(is_free, room > clearance_m, "room {room}, clearance {clearance_m}");
                    *(if is_free { &mut free } else { &mut near }) += 1;
                }
            }
        }
        assert!(free > 100 && near > 100, "{free} free, {near} near");
    }

    #[test]
    fn what_is_nearer_at_the_ends_may_be_so_again_and_other_things_may_not() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let q = vec![0.0; 18];
        let X_WT = robot.link_poses(&q)[robot.arms[0].hand.tcp_link];
        // At q = 0 the left arm points along +y; its fingers end 0.02 m beyond the hand frame.
        let wall = |name: &str, gap_m: f64, world: &mut World| {
            let at = X_WT.translation.y + 0.02 + gap_m + 0.5;
            let center = Isometry3::translation(X_WT.translation.x, at, X_WT.translation.z);
            world.add_box(name, Vector3::new(2.0, 1.0, 2.0), &center).unwrap();
        };
        let free = |gaps: &[(&str, f64)], near: &[&[f64]]| {
            let mut world = World::new();
            gaps.iter().for_each(|(name, gap_m)| wall(name, *gap_m, &mut world));
            let checker = Checker::for_arm(&model, &world, None, &[], 0, &q).unwrap();
            let kept = checker.keeping_clear(0.02, 0.0, near);
            kept.first_hit(&mut Scratch::default(), &[0.0; 7]).map(|hit| hit.b)
        };
        let (here, away) = ([0.0; 7], [0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0]);
        assert_eq!(free(&[("wall", 0.021)], &[]), None);
        assert_eq!(free(&[("wall", 0.005)], &[]).as_deref(), Some("wall"));
        assert_eq!(free(&[("wall", 0.005)], &[&here]), None);
        assert_eq!(free(&[("wall", 0.005)], &[&away]).as_deref(), Some("wall"));
    }

    #[test]
    fn an_intended_contact_is_asked_for_no_more_with_a_clearance() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let q = vec![0.0; 18];
        let corners: Vec<_> = (0..8)
            .map(|k| Point3::new(f64::from(k & 1) - 0.5, f64::from(k >> 1 & 1) - 0.5, f64::from(k >> 2) - 0.5) * 0.1)
            .collect();
        let brick = [ConvexHull::new("brick", &corners).unwrap()];
        let carried = CarriedObject::new("brick", &brick, &Isometry3::translation(0.0, 0.0, 0.05), &robot, 0).unwrap();
        let X_WT = robot.link_poses(&q)[robot.arms[0].hand.tcp_link];
        let end = X_WT.translation.y + 0.1;
        for (sunk_m, may, free) in
            [(-0.001, true, true), (0.003, true, true), (0.009, true, false), (-0.03, false, true)]
        {
            let mut world = World::new();
            let center = Isometry3::translation(X_WT.translation.x, end - sunk_m + 0.5, X_WT.translation.z);
            world.add_box("table", Vector3::new(0.12, 1.0, 0.12), &center).unwrap();
            let may = if may { vec![MayTouch::carried("table", 0.005)] } else { Vec::new() };
            let checker = Checker::for_arm(&model, &world, Some(&carried), &may, 0, &q).unwrap();
            let kept = checker.keeping_clear(0.02, 0.0, &[]);
            let hit = kept.first_hit(&mut Scratch::default(), &[0.0; 7]);
            assert_eq!(hit.is_none(), free, "sunk by {sunk_m}: {hit:?}");
        }
    }
}
