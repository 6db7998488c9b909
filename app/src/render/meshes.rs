//! Bodies: uploaded meshes, their instances, and in which order they are drawn.

use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
};

use bytemuck::{Pod, Zeroable};
use endcomfort_core::mesh::Mesh;
use nalgebra::{Point3, Unit, Vector3};

use super::{
    BoundsCache, Camera, Frame, MeshDraw, Surface,
    bounds::is_finite,
    fields::Fields,
    gpu::{Color, Recipe, Sampled, Stream, fixed_buffer, shader},
};

/// Opacity from which a body is drawn as opaque.
pub(super) const OPAQUE: f32 = 0.999;

/// One vertex in the mesh's frame. Here `f32` begins.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

/// One body; see `Vertex` in `meshes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Instance {
    rows: [[f32; 4]; 3],
    srgb: [f32; 4],
    surface: [f32; 4],
}

impl Instance {
    /// `R_WM` and `p_WM` relative to the scene centre: here `f32` begins.
    pub(super) fn new(draw: &MeshDraw, scene_center: &Point3<f64>) -> Self {
        let rotation = draw.X_WM.rotation.to_rotation_matrix();
        let shift = draw.X_WM.translation.vector - scene_center.coords;
        let row = |k: usize| [rotation[(k, 0)], rotation[(k, 1)], rotation[(k, 2)], shift[k]].map(|v| v as f32);
        let (roughness, reflectance) = match draw.surface {
            Surface::Satin => (0.48, 0.04),
            Surface::Matte => (0.70, 0.035),
            Surface::Gloss => (0.22, 0.07),
            Surface::Unlit | Surface::Ghost => (1.0, 0.0),
            Surface::Facet => (0.0, 0.0),
        };
        let lit = f32::from(u8::from(is_lit(draw.surface)));
        let masked = f32::from(u8::from(is_solid(draw)));
        Self { rows: [row(0), row(1), row(2)], srgb: draw.color, surface: [roughness, reflectance, lit, masked] }
    }
}

fn is_lit(surface: Surface) -> bool {
    matches!(surface, Surface::Satin | Surface::Matte | Surface::Gloss)
}

/// Lit and opaque: such bodies cast shadow and take it through the mask.
fn is_solid(draw: &MeshDraw) -> bool {
    is_lit(draw.surface) && draw.color[3] >= OPAQUE
}

/// A mesh on the GPU.
struct Uploaded {
    mesh: Weak<Mesh>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl Uploaded {
    /// `None` if the mesh has no triangle.
    fn new(device: &wgpu::Device, mesh: &Arc<Mesh>) -> Option<Self> {
        let count = mesh.positions.len() as u32;
        let is_whole = |&[a, b, c]: &[u32; 3]| a < count && b < count && c < count;
        let mut triangles = mesh.triangles.clone();
        triangles.retain(is_whole);
        let computed = (mesh.normals.len() != mesh.positions.len()).then(|| vertex_normals(mesh, &triangles));
        let normals = computed.as_ref().unwrap_or(&mesh.normals);
        // A plain loop: see `Uploaded::new` of the points.
        let mut vertices = vec![Vertex::zeroed(); mesh.positions.len()];
        for index in 0..vertices.len() {
            let [[x, y, z], [nx, ny, nz]] = [mesh.positions[index].coords.data.0[0], normals[index].data.0[0]];
            vertices[index] =
                Vertex { position: [x as f32, y as f32, z as f32], normal: [nx as f32, ny as f32, nz as f32] };
        }
        let upload = |usage, bytes| fixed_buffer(device, "mesh", usage, bytes);
        (!triangles.is_empty()).then(|| Self {
            mesh: Arc::downgrade(mesh),
            vertices: upload(wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&vertices)),
            indices: upload(wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&triangles)),
            index_count: triangles.len() as u32 * 3,
        })
    }
}

/// Mean of the triangles' normals at each vertex, weighted by area.
fn vertex_normals(mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); mesh.positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let area = (b - a).cross(&(c - a));
        for &i in triangle {
            normals[i as usize] += area;
        }
    }
    normals.into_iter().map(|n| Unit::try_new(n, 0.0).map_or(Vector3::z(), Unit::into_inner)).collect()
}

/// Instances of one mesh that are drawn at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Batch {
    /// Address of the mesh.
    mesh: usize,
    first: u32,
    count: u32,
}

impl Batch {
    /// Adds the instance `index`, the next one, of a mesh.
    pub(super) fn add(batches: &mut Vec<Self>, mesh: usize, index: u32) {
        match batches.last_mut() {
            Some(last) if last.mesh == mesh => last.count += 1,
            _ => batches.push(Self { mesh, first: index, count: 1 }),
        }
    }
}

/// A frame's bodies in drawing order.
#[derive(Default)]
pub(super) struct Plan {
    instances: Vec<Instance>,
    /// Lit and opaque.
    pub(super) solid: Vec<Batch>,
    /// Opaque data.
    pub(super) unlit: Vec<Batch>,
    /// See-through, from back to front.
    pub(super) clear: Vec<Clear>,
}

/// A run of see-through bodies.
pub(super) enum Clear {
    /// Bodies mixed in one after the other.
    Plain(Batch),
    /// The parts of one ghost, of which only the nearest surface is seen.
    Ghost(Vec<Batch>),
}

impl Plan {
    /// Sorts a frame's bodies. Poses and colours that are not finite are left out.
    pub(super) fn new(frame: &Frame, camera: &Camera, scene_center: &Point3<f64>, bounds: &mut BoundsCache) -> Self {
        let mut plan = Self::default();
        let (mut solid, mut unlit) = (Groups::default(), Groups::default());
        // Depth, position in the frame, number of draws: a whole ghost is sorted as one.
        let mut clear: Vec<(f64, usize, usize)> = Vec::new();
        let mut last_sphere = None;
        let mut last_ghost: Option<(usize, [f32; 4], u32)> = None;
        for (idx, draw) in frame.meshes.iter().enumerate() {
            let visible = draw.color[3] > 0.0 && draw.color.iter().all(|c| c.is_finite()) && is_finite(&draw.X_WM);
            // Many draws of one mesh follow each other.
            let mesh = Arc::as_ptr(&draw.mesh);
            let sphere = match last_sphere {
                Some((known, sphere)) if known == mesh => sphere,
                _ => bounds.sphere(&draw.mesh),
            };
            last_sphere = Some((mesh, sphere));
            let Some(sphere) = sphere.filter(|_| visible) else { continue };
            let depth_m = camera.depth_m(&(draw.X_WM * sphere.center));
            if draw.surface == Surface::Ghost {
                let same = (idx, draw.color, draw.pick_id);
                match (last_ghost, clear.last_mut()) {
                    (Some((last, color, id)), Some(ghost)) if (last + 1, color, id) == same => {
                        ghost.0 = ghost.0.min(depth_m);
                        ghost.2 += 1;
                    }
                    _ => clear.push((depth_m, idx, 1)),
                }
                last_ghost = Some(same);
            } else if draw.color[3] < OPAQUE {
                clear.push((depth_m, idx, 1));
            } else if is_lit(draw.surface) {
                solid.add(draw);
            } else {
                unlit.add(draw);
            }
        }
        clear.sort_by(|a, b| b.0.total_cmp(&a.0));
        plan.solid = solid.place(&mut plan.instances, scene_center);
        plan.unlit = unlit.place(&mut plan.instances, scene_center);
        for (_, first, count) in clear {
            let draws = &frame.meshes[first..first + count];
            let ghost = draws.first().is_some_and(|draw| draw.surface == Surface::Ghost);
            if ghost {
                let mut parts = Groups::default();
                draws.iter().for_each(|draw| parts.add(draw));
                let batches = parts.place(&mut plan.instances, scene_center);
                plan.clear.push(Clear::Ghost(batches));
                continue;
            }
            for draw in draws {
                let mesh = Arc::as_ptr(&draw.mesh) as usize;
                let first = plan.instances.len() as u32;
                plan.instances.push(Instance::new(draw, scene_center));
                match plan.clear.last_mut() {
                    Some(Clear::Plain(batch)) if batch.mesh == mesh => batch.count += 1,
                    _ => plan.clear.push(Clear::Plain(Batch { mesh, first, count: 1 })),
                }
            }
        }
        plan
    }

    /// The instances that cast shadow; they come first.
    pub(super) fn casters(&self) -> &[Instance] {
        let count = self.solid.iter().map(|batch| batch.count as usize).sum();
        self.instances.get(..count).unwrap_or_default()
    }
}

/// Whether a draw takes part in [`Plan::solid`].
pub(super) fn casts_shadow(draw: &MeshDraw) -> bool {
    is_solid(draw) && is_finite(&draw.X_WM) && draw.color.iter().all(|c| c.is_finite())
}

/// Draws by mesh, in the order in which the meshes first appear.
#[derive(Default)]
pub(super) struct Groups<'f> {
    places: BTreeMap<usize, usize>,
    /// Mesh and place of the last draw: many of one mesh follow each other.
    last: Option<(usize, usize)>,
    draws: Vec<(usize, Vec<&'f MeshDraw>)>,
}

impl<'f> Groups<'f> {
    pub(super) fn add(&mut self, draw: &'f MeshDraw) {
        let mesh = Arc::as_ptr(&draw.mesh) as usize;
        let place = match self.last {
            Some((known, place)) if known == mesh => place,
            _ => *self.places.entry(mesh).or_insert_with(|| {
                self.draws.push((mesh, Vec::new()));
                self.draws.len() - 1
            }),
        };
        self.last = Some((mesh, place));
        self.draws[place].1.push(draw);
    }

    /// Appends the instances, mesh by mesh.
    pub(super) fn place(self, instances: &mut Vec<Instance>, scene_center: &Point3<f64>) -> Vec<Batch> {
        let mut batches = Vec::with_capacity(self.draws.len());
        for (mesh, draws) in self.draws {
            let first = instances.len() as u32;
            instances.extend(draws.into_iter().map(|draw| Instance::new(draw, scene_center)));
            batches.push(Batch { mesh, first, count: instances.len() as u32 - first });
        }
        batches
    }
}

/// Meshes on the GPU and the pipelines that draw them.
pub(super) struct Meshes {
    uploaded: BTreeMap<usize, Option<Uploaded>>,
    instances: Stream,
    shadow: wgpu::RenderPipeline,
    surface: wgpu::RenderPipeline,
    opaque: Sampled,
    mixed: Sampled,
    ghost_depth: Sampled,
    ghost: Sampled,
}

impl Meshes {
    pub(super) fn new(device: &wgpu::Device, globals: &wgpu::BindGroupLayout, light: &wgpu::BindGroupLayout) -> Self {
        use wgpu::CompareFunction::{Greater, GreaterEqual, Less};
        let source = concat!(
            include_str!("globals.wgsl"),
            include_str!("shading.wgsl"),
            include_str!("meshes.wgsl"),
            include_str!("bodies.wgsl")
        );
        let shader = shader(device, "meshes", source);
        let vertex = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let instance =
            wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Float32x4];
        let buffers = [
            wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &vertex,
            },
            wgpu::VertexBufferLayout {
                array_stride: size_of::<Instance>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &instance,
            },
        ];
        let small = Recipe {
            label: "surfaces",
            shader: &shader,
            vertex: "vs_body",
            fragment: "fs_depth_and_normal",
            layouts: &[globals],
            buffers: &buffers,
            topology: wgpu::PrimitiveTopology::TriangleList,
            color: Color::Replace,
            depth: Some((Greater, true)),
            samples: 1,
        };
        let shadow =
            Recipe { label: "shadow", vertex: "vs_shadow", fragment: "fs_shadow", depth: Some((Less, true)), ..small };
        let opaque = Recipe { label: "bodies", fragment: "fs_body", layouts: &[globals, light], ..small };
        let mixed = Recipe { label: "clear bodies", color: Color::Mix, depth: Some((Greater, false)), ..opaque };
        let ghost_depth = Recipe { label: "ghost depth", fragment: "fs_ghost_depth", color: Color::Nothing, ..opaque };
        let ghost = Recipe { label: "ghost", fragment: "fs_ghost", depth: Some((GreaterEqual, false)), ..mixed };
        Self {
            uploaded: BTreeMap::new(),
            instances: Stream::new("instances", wgpu::BufferUsages::VERTEX),
            shadow: shadow.make(device),
            surface: small.make(device),
            opaque: opaque.make_sampled(device),
            mixed: mixed.make_sampled(device),
            ghost_depth: ghost_depth.make_sampled(device),
            ghost: ghost.make_sampled(device),
        }
    }

    /// Uploads what is new, forgets what nobody holds, writes the instances.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame, plan: &Plan) {
        self.uploaded.retain(|_, entry| entry.as_ref().is_some_and(|uploaded| uploaded.mesh.strong_count() > 0));
        // Many draws of one mesh follow each other.
        let mut last = None;
        for draw in frame.bodies() {
            let key = Arc::as_ptr(&draw.mesh) as usize;
            if last != Some(key) {
                self.uploaded.entry(key).or_insert_with(|| Uploaded::new(device, &draw.mesh));
                last = Some(key);
            }
        }
        self.instances.write(device, queue, bytemuck::cast_slice(&plan.instances));
    }

    /// Draws depth from the light.
    pub(super) fn draw_shadow(&self, pass: &mut wgpu::RenderPass<'_>, batches: &[Batch]) {
        pass.set_pipeline(&self.shadow);
        self.draw(pass, batches);
    }

    /// Draws depth and normals.
    pub(super) fn draw_surface(&self, pass: &mut wgpu::RenderPass<'_>, batches: &[Batch]) {
        pass.set_pipeline(&self.surface);
        self.draw(pass, batches);
    }

    /// Draws opaque bodies.
    pub(super) fn draw_opaque(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool, batches: &[Batch]) {
        pass.set_pipeline(self.opaque.get(smooth));
        self.draw(pass, batches);
    }

    /// Draws see-through bodies.
    pub(super) fn draw_clear(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool, runs: &[Clear]) {
        for run in runs {
            match run {
                Clear::Plain(batch) => {
                    pass.set_pipeline(self.mixed.get(smooth));
                    self.draw(pass, std::slice::from_ref(batch));
                }
                Clear::Ghost(batches) => {
                    pass.set_pipeline(self.ghost_depth.get(smooth));
                    self.draw(pass, batches);
                    pass.set_pipeline(self.ghost.get(smooth));
                    self.draw(pass, batches);
                }
            }
        }
    }

    /// Draws the opaque bodies of fields.
    pub(super) fn draw_opaque_fields(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool, fields: &Fields) {
        pass.set_pipeline(self.opaque.get(smooth));
        fields.opaque().for_each(|(instances, batches)| self.draw_from(pass, instances, batches));
    }

    /// Draws the see-through bodies of fields.
    pub(super) fn draw_clear_fields(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool, fields: &Fields) {
        pass.set_pipeline(self.mixed.get(smooth));
        fields.clear().for_each(|(instances, batches)| self.draw_from(pass, instances, batches));
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, batches: &[Batch]) {
        if let Some(instances) = self.instances.buffer() {
            self.draw_from(pass, instances, batches);
        }
    }

    fn draw_from(&self, pass: &mut wgpu::RenderPass<'_>, instances: &wgpu::Buffer, batches: &[Batch]) {
        let stride = size_of::<Instance>() as u64;
        for batch in batches {
            let Some(Some(mesh)) = self.uploaded.get(&batch.mesh) else { continue };
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            let first = u64::from(batch.first) * stride;
            pass.set_vertex_buffer(1, instances.slice(first..first + u64::from(batch.count) * stride));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..mesh.index_count, 0, 0..batch.count);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::render::shapes;

    #[test]
    fn thousands_of_glyphs_of_one_mesh_are_one_draw_opaque_or_not() {
        let mesh = Arc::new(shapes::bead(0.01));
        for opacity in [1.0, 0.5] {
            let glyph = |k: u32| MeshDraw {
                mesh: mesh.clone(),
                X_WM: Isometry3::translation(f64::from(k % 70), f64::from(k / 70), 0.0),
                color: [1.0, 1.0, 1.0, opacity],
                surface: Surface::Unlit,
                pick_id: k,
            };
            let frame = Frame { meshes: (0..5000).map(glyph).collect(), ..Frame::default() };
            let plan = Plan::new(&frame, &Camera::default(), &Point3::origin(), &mut BoundsCache::default());
            assert_eq!((plan.unlit.len() + plan.clear.len(), plan.instances.len()), (1, 5000), "opacity {opacity}");
        }
    }
}
