//! The renderer: one picture from one frame.

use nalgebra::Point3;

use super::{
    BoundsCache, Cut, Frame, Target, View,
    fields::Fields,
    floor::Floor,
    globals::{Extent, Globals, Stage},
    gpu::{self, Stream},
    lighting::{Light, Lighting},
    lines::Lines,
    meshes::{Batch, Instance, Meshes, Plan, casts_shadow},
    points::Points,
};

/// How finely a picture is drawn. Places and colours are the same in all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// One sample per pixel, shadow and occlusion at a quarter of the picture's side: while something moves on a
    /// machine without a GPU, where it takes less than half of the time.
    Draft,
    /// Four samples per pixel, shadow and occlusion at half of the picture's side: for the window and the page.
    #[default]
    Live,
    /// Four samples per pixel, shadow and occlusion at the picture's size: for figures.
    Figure,
}

impl Quality {
    /// What an adapter can draw while something moves: a software one drafts. At rest, draw once more as
    /// [`Quality::Live`].
    pub fn while_moving(info: &wgpu::AdapterInfo) -> Self {
        if info.device_type == wgpu::DeviceType::Cpu { Self::Draft } else { Self::Live }
    }

    fn mask_fraction(self) -> f64 {
        match self {
            Self::Draft => 0.25,
            Self::Live => 0.5,
            Self::Figure => 1.0,
        }
    }

    /// Samples of blockers, shadow and occlusion per mask pixel. A finer mask is smoothed over fewer centimetres.
    pub(super) fn taps(self) -> [f32; 3] {
        match self {
            Self::Draft => [6.0, 8.0, 6.0],
            Self::Live => [8.0, 12.0, 10.0],
            Self::Figure => [24.0, 40.0, 24.0],
        }
    }
}

/// Draws frames. Keeps what was uploaded for as long as the frames' `Arc`s live.
pub struct Renderer {
    quality: Quality,
    bounds: BoundsCache,
    globals: Stream,
    globals_layout: wgpu::BindGroupLayout,
    globals_group: Option<wgpu::BindGroup>,
    light_layout: wgpu::BindGroupLayout,
    lighting: Lighting,
    floor: Floor,
    meshes: Meshes,
    fields: Fields,
    points: Points,
    lines: Lines,
    /// What the shadow map shows, so that it is drawn anew only when a caster has moved.
    shadowed: Option<Shadowed>,
}

/// What a shadow map shows.
struct Shadowed {
    light: Light,
    cut: Option<Cut>,
    batches: Vec<Batch>,
    casters: Vec<Instance>,
}

impl Renderer {
    /// Compiles the pipelines. The device needs no features and no more than WebGL2's limits; `queue` is only here to
    /// match [`Renderer::draw`].
    pub fn new(device: &wgpu::Device, _queue: &wgpu::Queue) -> Self {
        let globals_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("globals"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: std::num::NonZeroU64::new(size_of::<Globals>() as u64),
                },
                count: None,
            }],
        });
        let light_layout = gpu::textures_layout(device, "light", 2);
        Self {
            quality: Quality::default(),
            bounds: BoundsCache::default(),
            globals: Stream::new("globals", wgpu::BufferUsages::UNIFORM),
            lighting: Lighting::new(device, &globals_layout),
            floor: Floor::new(device, &globals_layout, &light_layout),
            meshes: Meshes::new(device, &globals_layout, &light_layout),
            fields: Fields::default(),
            points: Points::new(device, &globals_layout),
            lines: Lines::new(device, &globals_layout),
            globals_layout,
            globals_group: None,
            light_layout,
            shadowed: None,
        }
    }

    /// How finely the next pictures are lit.
    pub fn set_quality(&mut self, quality: Quality) {
        self.quality = quality;
    }

    /// Draws a frame into a target, at the target's size (`view.size_px` is for whoever makes the target), and
    /// submits it.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame,
        view: &View,
        target: &mut Target,
    ) {
        let size_px = target.size();
        let size = size_px.map(f64::from);
        let camera = &view.camera;
        // A round number of metres near the target: the grid stays in place and f32 has its full precision.
        let scene_center: Point3<f64> = camera.target.coords.map(|v| (v / 64.0).round() * 64.0).into();
        self.bounds.drop_unused();
        let plan = Plan::new(frame, camera, &scene_center, &mut self.bounds);
        let (light, extent) = self.fit(frame, view, &scene_center);
        let smooth = self.quality != Quality::Draft;
        let (color, drawn, masks) = target.parts(device, smooth, self.quality.mask_fraction());
        let mask = Some((masks.size, self.quality)).filter(|_| !plan.solid.is_empty());
        let globals = Globals::new(view, &view.theme.look(), &light, &scene_center, &extent, size_px, mask);
        let (buffer, grown) = self.globals.write(device, queue, bytemuck::bytes_of(&globals));
        if grown || self.globals_group.is_none() {
            self.globals_group = Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("globals"),
                layout: &self.globals_layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
            }));
        }
        let Some(globals) = &self.globals_group else { return };
        let stage = Stage { camera, scene_center, size, pixels_per_point: view.pixels_per_point };
        self.meshes.prepare(device, queue, frame, &plan);
        self.fields.prepare(device, queue, frame, camera, &scene_center);
        self.points.prepare(device, queue, frame, &stage);
        self.lines.prepare(device, queue, frame, &stage);

        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("view") });
        let same = self.shadowed.as_ref().is_some_and(|shadowed| {
            shadowed.light == light
                && shadowed.cut == view.cut
                && shadowed.batches == plan.solid
                && shadowed.casters == plan.casters()
        });
        if !same {
            let mut pass = self.lighting.shadow_pass(&mut encoder);
            pass.set_bind_group(0, globals, &[]);
            self.meshes.draw_shadow(&mut pass, &plan.solid);
            drop(pass);
            let (batches, casters) = (plan.solid.clone(), plan.casters().to_vec());
            self.shadowed = Some(Shadowed { light, cut: view.cut, batches, casters });
        }
        if mask.is_some() {
            let depth = Some((&masks.depth, 0.0));
            let mut pass = gpu::pass(&mut encoder, "surfaces", &masks.surfaces, None, wgpu::Color::WHITE, depth);
            pass.set_bind_group(0, globals, &[]);
            self.meshes.draw_surface(&mut pass, &plan.solid);
            if camera.eye().z > 0.0 {
                self.floor.draw_surface(&mut pass);
            }
            drop(pass);
            self.lighting.draw_mask(device, &mut encoder, globals, masks);
        }
        let light_group = gpu::bind_textures(device, &self.light_layout, &[&masks.smooth, self.lighting.shadow()]);
        let (samples, resolved) = drawn.samples.as_ref().map_or((color, None), |samples| (samples, Some(color)));
        let (clear, depth) = (wgpu::Color::TRANSPARENT, Some((&drawn.depth, 0.0)));
        let mut pass = gpu::pass(&mut encoder, "view", samples, resolved, clear, depth);
        pass.set_bind_group(0, globals, &[]);
        pass.set_bind_group(1, &light_group, &[]);
        if !view.transparent {
            self.floor.draw_background(&mut pass, smooth);
        }
        self.meshes.draw_opaque(&mut pass, smooth, &plan.solid);
        self.meshes.draw_opaque(&mut pass, smooth, &plan.unlit);
        self.meshes.draw_opaque_fields(&mut pass, smooth, &self.fields);
        self.floor.draw_visible(&mut pass, smooth);
        self.points.draw(&mut pass, smooth);
        self.lines.draw(&mut pass, smooth);
        pass.set_bind_group(1, &light_group, &[]);
        self.meshes.draw_clear(&mut pass, smooth, &plan.clear);
        // After the ghosts, which hide what is behind them and let through what is before.
        self.meshes.draw_clear_fields(&mut pass, smooth, &self.fields);
        drop(pass);
        queue.submit([encoder.finish()]);
    }

    /// The light and the extent of what casts shadow.
    fn fit(&mut self, frame: &Frame, view: &View, scene_center: &Point3<f64>) -> (Light, Extent) {
        let mut spheres = Vec::new();
        for draw in frame.meshes.iter().filter(|draw| casts_shadow(draw)) {
            if let Some(sphere) = self.bounds.sphere(&draw.mesh) {
                spheres.push((draw.X_WM * sphere.center, sphere.radius));
            }
        }
        let light = Light::fitted(spheres.iter().map(|(center, radius)| (center - scene_center.coords, *radius)));
        let mut depths_m = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut least, mut most) = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
        for (center, radius) in &spheres {
            let depth_m = view.camera.depth_m(center);
            depths_m = [depths_m[0].min(depth_m - radius), depths_m[1].max(depth_m + radius)];
            least = least.inf(&center.coords.add_scalar(-radius).into());
            most = most.sup(&center.coords.add_scalar(*radius).into());
        }
        if spheres.is_empty() {
            let depth_m = view.camera.distance_m;
            let extent = Extent { depths_m: [depth_m, depth_m], center: view.camera.target, radius_m: 1.0 };
            return (light, extent);
        }
        let extent =
            Extent { depths_m, center: nalgebra::center(&least, &most), radius_m: (most - least).norm() / 2.0 };
        (light, extent)
    }
}
