//! The sieve's arithmetic: one chunk of configurations, the innermost index of every array.

use super::sieve::{Group, Moving, Place, Placed, Rod, Sieve, single};
use super::tree::Node;
use crate::simd::Kernel;

/// Configurations side by side.
pub(crate) const LANES: usize = 8;

type Lane = [f32; LANES];
/// All bits set where the answer is yes.
type Mask = [u32; LANES];

/// 1.5 · 2⁵²: adding it rounds to the nearest integer.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Newton steps towards the point of an axis that is nearest to a box, and to a cylinder.
const BOX_STEPS: usize = 2;
const CYLINDER_STEPS: usize = 3;

/// A direction shorter than about this separates nothing: its square is lost in single precision.
const NO_DIRECTION: f32 = 1e-12;

/// Working memory of one chunk and its answers.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    /// Rotation row by row and translation of each moving frame.
    frames: Vec<[Lane; 12]>,
    /// One end of each capsule's axis, and the way to the other.
    a: Vec<[Lane; 3]>,
    d: Vec<[Lane; 3]>,
    /// Configurations that surely touch nothing.
    pub(super) free: Mask,
    /// Configurations whose bodies may travel as was said without touching anything.
    pub(super) proven: Mask,
}

impl Default for Lanes {
    fn default() -> Self {
        Self { frames: Vec::new(), a: Vec::new(), d: Vec::new(), free: [0; LANES], proven: [0; LANES] }
    }
}

/// One chunk of a batch.
pub(super) struct Chunk<'a, const TRAVEL: bool> {
    pub(super) lanes: &'a mut Lanes,
    pub(super) sieve: &'a Sieve,
    /// One configuration after the other.
    pub(super) q: &'a [f64],
    /// Added to all radii, metres.
    pub(super) slack_m: f32,
    /// Travel of the ends of each capsule, metres, and by what it is scaled in each lane; not read unless `TRAVEL`.
    pub(super) travel: &'a [[f32; 2]],
    pub(super) scale: Lane,
}

impl<const TRAVEL: bool> Kernel for Chunk<'_, TRAVEL> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lanes, sieve, q, slack_m, travel, scale } = self;
        lanes.place(sieve, q);
        for (index, group) in sieve.groups.iter().enumerate() {
            lanes.carry(&sieve.capsules[group.begin..group.end], group.begin);
            let near = Near {
                center: lanes.center(sieve, index),
                reach: group.radius + slack_m,
                way: farthest(travel, group),
                scale,
            };
            let meet = Meet { sieve, slack_m, travel, scale };
            if let Some(obstacles) = &sieve.tree {
                let is_near = |lanes: &&mut Lanes, node: &Node| {
                    lanes.any_near(&near, (&single(&node.lower), &single(&node.upper)))
                };
                let mut state = &mut *lanes;
                obstacles.tree.visit(&mut state, is_near, |lanes, thing| {
                    if group.in_tree[thing / 64] & (1 << (thing % 64)) != 0 {
                        lanes.against::<TRAVEL>(group, &near, sieve.places[thing], &meet);
                    }
                    lanes.any()
                });
            }
            for &thing in &group.against {
                lanes.against::<TRAVEL>(group, &near, sieve.places[thing], &meet);
            }
            if !lanes.any() {
                return;
            }
        }
        for pair in &sieve.pairs {
            let (a, b) = (&sieve.groups[pair.a], &sieve.groups[pair.b]);
            let of_a = if TRAVEL && !pair.only_b { 1.0 } else { 0.0 };
            let reach = a.radius + b.radius + slack_m;
            let farthest = of_a * farthest(travel, a) + farthest(travel, b);
            let (center_a, center_b) = (lanes.center(sieve, pair.a), lanes.center(sieve, pair.b));
            if !lanes.any_close(&center_a, &center_b, reach, farthest, &scale) {
                continue;
            }
            for of in a.begin..a.end {
                for with in b.begin..b.end {
                    let (first, second) = (&sieve.capsules[of], &sieve.capsules[with]);
                    let (mut travel_a, mut travel_b) = ([0.0; 2], [0.0; 2]);
                    if TRAVEL {
                        travel_a = travel[of].map(|way| of_a * way);
                        travel_b = travel[with];
                    }
                    let reach = first.half + first.radius + second.half + second.radius + slack_m;
                    let farthest = greater(travel_a[0], travel_a[1]) + greater(travel_b[0], travel_b[1]);
                    let (middle_a, middle_b) = (lanes.middle(of), lanes.middle(with));
                    if !lanes.any_close(&middle_a, &middle_b, reach, farthest, &scale) {
                        continue;
                    }
                    let gap = Gap { radius: first.radius + second.radius + slack_m, travel: travel_a, scale };
                    lanes.past_each_other::<TRAVEL>((of, first.inverse), (with, second.inverse), travel_b, &gap);
                }
            }
            if !lanes.any() {
                return;
            }
        }
    }
}

/// A ball that travels.
struct Near {
    center: [Lane; 3],
    reach: f32,
    way: f32,
    scale: Lane,
}

/// What holds for a whole chunk.
struct Meet<'a> {
    sieve: &'a Sieve,
    slack_m: f32,
    travel: &'a [[f32; 2]],
    scale: Lane,
}

/// What must lie between an axis and something: a radius, and the travel of the ends times each lane's scale.
#[derive(Clone, Copy)]
struct Gap {
    radius: f32,
    travel: [f32; 2],
    scale: Lane,
}

impl Lanes {
    /// Poses of the frames.
    #[inline(always)]
    fn place(&mut self, sieve: &Sieve, q: &[f64]) {
        self.free = [u32::MAX; LANES];
        self.frames.resize(sieve.joints.len() + 1, [[0.0; LANES]; 12]);
        self.a.resize(sieve.capsules.len(), [[0.0; LANES]; 3]);
        self.d.resize(sieve.capsules.len(), [[0.0; LANES]; 3]);
        for (index, joint) in sieve.joints.iter().enumerate() {
            let mut position = [0.0; LANES];
            for k in 0..LANES {
                position[k] = joint.multiplier * q[k * sieve.columns + joint.column] + joint.offset;
            }
            let mut free = self.free;
            for k in 0..LANES {
                free[k] &= mask((position[k] as f32).abs() <= joint.most);
            }
            self.free = free;
            let mut X = if joint.parent == 0 {
                let entry = |e: usize| [if e < 9 { joint.R[e] } else { joint.t[e - 9] }; LANES];
                std::array::from_fn(entry)
            } else {
                goes_on(&self.frames[joint.parent], &joint.R, &joint.t)
            };
            if joint.slides {
                for i in 0..3 {
                    for k in 0..LANES {
                        X[9 + i][k] += X[3 * i + 2][k] * position[k] as f32;
                    }
                }
            } else {
                turn(&mut X, &position);
            }
            self.frames[index + 1] = X;
        }
        self.proven = self.free;
    }

    /// The axes of capsules in the world.
    #[inline(always)]
    fn carry(&mut self, capsules: &[Moving], begin: usize) {
        for (index, capsule) in capsules.iter().enumerate() {
            let X = &self.frames[capsule.frame];
            self.a[begin + index] = point(X, &capsule.a);
            let mut d = [[0.0; LANES]; 3];
            for i in 0..3 {
                for k in 0..LANES {
                    d[i][k] =
                        X[3 * i][k] * capsule.d[0] + X[3 * i + 1][k] * capsule.d[1] + X[3 * i + 2][k] * capsule.d[2];
                }
            }
            self.d[begin + index] = d;
        }
    }

    /// Compares the capsules of a group with something that stands still.
    #[inline(always)]
    fn against<const TRAVEL: bool>(&mut self, group: &Group, near: &Near, place: Place, meet: &Meet<'_>) {
        let Meet { sieve, slack_m, travel, scale } = *meet;
        let around = match place {
            Place::Box(index) => (&sieve.boxes[index].lower, &sieve.boxes[index].upper),
            Place::Cylinder(index) => (&sieve.cylinders[index].lower, &sieve.cylinders[index].upper),
            Place::Rod(index) => (&sieve.rods[index].lower, &sieve.rods[index].upper),
        };
        if !self.any_near(near, around) {
            return;
        }
        for capsule in group.begin..group.end {
            let moving = &sieve.capsules[capsule];
            let travel: [f32; 2] = if TRAVEL { travel[capsule] } else { [0.0; 2] };
            if group.end - group.begin > 1 {
                let reach = moving.half + moving.radius + slack_m;
                let way = greater(travel[0], travel[1]);
                if !self.any_near(&Near { center: self.middle(capsule), reach, way, scale }, around) {
                    continue;
                }
            }
            let gap = Gap { radius: moving.radius + slack_m, travel, scale };
            match place {
                Place::Box(index) => self.past_box::<TRAVEL>(capsule, moving, &sieve.boxes[index], &gap),
                Place::Cylinder(index) => self.past_cylinder::<TRAVEL>(capsule, moving, &sieve.cylinders[index], &gap),
                Place::Rod(index) => self.past_rod::<TRAVEL>(capsule, moving, &sieve.rods[index], &gap),
            }
        }
    }

    #[inline(always)]
    fn center(&self, sieve: &Sieve, group: usize) -> [Lane; 3] {
        let group = &sieve.groups[group];
        if group.end - group.begin == 1 {
            self.middle(group.begin)
        } else {
            point(&self.frames[group.frame], &group.center)
        }
    }

    #[inline(always)]
    fn middle(&self, capsule: usize) -> [Lane; 3] {
        let (a, d) = (&self.a[capsule], &self.d[capsule]);
        let mut middle = [[0.0; LANES]; 3];
        for i in 0..3 {
            for k in 0..LANES {
                middle[i][k] = a[i][k] + 0.5 * d[i][k];
            }
        }
        middle
    }

    #[inline(always)]
    fn any(&self) -> bool {
        let mut any = 0;
        for k in 0..LANES {
            any |= self.free[k];
        }
        any != 0
    }

    /// Whether a ball comes near an axis-aligned box in any configuration that is not given up.
    #[inline(always)]
    fn any_near(&self, near: &Near, (lower, upper): (&[f32; 3], &[f32; 3])) -> bool {
        let Near { center: p, reach, way, scale } = near;
        let mut any = 0;
        for k in 0..LANES {
            let dx = greater(greater(lower[0] - p[0][k], p[0][k] - upper[0]), 0.0);
            let dy = greater(greater(lower[1] - p[1][k], p[1][k] - upper[1]), 0.0);
            let dz = greater(greater(lower[2] - p[2][k], p[2][k] - upper[2]), 0.0);
            let reach = reach + way * scale[k];
            any |= self.free[k] & !mask(dx * dx + dy * dy + dz * dz > reach * reach);
        }
        any != 0
    }

    /// Whether two balls come near each other in any configuration that is not given up.
    #[inline(always)]
    fn any_close(&self, p: &[Lane; 3], q: &[Lane; 3], reach: f32, way: f32, scale: &Lane) -> bool {
        let mut any = 0;
        for k in 0..LANES {
            let (dx, dy, dz) = (p[0][k] - q[0][k], p[1][k] - q[1][k], p[2][k] - q[2][k]);
            let reach = reach + way * scale[k];
            any |= self.free[k] & !mask(dx * dx + dy * dy + dz * dz > reach * reach);
        }
        any != 0
    }

    /// Gives up the configurations in which no plane is found between a capsule and a box.
    #[inline(always)]
    fn past_box<const TRAVEL: bool>(&mut self, index: usize, moving: &Moving, thing: &Placed<[f32; 3]>, gap: &Gap) {
        let (a, d) = seen_from(&self.a[index], &self.d[index], thing);
        let half = &thing.size;
        let (mut free, mut proven, scale) = (self.free, self.proven, gap.scale);
        for k in 0..LANES {
            let (ax, ay, az) = (a[0][k], a[1][k], a[2][k]);
            let (dx, dy, dz) = (d[0][k], d[1][k], d[2][k]);
            let mut t = unit(-(ax * dx + ay * dy + az * dz) * moving.inverse);
            let outside = |x: f32, half: f32| x - less(greater(x, -half), half);
            for _ in 0..BOX_STEPS {
                let ex = outside(ax + t * dx, half[0]);
                let ey = outside(ay + t * dy, half[1]);
                let ez = outside(az + t * dz, half[2]);
                // The slope of half the squared distance along the axis, and its own slope.
                let slope = dx * ex + dy * ey + dz * ez;
                let steep = |e: f32, d: f32| if e == 0.0 { 0.0 } else { d * d };
                let bend = steep(ex, dx) + steep(ey, dy) + steep(ez, dz);
                t = unit(t - slope / greater(bend, f32::MIN_POSITIVE));
            }
            let nx = outside(ax + t * dx, half[0]);
            let ny = outside(ay + t * dy, half[1]);
            let nz = outside(az + t * dz, half[2]);
            let size = (nx * nx + ny * ny + nz * nz).sqrt();
            let at_a = nx * ax + ny * ay + nz * az - (nx.abs() * half[0] + ny.abs() * half[1] + nz.abs() * half[2]);
            let along = nx * dx + ny * dy + nz * dz;
            let (is_free, is_proven) = decide::<TRAVEL>(at_a, along, size, gap, scale[k]);
            free[k] &= is_free;
            proven[k] &= is_proven;
        }
        (self.free, self.proven) = (free, proven);
    }

    /// Gives up the configurations in which no plane is found between a capsule and a cylinder.
    #[inline(always)]
    fn past_cylinder<const TRAVEL: bool>(
        &mut self,
        index: usize,
        moving: &Moving,
        thing: &Placed<[f32; 2]>,
        gap: &Gap,
    ) {
        let (a, d) = seen_from(&self.a[index], &self.d[index], thing);
        let [radius, half] = thing.size;
        let (mut free, mut proven, scale) = (self.free, self.proven, gap.scale);
        for k in 0..LANES {
            let (ax, ay, az) = (a[0][k], a[1][k], a[2][k]);
            let (dx, dy, dz) = (d[0][k], d[1][k], d[2][k]);
            let mut t = unit(-(ax * dx + ay * dy + az * dz) * moving.inverse);
            let outside = |t: f32| {
                let (x, y, z) = (ax + t * dx, ay + t * dy, az + t * dz);
                let aside = (x * x + y * y).sqrt();
                let share = if aside > radius { 1.0 - radius / aside } else { 0.0 };
                (x * share, y * share, z - less(greater(z, -half), half))
            };
            for _ in 0..CYLINDER_STEPS {
                let (ex, ey, ez) = outside(t);
                t = unit(t - (dx * ex + dy * ey + dz * ez) * moving.inverse);
            }
            let (nx, ny, nz) = outside(t);
            let flat = nx * nx + ny * ny;
            let size = (flat + nz * nz).sqrt();
            let at_a = nx * ax + ny * ay + nz * az - (flat.sqrt() * radius + nz.abs() * half);
            let along = nx * dx + ny * dy + nz * dz;
            let (is_free, is_proven) = decide::<TRAVEL>(at_a, along, size, gap, scale[k]);
            free[k] &= is_free;
            proven[k] &= is_proven;
        }
        (self.free, self.proven) = (free, proven);
    }

    /// Gives up the configurations in which no plane is found between a capsule and one that stands still.
    #[inline(always)]
    fn past_rod<const TRAVEL: bool>(&mut self, index: usize, moving: &Moving, rod: &Rod, gap: &Gap) {
        let gap = Gap { radius: gap.radius + rod.radius, ..*gap };
        let (a, d) = (self.a[index], self.d[index]);
        let (mut free, mut proven, scale) = (self.free, self.proven, gap.scale);
        for k in 0..LANES {
            let r = [a[0][k] - rod.a[0], a[1][k] - rod.a[1], a[2][k] - rod.a[2]];
            let da = [d[0][k], d[1][k], d[2][k]];
            let (n, size) = across(&r, (&da, moving.inverse), (&rod.d, rod.inverse));
            let beyond = greater(dot(&n, &rod.d), 0.0);
            let (is_free, is_proven) = decide::<TRAVEL>(dot(&n, &r) - beyond, dot(&n, &da), size, &gap, scale[k]);
            free[k] &= is_free;
            proven[k] &= is_proven;
        }
        (self.free, self.proven) = (free, proven);
    }

    /// Gives up the configurations in which no plane is found between two capsules.
    #[inline(always)]
    fn past_each_other<const TRAVEL: bool>(
        &mut self,
        of: (usize, f32),
        with: (usize, f32),
        travel_b: [f32; 2],
        gap: &Gap,
    ) {
        let (a, da, b, db) = (self.a[of.0], self.d[of.0], self.a[with.0], self.d[with.0]);
        let (mut free, mut proven, scale) = (self.free, self.proven, gap.scale);
        for k in 0..LANES {
            let r = [a[0][k] - b[0][k], a[1][k] - b[1][k], a[2][k] - b[2][k]];
            let da = [da[0][k], da[1][k], da[2][k]];
            let db = [db[0][k], db[1][k], db[2][k]];
            let (n, size) = across(&r, (&da, of.1), (&db, with.1));
            let (at_a, along, beyond) = (dot(&n, &r), dot(&n, &da), dot(&n, &db));
            let wanted = gap.radius * size + NO_DIRECTION;
            free[k] &= mask(at_a + less(along, 0.0) - greater(beyond, 0.0) > wanted);
            if TRAVEL {
                let way = scale[k] * size;
                let first = less(at_a - gap.travel[0] * way, at_a + along - gap.travel[1] * way);
                let second = greater(travel_b[0] * way, beyond + travel_b[1] * way);
                proven[k] &= mask(first - second > wanted);
            }
        }
        (self.free, self.proven) = (free, proven);
    }
}

/// Whether the ends of an axis stand `gap` before a plane, as they are and when they travel: `at_a` is the height of the
/// first above it, `at_a + along` that of the second, both times the length `size` of the plane's normal.
#[inline(always)]
fn decide<const TRAVEL: bool>(at_a: f32, along: f32, size: f32, gap: &Gap, scale: f32) -> (u32, u32) {
    let wanted = gap.radius * size + NO_DIRECTION;
    let free = mask(at_a + less(along, 0.0) > wanted);
    if !TRAVEL {
        return (free, free);
    }
    let way = scale * size;
    let height = less(at_a - gap.travel[0] * way, at_a + along - gap.travel[1] * way);
    (free, mask(height > wanted))
}

/// The largest travel among the capsules of a group; 0 if there is none to look up.
#[inline(always)]
fn farthest(travel: &[[f32; 2]], group: &Group) -> f32 {
    let ways = travel.get(group.begin..group.end).unwrap_or_default();
    ways.iter().fold(0.0, |most, way| greater(most, greater(way[0], way[1])))
}

/// A pose followed by a constant one, most of whose entries are 0 in most robots.
#[inline(always)]
fn goes_on(X: &[Lane; 12], R: &[f32; 9], t: &[f32; 3]) -> [Lane; 12] {
    let mut next = [[0.0; LANES]; 12];
    next[9..].copy_from_slice(&X[9..]);
    for from in 0..3 {
        for (to, &entry) in [R[3 * from], R[3 * from + 1], R[3 * from + 2]].iter().enumerate() {
            if entry != 0.0 {
                for i in 0..3 {
                    for k in 0..LANES {
                        next[3 * i + to][k] += X[3 * i + from][k] * entry;
                    }
                }
            }
        }
        if t[from] != 0.0 {
            for i in 0..3 {
                for k in 0..LANES {
                    next[9 + i][k] += X[3 * i + from][k] * t[from];
                }
            }
        }
    }
    next
}

/// A pose followed by a turn about z.
#[inline(always)]
fn turn(X: &mut [Lane; 12], position: &[f64; LANES]) {
    for k in 0..LANES {
        let turns = position[k] * (0.5 * std::f64::consts::FRAC_1_PI);
        let rest = turns - ((turns + ROUNDER) - ROUNDER);
        // Half of what is left of the angle, within ±π/2: Taylor leaves h¹³/13! < 6e-8 and h¹⁴/14! < 7e-9.
        let h = (rest * std::f64::consts::PI) as f32;
        let s = h * h;
        let tail = s * (1.0 / 362_880.0 - s * (1.0 / 39_916_800.0));
        let sine = h * (1.0 - s * (1.0 / 6.0 - s * (1.0 / 120.0 - s * (1.0 / 5_040.0 - tail))));
        let tail = s * (1.0 / 3_628_800.0 - s * (1.0 / 479_001_600.0));
        let cosine = 1.0 - s * (0.5 - s * (1.0 / 24.0 - s * (1.0 / 720.0 - s * (1.0 / 40_320.0 - tail))));
        let (sin, cos) = (2.0 * sine * cosine, 1.0 - 2.0 * sine * sine);
        for i in 0..3 {
            let (x, y) = (X[3 * i][k], X[3 * i + 1][k]);
            X[3 * i][k] = x * cos + y * sin;
            X[3 * i + 1][k] = y * cos - x * sin;
        }
    }
}

#[inline(always)]
fn point(X: &[Lane; 12], p: &[f32; 3]) -> [Lane; 3] {
    let mut at = [[0.0; LANES]; 3];
    for i in 0..3 {
        for k in 0..LANES {
            at[i][k] = X[3 * i][k] * p[0] + X[3 * i + 1][k] * p[1] + X[3 * i + 2][k] * p[2] + X[9 + i][k];
        }
    }
    at
}

/// An axis in the frame of something that stands still.
#[inline(always)]
fn seen_from<S>(a: &[Lane; 3], d: &[Lane; 3], thing: &Placed<S>) -> ([Lane; 3], [Lane; 3]) {
    let (mut from, mut way) = (*a, *d);
    for (from, center) in from.iter_mut().zip(&thing.center) {
        from.iter_mut().for_each(|x| *x -= center);
    }
    if let Some(R) = &thing.turned {
        let (p, d) = (from, way);
        for i in 0..3 {
            for k in 0..LANES {
                from[i][k] = R[3 * i] * p[0][k] + R[3 * i + 1] * p[1][k] + R[3 * i + 2] * p[2][k];
                way[i][k] = R[3 * i] * d[0][k] + R[3 * i + 1] * d[1][k] + R[3 * i + 2] * d[2][k];
            }
        }
    }
    (from, way)
}

/// From the nearest point of the second axis to that of the first, and its length; `r` leads from the beginning of the
/// second to that of the first (Ericson, Real-Time Collision Detection, 5.1.9).
#[inline(always)]
fn across(r: &[f32; 3], first: (&[f32; 3], f32), second: (&[f32; 3], f32)) -> ([f32; 3], f32) {
    let ((da, inverse_a), (db, inverse_b)) = (first, second);
    let (ca, fb, ab) = (dot(da, r), dot(db, r), dot(da, db));
    // 1 − cos² of the angle between them; parallel axes may start anywhere.
    let apart = 1.0 - ab * ab * inverse_a * inverse_b;
    let free = (ab * fb * inverse_b - ca) * inverse_a / greater(apart, 1e-6);
    let s = unit(free);
    let t = unit((ab * s + fb) * inverse_b);
    let s = unit((ab * t - ca) * inverse_a);
    let n = [r[0] + da[0] * s - db[0] * t, r[1] + da[1] * s - db[1] * t, r[2] + da[2] * s - db[2] * t];
    (n, dot(&n, &n).sqrt())
}

#[inline(always)]
fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The comparisons are written out: `f32::min` and `max` spend instructions on what is not a number.
#[inline(always)]
fn less(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn unit(x: f32) -> f32 {
    less(greater(x, 0.0), 1.0)
}

#[inline(always)]
fn mask(yes: bool) -> u32 {
    if yes { u32::MAX } else { 0 }
}
