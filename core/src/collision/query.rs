//! The checker's questions: broad phase over bounding balls and boxes, then exact pairs.

use nalgebra::Vector3;

use super::build::squared_distance_to_box;
use super::checker::{Checker, Clearance, Cluster, ConstantPair, Hit, Margins, Owner, Pair, Scratch, State};
use super::frames::Rigid;
use super::narrow::{Proximity, proximity, signed_distance};
use super::solid::Solid;
use super::tree::Node;

impl Checker {
    /// What a configuration is: free of everything by more than the margins, near something, or touching.
    ///
    /// `margins` are metres per moving frame with a factor applied to all; a pair whose distance is at most the
    /// margin of its moving body counts as near. `q` must be a configuration ([`Checker::is_configuration`]).
    pub(crate) fn state(&self, scratch: &mut Scratch, q: &[f64], margins: Margins<'_>) -> State {
        self.place(scratch, q);
        self.state_where_placed(scratch, margins, usize::MAX)
    }

    /// What the bodies of the last moving frame touch that stands still: the hand, what it carries and the flange.
    /// `None` also where something else is hit.
    ///
    /// At one hand pose the answer is the same for every configuration that reaches it: asked once, it saves that part
    /// of [`Checker::first_hit_besides_hand`] for all of them.
    pub fn first_hit_of_hand(&self, scratch: &mut Scratch, q: &[f64]) -> Option<Hit> {
        if !self.is_configuration(q) {
            return self.first_hit(scratch, q);
        }
        self.place(scratch, q);
        let last = self.frames.len() - 1;
        let clusters = self.clusters.iter().enumerate().filter(|(_, cluster)| cluster.frame == last);
        for (index, cluster) in clusters {
            if let (Proximity::Touching, Some(pair)) = self.against_fixed(scratch, index, cluster, self.margin_m) {
                return Some(self.name(pair));
            }
        }
        None
    }

    /// As [`Checker::first_hit`], without what [`Checker::first_hit_of_hand`] looks at.
    pub fn first_hit_besides_hand(&self, scratch: &mut Scratch, q: &[f64]) -> Option<Hit> {
        if !self.is_configuration(q) {
            return self.first_hit(scratch, q);
        }
        self.place(scratch, q);
        match self.state_where_placed(scratch, None, self.frames.len() - 1) {
            State::Hit(pair) => Some(self.name(pair)),
            _ => None,
        }
    }

    /// As [`Checker::state`] for frames that stand in `scratch`; bodies of the frame `left_out` are not compared with
    /// what stands still.
    fn state_where_placed(&self, scratch: &Scratch, margins: Margins<'_>, left_out: usize) -> State {
        if let Some(pair) = self.constant_hit {
            return State::Hit(pair);
        }
        // Once something is near, only touching matters.
        let mut is_near = false;
        let margin_of = |frame: usize| margins.map_or(0.0, |(per_frame, factor)| per_frame[frame] * factor);
        let looked_at = self.clusters.iter().enumerate().filter(|(_, cluster)| cluster.frame != left_out);
        for (index, cluster) in looked_at {
            let margin = if is_near { self.margin_m } else { margin_of(cluster.frame).max(self.margin_m) };
            match self.against_fixed(scratch, index, cluster, margin) {
                (Proximity::Touching, Some(pair)) => return State::Hit(pair),
                (Proximity::Apart, _) => {}
                _ => is_near = true,
            }
        }
        for pair in &self.pairs {
            let (a, b) = (&self.clusters[pair.a], &self.clusters[pair.b]);
            let near_m = if is_near {
                self.margin_m
            } else {
                let relative =
                    if pair.b_hangs_on_a { margin_of(b.frame) } else { margin_of(a.frame) + margin_of(b.frame) };
                relative.max(self.margin_m)
            };
            let reach = a.bound + b.bound + near_m;
            if (scratch.centers[pair.a] - scratch.centers[pair.b]).norm_squared() > reach * reach {
                continue;
            }
            let (X_WA, X_WB) = (&scratch.X_WF[a.frame], &scratch.X_WF[b.frame]);
            match clusters_proximity(a, X_WA, b, X_WB, self.margin_m - pair.depth_m, near_m - pair.depth_m) {
                Proximity::Touching => return State::Hit(Pair { a: a.owner, b: b.owner }),
                Proximity::Near => is_near = true,
                Proximity::Apart => {}
            }
        }
        if is_near { State::Near } else { State::Free }
    }

    /// Compares a cluster with everything that stands still: touching what, or nearer than `margin_m` to something.
    fn against_fixed(
        &self,
        scratch: &Scratch,
        index: usize,
        cluster: &Cluster,
        margin_m: f64,
    ) -> (Proximity, Option<Pair>) {
        let center = &scratch.centers[index];
        let X_WF = &scratch.X_WF[cluster.frame];
        let mut search = Search { closest: Proximity::Apart, hit: None, near_m: margin_m };
        let mut rest = cluster.against.as_slice();
        if let Some(obstacles) = &self.tree {
            let of_tree;
            (of_tree, rest) = rest.split_at(rest.partition_point(|&(fixed, _)| fixed < obstacles.count));
            let is_near = |search: &Search, node: &Node| {
                let reach = cluster.bound + search.near_m;
                squared_distance_to_box(center, &node.lower, &node.upper) <= reach * reach
            };
            obstacles.tree.visit(&mut search, is_near, |search, fixed| {
                if let Ok(at) = of_tree.binary_search_by_key(&fixed, |&(fixed, _)| fixed) {
                    self.against_one(search, cluster, X_WF, of_tree[at]);
                }
                search.hit.is_none()
            });
        }
        for &(fixed, depth_m) in rest {
            let reach = cluster.bound + search.near_m;
            let thing = &self.fixed[fixed];
            if search.hit.is_none() && squared_distance_to_box(center, &thing.lower, &thing.upper) <= reach * reach {
                self.against_one(&mut search, cluster, X_WF, (fixed, depth_m));
            }
        }
        (search.closest, search.hit)
    }

    /// Compares a cluster with one thing that stands still, near enough for its ball.
    fn against_one(&self, search: &mut Search, cluster: &Cluster, X_WF: &Rigid, (fixed, depth_m): (usize, f64)) {
        let fixed = &self.fixed[fixed];
        for solid in &cluster.solids {
            let near_m = search.near_m;
            if cluster.solids.len() > 1 {
                let reach = solid.bound + near_m;
                let center = X_WF.point(&solid.center);
                if squared_distance_to_box(&center, &fixed.lower, &fixed.upper) > reach * reach {
                    continue;
                }
            }
            let world = Rigid::identity();
            match proximity(solid, X_WF, &fixed.solid, &world, self.margin_m - depth_m, near_m - depth_m) {
                Proximity::Touching => {
                    search.closest = Proximity::Touching;
                    search.hit = Some(Pair { a: cluster.owner, b: fixed.owner });
                    return;
                }
                Proximity::Near => {
                    // Once something is near, only touching matters.
                    search.closest = Proximity::Near;
                    search.near_m = self.margin_m;
                }
                Proximity::Apart => {}
            }
        }
    }

    /// All touching pairs at a configuration, each once; as [`Checker::first_hit`] for a `q` that is none.
    pub fn all_hits(&self, scratch: &mut Scratch, q: &[f64]) -> Vec<Hit> {
        if !self.is_configuration(q) {
            return self.first_hit(scratch, q).into_iter().collect();
        }
        let mut hits: Vec<Pair> = Vec::new();
        let mut visit = |a: &Solid, X_WA: &Rigid, b: &Solid, X_WB: &Rigid, depth_m: f64, pair: Pair| {
            let gap = self.margin_m - depth_m;
            if !hits.contains(&pair) && proximity(a, X_WA, b, X_WB, gap, gap) == Proximity::Touching {
                hits.push(pair);
            }
            gap
        };
        self.visit_pairs(scratch, q, f64::INFINITY, &mut visit);
        self.visit_fixed(&mut visit);
        hits.into_iter().map(|pair| self.name(pair)).collect()
    }

    /// The smallest distance at a configuration of anything that the joints move, and between whom it is; intended
    /// contacts are left out.
    ///
    /// For a `q` that is none (see [`Checker::first_hit`]) the distance is minus infinity.
    pub fn distance(&self, scratch: &mut Scratch, q: &[f64]) -> Clearance {
        self.distance_within(scratch, q, f64::INFINITY)
    }

    /// As [`Checker::distance`], faster for who knows that it is not larger than `most_m`, metres; without names if it is.
    ///
    /// From one configuration to another no distance grows by more than twice [`Checker::displacement_m`].
    pub fn distance_within(&self, scratch: &mut Scratch, q: &[f64], most_m: f64) -> Clearance {
        if !self.is_configuration(q) {
            let (a, b) = ("joint positions".to_owned(), "not a configuration".to_owned());
            return Clearance { distance_m: f64::NEG_INFINITY, a, b };
        }
        let mut best = most_m;
        let mut closest = None;
        self.visit_pairs(scratch, q, most_m, &mut |a, X_WA, b, X_WB, depth_m, pair| {
            if depth_m == 0.0 {
                let distance = signed_distance(a, X_WA, b, X_WB);
                if distance < best {
                    best = distance;
                    closest = Some(pair);
                }
            }
            best
        });
        let (a, b) = closest.map(|pair| self.name(pair)).map(|hit| (hit.a, hit.b)).unwrap_or_default();
        Clearance { distance_m: best, a, b }
    }

    /// Poses of the frames and centres of the clusters.
    pub(super) fn place(&self, scratch: &mut Scratch, q: &[f64]) {
        scratch.X_WF.clear();
        scratch.X_WF.push(Rigid::identity());
        for frame in self.frames.iter().skip(1) {
            let X_WF = frame.placed(&scratch.X_WF[frame.parent], q);
            scratch.X_WF.push(X_WF);
        }
        scratch.centers.clear();
        let X_WF = &scratch.X_WF;
        scratch.centers.extend(self.clusters.iter().map(|cluster| X_WF[cluster.frame].point(&cluster.center)));
    }

    /// Shows every pair of bodies, one of which moves, that may be closer than what `visit` answered last, at first than
    /// `limit`, metres.
    fn visit_pairs(&self, scratch: &mut Scratch, q: &[f64], mut limit: f64, visit: &mut Visit<'_>) {
        self.place(scratch, q);
        let world = Rigid::identity();
        for (index, cluster) in self.clusters.iter().enumerate() {
            let X_WF = &scratch.X_WF[cluster.frame];
            for &(fixed, depth_m) in &cluster.against {
                let fixed = &self.fixed[fixed];
                if !box_within(&scratch.centers[index], fixed, cluster.bound + limit) {
                    continue;
                }
                for solid in &cluster.solids {
                    if box_within(&X_WF.point(&solid.center), fixed, solid.bound + limit) {
                        let pair = Pair { a: cluster.owner, b: fixed.owner };
                        limit = visit(solid, X_WF, &fixed.solid, &world, depth_m, pair);
                    }
                }
            }
        }
        let mut visit_clusters = |a: usize, b: usize, depth_m: f64, limit: &mut f64| {
            let (a, b) = (&self.clusters[a], &self.clusters[b]);
            let (X_WA, X_WB) = (&scratch.X_WF[a.frame], &scratch.X_WF[b.frame]);
            for solid_a in &a.solids {
                let center = X_WA.point(&solid_a.center);
                for solid_b in &b.solids {
                    let gap = (center - X_WB.point(&solid_b.center)).norm() - solid_a.bound - solid_b.bound;
                    if gap <= *limit {
                        *limit = visit(solid_a, X_WA, solid_b, X_WB, depth_m, Pair { a: a.owner, b: b.owner });
                    }
                }
            }
        };
        for pair in &self.pairs {
            visit_clusters(pair.a, pair.b, pair.depth_m, &mut limit);
        }
        for &(pair, depth_m) in &self.constant {
            if let ConstantPair::Welded(a, b) = pair {
                visit_clusters(a, b, depth_m, &mut limit);
            }
        }
    }

    /// As [`Checker::visit_pairs`], of bodies that stand still both.
    fn visit_fixed(&self, visit: &mut Visit<'_>) {
        let world = Rigid::identity();
        let mut limit = f64::INFINITY;
        for &(pair, depth_m) in &self.constant {
            if let ConstantPair::Fixed(a, b) = pair {
                let (a, b) = (&self.fixed[a], &self.fixed[b]);
                if (a.solid.center - b.solid.center).norm() - a.solid.bound - b.solid.bound <= limit {
                    limit = visit(&a.solid, &world, &b.solid, &world, depth_m, Pair { a: a.owner, b: b.owner });
                }
            }
        }
    }

    /// The first touching pair among those whose distance no joint of this checker changes.
    pub(crate) fn find_constant_hit(&self) -> Option<Pair> {
        let world = Rigid::identity();
        self.constant.iter().find_map(|&(pair, depth_m)| {
            let gap = self.margin_m - depth_m;
            let (touching, pair): (bool, (Owner, Owner)) = match pair {
                ConstantPair::Fixed(a, b) => {
                    let (a, b) = (&self.fixed[a], &self.fixed[b]);
                    let reach = a.solid.bound + b.solid.bound + self.margin_m;
                    let close = (a.solid.center - b.solid.center).norm() <= reach;
                    let touching =
                        close && proximity(&a.solid, &world, &b.solid, &world, gap, gap) == Proximity::Touching;
                    (touching, (a.owner, b.owner))
                }
                ConstantPair::Welded(a, b) => {
                    let (a, b) = (&self.clusters[a], &self.clusters[b]);
                    (clusters_proximity(a, &world, b, &world, gap, gap) == Proximity::Touching, (a.owner, b.owner))
                }
            };
            touching.then_some(Pair { a: pair.0, b: pair.1 })
        })
    }
}

/// What was found so far for a cluster, and what still counts as near, metres.
struct Search {
    closest: Proximity,
    hit: Option<Pair>,
    near_m: f64,
}

/// Body, pose of its carrier, body, pose of its carrier, allowed depth, owners; answers the distance beyond which
/// further pairs need not be shown.
type Visit<'a> = dyn FnMut(&Solid, &Rigid, &Solid, &Rigid, f64, Pair) -> f64 + 'a;

fn box_within(center: &Vector3<f64>, fixed: &super::checker::Fixed, reach: f64) -> bool {
    reach >= 0.0 && squared_distance_to_box(center, &fixed.lower, &fixed.upper) <= reach * reach
}

/// The closest relation among the bodies of two clusters.
fn clusters_proximity(a: &Cluster, X_WA: &Rigid, b: &Cluster, X_WB: &Rigid, touch_m: f64, near_m: f64) -> Proximity {
    let mut closest = Proximity::Apart;
    for solid_a in &a.solids {
        let center = X_WA.point(&solid_a.center);
        for solid_b in &b.solids {
            let reach = solid_a.bound + solid_b.bound + near_m.max(0.0);
            if (center - X_WB.point(&solid_b.center)).norm_squared() > reach * reach {
                continue;
            }
            match proximity(solid_a, X_WA, solid_b, X_WB, touch_m, near_m) {
                Proximity::Touching => return Proximity::Touching,
                Proximity::Near => closest = Proximity::Near,
                Proximity::Apart => {}
            }
        }
    }
    closest
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3, Vector3};

    use crate::collision::testing::{brick, random_q, scene, two_arm_robot};
    use crate::collision::{Checker, CollisionModel, Exhaustive, HandChecker, MayTouch, Scratch, World};
    use crate::rng::Rng;

    #[test]
    fn the_hand_and_the_rest_together_find_what_the_whole_check_finds() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let mut rng = Rng::new(9, 0);
        let rest = random_q(&robot, &mut rng);
        let carried = brick(&robot, 0);
        let checker = Checker::for_arm(&model, &scene(), Some(&carried), &[], 0, &rest).unwrap();
        let mut scratch = Scratch::default();
        let (mut of_hand, mut of_rest) = (0, 0);
        for _ in 0..4000 {
            let q = random_q(&robot, &mut rng);
            let q: Vec<f64> = robot.arms[0].dofs.iter().map(|&dof| q[dof]).collect();
            let hand = checker.first_hit_of_hand(&mut scratch, &q);
            let besides = checker.first_hit_besides_hand(&mut scratch, &q);
            assert_eq!(hand.is_some() || besides.is_some(), checker.first_hit(&mut scratch, &q).is_some());
            of_hand += usize::from(hand.is_some() && besides.is_none());
            of_rest += usize::from(hand.is_none() && besides.is_some());
        }
        assert!(of_hand > 20 && of_rest > 20, "both must matter: {of_hand} {of_rest}");
    }

    #[test]
    fn fast_and_exhaustive_checkers_agree_on_ten_thousand_configurations() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let world = scene();
        let carried = brick(&robot, 0);
        let judge = Exhaustive::new(&model, &world, Some(&carried), &[]).unwrap();
        // The judge knows no margin.
        let whole = Checker::whole(&model, &world, Some(&carried), &[]).unwrap().with_margin(0.0);
        let mut rng = Rng::new(1, 0);
        let rest = random_q(&robot, &mut rng);
        let one_arm = Checker::for_arm(&model, &world, Some(&carried), &[], 0, &rest).unwrap().with_margin(0.0);
        let configurations: Vec<Vec<f64>> = (0..10_000).map(|_| random_q(&robot, &mut rng)).collect();
        let answers = crate::parallel::map(&configurations, |q| {
            let mut scratch = Scratch::default();
            let mut mixed = rest.clone();
            let q_arm: Vec<f64> = robot.arms[0].dofs.iter().map(|&dof| q[dof]).collect();
            for (&dof, &value) in robot.arms[0].dofs.iter().zip(&q_arm) {
                mixed[dof] = value;
            }
            let whole = (whole.first_hit(&mut scratch, q), judge.first_hit(q), q.clone());
            let arm = (one_arm.first_hit(&mut scratch, &q_arm), judge.first_hit_with_balls(&mixed), mixed);
            [whole, arm]
        });
        let mut hits = 0;
        for (ours, theirs, q) in answers.iter().flatten() {
            hits += usize::from(ours.is_some());
            if ours.is_some() != theirs.is_some() {
                // Only a touch within the judge's own numerical tolerance may be judged differently.
                let gap = judge.distance_m(q);
                assert!(gap.abs() < 1e-6, "{ours:?} {theirs:?}: the closest pair is at {gap} m");
            }
        }
        assert!(hits > 2_000 && hits < 18_000, "the configurations must show both answers: {hits} hits");
    }

    #[test]
    fn the_distance_is_negative_exactly_when_something_touches_and_matches_the_judge() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let world = scene();
        let checker = Checker::whole(&model, &world, None, &[]).unwrap().with_margin(0.0);
        let judge = Exhaustive::new(&model, &world, None, &[]).unwrap();
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(2, 0);
        let (mut free, mut touching) = (0, 0);
        for _ in 0..300 {
            let q = random_q(&robot, &mut rng);
            let clearance = checker.distance(&mut scratch, &q);
            if clearance.distance_m > 0.0 {
                free += 1;
                // GJK on parry's capsules stalls up to 2e-5 m away from the closest points.
                let theirs = judge.distance_m(&q);
                assert!((clearance.distance_m - theirs).abs() < 5e-5, "{clearance:?}, the judge: {theirs}");
            } else {
                touching += 1;
            }
            assert_eq!(clearance.distance_m <= 0.0, !checker.is_free(&mut scratch, &q), "{clearance:?}");
            let hits = checker.all_hits(&mut scratch, &q);
            assert_eq!(hits.is_empty(), checker.is_free(&mut scratch, &q));
            if let Some(first) = checker.first_hit(&mut scratch, &q) {
                assert!(hits.contains(&first), "{first} is not among {hits:?}");
            }
        }
        assert!(free > 20 && touching > 20, "{free} free, {touching} touching");
    }

    #[test]
    fn along_a_motion_the_distance_before_bounds_the_one_after() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let checker = Checker::for_arm(&model, &scene(), None, &[], 0, &vec![0.0; robot.dof_joints.len()]).unwrap();
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(7, 0);
        let pick = |q: Vec<f64>| -> Vec<f64> { robot.arms[0].dofs.iter().map(|&dof| q[dof]).collect() };
        for _ in 0..20 {
            let [from, to] = [pick(random_q(&robot, &mut rng)), pick(random_q(&robot, &mut rng))];
            let mut last: Option<(Vec<f64>, f64)> = None;
            for step in 0..=50 {
                let u = f64::from(step) / 50.0;
                let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + (b - a) * u).collect();
                let grown =
                    |(before, distance_m): &(Vec<f64>, f64)| distance_m + 2.0 * checker.displacement_m(before, &q);
                let most_m = last.as_ref().map_or(f64::INFINITY, grown) + 1e-9;
                let clearance = checker.distance(&mut scratch, &q);
                assert_eq!(checker.distance_within(&mut scratch, &q, most_m), clearance);
                last = Some((q, clearance.distance_m));
            }
        }
    }

    #[test]
    fn no_point_travels_farther_than_the_displacement_bound() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let carried = brick(&robot, 1);
        let checker = Checker::for_arm(&model, &World::new(), Some(&carried), &[], 1, &[0.0; 18]).unwrap();
        let mut rng = Rng::new(4, 0);
        let mut tightest: f64 = 0.0;
        for _ in 0..300 {
            let q = random_q(&robot, &mut rng);
            let mut to = q.clone();
            // One joint alone and all joints together.
            let moved = rng.index(8);
            for (column, &dof) in robot.arms[1].dofs.iter().enumerate() {
                if moved == 7 || moved == column {
                    to[dof] += rng.uniform(-0.02, 0.02);
                }
            }
            let pick = |q: &[f64]| robot.arms[1].dofs.iter().map(|&dof| q[dof]).collect::<Vec<_>>();
            let bound = checker.displacement_m(&pick(&q), &pick(&to));
            let (before, after) = (robot.link_poses(&q), robot.link_poses(&to));
            let hand = &robot.arms[1].hand;
            let corners = (0..8)
                .map(|k| Point3::new(f64::from(k & 1) - 0.5, f64::from(k >> 1 & 1) - 0.5, f64::from(k >> 2)) * 0.1);
            for corner in corners {
                let moved = (before[hand.tcp_link] * corner - after[hand.tcp_link] * corner).norm();
                assert!(moved <= bound + 1e-12, "moved {moved}, bound {bound}");
                tightest = tightest.max(moved / bound);
            }
        }
        assert!(tightest > 0.5, "a bound that is never approached would only cost time: {tightest}");
    }

    #[test]
    fn intended_contacts_are_not_reported_and_others_still_are() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let mut world = World::new();
        let mut scratch = Scratch::default();
        let q = vec![0.0; 18];
        let X_WT = robot.link_poses(&q)[robot.arms[0].hand.tcp_link];
        world.add_box("cube", Vector3::new(0.2, 0.05, 0.05), &X_WT).unwrap();
        let strict = Checker::for_arm(&model, &world, None, &[], 0, &q).unwrap();
        let q_arm = [0.0; 7];
        let hit = strict.first_hit(&mut scratch, &q_arm).unwrap();
        assert_eq!((hit.a.as_str(), hit.b.as_str()), ("left_finger_2", "cube"));
        let may = MayTouch::hand(&robot, 0, "cube");
        let lenient = Checker::for_arm(&model, &world, None, &may, 0, &q).unwrap();
        assert!(lenient.is_free(&mut scratch, &q_arm));
        world.add_box("wall", Vector3::new(0.01, 1.0, 1.0), &X_WT).unwrap();
        let lenient = Checker::for_arm(&model, &world, None, &may, 0, &q).unwrap();
        assert_eq!(lenient.first_hit(&mut scratch, &q_arm).unwrap().b, "wall");
    }

    #[test]
    fn a_carried_object_may_sink_into_its_table_only_as_deep_as_was_said() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let q = vec![0.0; 18];
        let carried = brick(&robot, 0);
        let X_WT = robot.link_poses(&q)[robot.arms[0].hand.tcp_link];
        // At q = 0 the left arm points along +y; the brick ends 0.1 m beyond the hand frame.
        let end = X_WT.translation.y + 0.1;
        for (sunk_m, free) in [(-0.001, true), (0.003, true), (0.009, false)] {
            let mut world = World::new();
            let center = Isometry3::translation(X_WT.translation.x, end - sunk_m + 0.5, X_WT.translation.z);
            world.add_box("table", Vector3::new(2.0, 1.0, 2.0), &center).unwrap();
            let may = [MayTouch::carried("table", 0.005)];
            let checker = Checker::for_arm(&model, &world, Some(&carried), &may, 0, &q).unwrap();
            let hit = checker.first_hit(&mut Scratch::default(), &[0.0; 7]);
            assert_eq!(hit.is_none(), free, "sunk by {sunk_m}: {hit:?}");
            let judge = Exhaustive::new(&model, &world, Some(&carried), &may).unwrap();
            assert_eq!(judge.first_hit(&q).is_none(), free, "the judge, sunk by {sunk_m}");
        }
    }

    #[test]
    fn a_hand_alone_names_the_link_that_meets_the_table() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let world = scene();
        let hand = HandChecker::new(&model, &world, &[], 0, &robot.arms[0].hand.open).unwrap();
        let down = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let at = |z: f64| Isometry3::from_parts(Translation3::new(0.3, -0.7, z), down);
        // Finger tips stand 0.02 m beyond the hand frame: palm 0.08 + finger 0.11 - 0.17.
        assert_eq!(hand.first_hit(&at(0.69 + 0.021)), None);
        let clearance = hand.distance(&at(0.69 + 0.03));
        assert!((clearance.distance_m - 0.01).abs() < 1e-6, "{clearance:?}");
        let hit = hand.first_hit(&at(0.69 + 0.019)).unwrap();
        assert_eq!((hit.a.as_str(), hit.b.as_str()), ("left_finger_1", "table"));
        assert!(HandChecker::new(&model, &world, &[], 0, &[0.0]).is_err());
        assert!(HandChecker::new(&model, &world, &[], 5, &[0.0]).is_err());
    }

    #[test]
    fn nonsense_is_answered_and_never_panics() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let checker = Checker::for_arm(&model, &World::new(), None, &[], 0, &[0.0; 18]).unwrap();
        let mut scratch = Scratch::default();
        for q in [vec![], vec![0.0; 6], vec![f64::NAN; 7], vec![f64::INFINITY; 7]] {
            assert!(checker.first_hit(&mut scratch, &q).is_some());
            assert_eq!(checker.distance(&mut scratch, &q).distance_m, f64::NEG_INFINITY);
            assert_eq!(checker.all_hits(&mut scratch, &q).len(), 1);
        }
        assert!(Checker::for_arm(&model, &World::new(), None, &[], 2, &[0.0; 18]).is_err());
        assert!(Checker::for_arm(&model, &World::new(), None, &[], 0, &[0.0; 3]).is_err());
    }
}
