//! Fields: data bodies by the tens of thousands that stay where they are, uploaded once and sorted when the view turns.

use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
};

use nalgebra::{Point3, Vector3};

use super::{
    Camera, Frame, MeshDraw,
    bounds::is_finite,
    gpu::{Stream, fixed_buffer},
    meshes::{Batch, Groups, Instance, OPAQUE},
};

/// Steps into which the depth of a field is cut for sorting: less than a millimetre each over the reach of two arms.
const STEPS: usize = 4096;

/// Bodies of one mesh after another with the buffer that holds their instances.
pub(super) type Batches<'a> = (&'a wgpu::Buffer, &'a [Batch]);

/// A field on the GPU.
struct Field {
    bodies: Weak<Vec<MeshDraw>>,
    scene_center: Point3<f64>,
    opaque: Option<(wgpu::Buffer, Vec<Batch>)>,
    clear: Clear,
}

/// The see-through bodies of a field.
struct Clear {
    /// Centres relative to the scene's.
    places: Vec<[f32; 3]>,
    instances: Vec<Instance>,
    meshes: Vec<usize>,
    /// The direction along which they were sorted last.
    sorted: Option<Vector3<f64>>,
    batches: Vec<Batch>,
    stream: Stream,
}

impl Field {
    fn new(device: &wgpu::Device, bodies: &Arc<Vec<MeshDraw>>, scene_center: Point3<f64>) -> Self {
        let (mut opaque, mut clear) = (Groups::default(), Clear::default());
        for draw in bodies.iter() {
            let is_seen = draw.color[3] > 0.0 && draw.color.iter().all(|c| c.is_finite()) && is_finite(&draw.X_WM);
            if is_seen && draw.color[3] >= OPAQUE {
                opaque.add(draw);
            } else if is_seen {
                let from_center = draw.X_WM.translation.vector - scene_center.coords;
                clear.places.push([from_center.x as f32, from_center.y as f32, from_center.z as f32]);
                clear.instances.push(Instance::new(draw, &scene_center));
                clear.meshes.push(Arc::as_ptr(&draw.mesh) as usize);
            }
        }
        let mut instances = Vec::new();
        let batches = opaque.place(&mut instances, &scene_center);
        let upload = || fixed_buffer(device, "field", wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&instances));
        let opaque = (!instances.is_empty()).then(|| (upload(), batches));
        Self { bodies: Arc::downgrade(bodies), scene_center, opaque, clear }
    }
}

impl Default for Clear {
    fn default() -> Self {
        let stream = Stream::new("clear field", wgpu::BufferUsages::VERTEX);
        let (places, instances, meshes, batches) = Default::default();
        Self { places, instances, meshes, sorted: None, batches, stream }
    }
}

impl Clear {
    /// Brings the bodies into order along a direction, the farthest first.
    fn sort(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, forward: &Vector3<f64>) {
        if self.places.is_empty() || self.sorted == Some(*forward) {
            return;
        }
        self.batches.clear();
        let mut sorted: Vec<Instance> = Vec::with_capacity(self.instances.len());
        for index in far_to_near(&self.places, forward) {
            let (instance, mesh) = (self.instances[index as usize], self.meshes[index as usize]);
            Batch::add(&mut self.batches, mesh, sorted.len() as u32);
            sorted.push(instance);
        }
        let _buffer = self.stream.write(device, queue, bytemuck::cast_slice(&sorted));
        self.sorted = Some(*forward);
    }
}

/// Indices of places in the order of their depth along a direction, the farthest first; by counting, because comparing
/// 50 000 of them in every frame of a turning view would take as long as all the rest. Equal ones keep their order.
fn far_to_near(places: &[[f32; 3]], forward: &Vector3<f64>) -> Vec<u32> {
    let [x, y, z] = [forward.x as f32, forward.y as f32, forward.z as f32];
    let mut depths = vec![0.0_f32; places.len()];
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for (depth, place) in depths.iter_mut().zip(places) {
        *depth = x * place[0] + y * place[1] + z * place[2];
        (least, most) = (least.min(*depth), most.max(*depth));
    }
    let per_step = (STEPS - 1) as f32 / (most - least).max(f32::MIN_POSITIVE);
    let step = |depth: f32| (((most - depth) * per_step) as usize).min(STEPS - 1);
    let mut starts = [0_u32; STEPS + 1];
    for depth in &depths {
        starts[step(*depth) + 1] += 1;
    }
    for index in 0..STEPS {
        starts[index + 1] += starts[index];
    }
    let mut order = vec![0; places.len()];
    for (index, depth) in (0..).zip(&depths) {
        let at = &mut starts[step(*depth)];
        order[*at as usize] = index;
        *at += 1;
    }
    order
}

/// Fields on the GPU.
#[derive(Default)]
pub(super) struct Fields {
    uploaded: BTreeMap<usize, Field>,
    /// Those of the current picture.
    shown: Vec<usize>,
}

impl Fields {
    /// Uploads what is new, forgets what nobody holds, sorts what the view has turned.
    pub(super) fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame,
        camera: &Camera,
        scene_center: &Point3<f64>,
    ) {
        self.uploaded.retain(|_, field| field.bodies.strong_count() > 0 && field.scene_center == *scene_center);
        self.shown.clear();
        let forward = -camera.backward();
        for bodies in &frame.fields {
            let key = Arc::as_ptr(bodies) as usize;
            let field = self.uploaded.entry(key).or_insert_with(|| Field::new(device, bodies, *scene_center));
            field.clear.sort(device, queue, &forward);
            self.shown.push(key);
        }
    }

    /// The opaque bodies of the current picture.
    pub(super) fn opaque(&self) -> impl Iterator<Item = Batches<'_>> {
        let shown = self.shown.iter().filter_map(|key| self.uploaded.get(key)?.opaque.as_ref());
        shown.map(|(buffer, batches)| (buffer, batches.as_slice()))
    }

    /// Its see-through bodies, those of each field from back to front.
    pub(super) fn clear(&self) -> impl Iterator<Item = Batches<'_>> {
        let shown = self.shown.iter().filter_map(|key| self.uploaded.get(key));
        shown.filter_map(|field| Some((field.clear.stream.buffer()?, field.clear.batches.as_slice())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_sorted_from_far_to_near_along_any_direction() {
        let places: Vec<[f32; 3]> = (0..3000_u32)
            .map(|k| [k.wrapping_mul(2_654_435_761) % 997, k * 7 % 101, k * 13 % 53].map(|v| v as f32 * 0.01))
            .collect();
        for forward in [Vector3::x(), -Vector3::y(), Vector3::new(0.48, -0.6, 0.64)] {
            let order = far_to_near(&places, &forward);
            let mut once = order.clone();
            once.sort_unstable();
            assert!(once.iter().copied().eq(0..3000), "each once");
            let depth = |index: u32| forward.dot(&Vector3::from(places[index as usize].map(f64::from)));
            let range = places.iter().map(|p| forward.dot(&Vector3::from(p.map(f64::from))));
            let (least, most) = range.fold((f64::MAX, f64::MIN), |(least, most), d| (least.min(d), most.max(d)));
            let step_m = (most - least) / (STEPS - 1) as f64;
            assert!(order.windows(2).all(|pair| depth(pair[0]) > depth(pair[1]) - 1.01 * step_m));
        }
        assert_eq!(far_to_near(&[[1.0; 3]; 4], &Vector3::x()), [0, 1, 2, 3]);
        assert!(far_to_near(&[], &Vector3::x()).is_empty());
    }
}
