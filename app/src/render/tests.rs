//! Pictures drawn off-screen and questions about their pixels. Without an adapter they are skipped.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use endcomfort_core::mesh::Mesh;
use image::RgbaImage;
use nalgebra::{Isometry3, Point2, Point3, Vector3};

use super::*;

/// One device for all tests: it is slow to open. `None` (and a word on it) without an adapter.
fn offscreen() -> Option<MutexGuard<'static, Offscreen>> {
    static SHARED: OnceLock<Option<Mutex<Offscreen>>> = OnceLock::new();
    let shared = SHARED.get_or_init(|| match Offscreen::new() {
        Ok(offscreen) => Some(Mutex::new(offscreen)),
        Err(error) => {
            println!("skipped: {error}");
            None
        }
    });
    // A test that failed while it held the device leaves a usable one.
    shared.as_ref().map(|mutex| mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
}

fn body(mesh: Mesh, at: [f64; 3], color: [f32; 4], surface: Surface, pick_id: u32) -> MeshDraw {
    MeshDraw { mesh: Arc::new(mesh), X_WM: Isometry3::translation(at[0], at[1], at[2]), color, surface, pick_id }
}

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const BROWN: [f32; 4] = [0.36, 0.32, 0.29, 1.0];

fn table() -> MeshDraw {
    body(shapes::rounded_cuboid(Vector3::new(1.2, 1.6, 0.04), 0.006), [0.6, 0.0, 0.70], BROWN, Surface::Matte, 0)
}

/// From above, orthographic, 2 m high.
fn top_view(size_px: [u32; 2], theme: Theme) -> View {
    let mut camera =
        Camera { target: Point3::new(0.6, 0.0, 0.7), projection: Projection::Orthographic, ..Camera::default() };
    camera.look_from(Named::Top);
    camera.distance_m = 1.0 / (camera.fov_y_rad / 2.0).tan();
    View { grid: false, ..View::new(camera, theme, size_px) }
}

fn luminance(pixel: &image::Rgba<u8>) -> f64 {
    let [r, g, b, _] = pixel.0.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Mean luminance around the place where a point is seen.
fn brightness(image: &RgbaImage, view: &View, point: Point3<f64>) -> f64 {
    let px = view.camera.project(&point, view.size_px.map(f64::from)).unwrap();
    let mut sum = 0.0;
    for dy in 0..5 {
        for dx in 0..5 {
            sum += luminance(image.get_pixel(px.x as u32 + dx - 2, px.y as u32 + dy - 2));
        }
    }
    sum / 25.0
}

#[test]
fn an_unlit_cube_covers_the_pixels_it_should_in_exactly_its_colour() {
    let Some(mut offscreen) = offscreen() else { return };
    let cube = body(shapes::cuboid(Vector3::repeat(0.5)), [0.6, 0.0, 0.7], RED, Surface::Unlit, 1);
    let frame = Frame { meshes: vec![cube], ..Frame::default() };
    for theme in [Theme::Dark, Theme::Light] {
        // 200 px for 2 m: the cube is 50 × 50 px.
        let image = offscreen.render(&frame, &top_view([240, 200], theme)).unwrap();
        let red = image.pixels().filter(|p| p.0 == [255, 0, 0, 255]).count();
        assert!(red.abs_diff(2500) <= 10, "{red} red pixels in {theme:?}");
    }
}

#[test]
fn an_empty_frame_is_the_background_of_its_theme() {
    let Some(mut offscreen) = offscreen() else { return };
    for (theme, center) in [(Theme::Dark, [0x1b, 0x21, 0x29]), (Theme::Light, [0xfb, 0xfa, 0xf7])] {
        let image = offscreen.render(&Frame::default(), &top_view([200, 200], theme)).unwrap();
        let pixel = image.get_pixel(100, 84).0;
        for (channel, expected) in pixel.into_iter().zip(center) {
            // Dithering moves a channel by half a step.
            assert!(channel.abs_diff(expected) <= 1, "{pixel:?} in the middle of {theme:?}");
        }
        assert!(luminance(image.get_pixel(1, 199)) < luminance(image.get_pixel(100, 84)) - 5.0, "darker at the edge");
    }
}

#[test]
fn a_transparent_picture_is_clear_beside_the_bodies_and_solid_on_them() {
    let Some(mut offscreen) = offscreen() else { return };
    let cube = body(shapes::cuboid(Vector3::repeat(0.5)), [0.6, 0.0, 0.7], RED, Surface::Unlit, 1);
    let frame = Frame { meshes: vec![cube], ..Frame::default() };
    let view = View { transparent: true, ..top_view([240, 200], Theme::Light) };
    let image = offscreen.render(&frame, &view).unwrap();
    assert_eq!(image.get_pixel(2, 2).0, [0, 0, 0, 0]);
    assert_eq!(image.get_pixel(237, 197).0[3], 0);
    assert_eq!(image.get_pixel(120, 100).0, [255, 0, 0, 255]);
}

#[test]
fn a_box_darkens_the_table_where_its_shadow_falls_and_only_there() {
    let Some(mut offscreen) = offscreen() else { return };
    let view = top_view([300, 300], Theme::Light);
    let bare = Frame { meshes: vec![table()], ..Frame::default() };
    let mut with_box = bare.clone();
    let size = Vector3::new(0.12, 0.12, 0.3);
    with_box.meshes.push(body(shapes::cuboid(size), [0.6, 0.0, 0.87], BROWN, Surface::Satin, 1));
    let before = offscreen.render(&bare, &view).unwrap();
    let after = offscreen.render(&with_box, &view).unwrap();
    // The key light comes from +x and −y, so the shadow of the top (0.3 m up) falls towards −x and +y.
    let shaded = Point3::new(0.53, 0.09, 0.72);
    let open = Point3::new(0.9, -0.4, 0.72);
    let (was, is) = (brightness(&before, &view, shaded), brightness(&after, &view, shaded));
    assert!(is < 0.8 * was, "shadow: {was} before, {is} after");
    let (was, is) = (brightness(&before, &view, open), brightness(&after, &view, open));
    assert!((is - was).abs() < 1.5, "in the open: {was} before, {is} after");
}

#[test]
fn a_lit_plane_is_even_so_there_is_no_shadow_acne() {
    let Some(mut offscreen) = offscreen() else { return };
    let frame = Frame { meshes: vec![table()], ..Frame::default() };
    for quality in [Quality::Draft, Quality::Live, Quality::Figure] {
        offscreen.set_quality(quality);
        let image = offscreen.render(&frame, &top_view([300, 300], Theme::Light)).unwrap();
        let values: Vec<f64> = (100..200)
            .flat_map(|y| (100..200).map(move |x| (x, y)))
            .map(|(x, y)| luminance(image.get_pixel(x, y)))
            .collect();
        let spread = values.iter().copied().fold(0.0, f64::max) - values.iter().copied().fold(255.0, f64::min);
        // One step of dithering either way.
        assert!(spread <= 2.5, "{spread} levels on an even plane with {quality:?}");
    }
    offscreen.set_quality(Quality::Figure);
}

#[test]
fn picking_agrees_with_the_picture() {
    let Some(mut offscreen) = offscreen() else { return };
    // Each body's colour is its pick id.
    let coded = |id: u8| [f32::from(id) / 255.0, 0.0, 1.0, 1.0];
    let frame = Frame {
        meshes: vec![
            body(shapes::sphere(0.2), [0.6, -0.2, 0.8], coded(40), Surface::Unlit, 40),
            body(shapes::cuboid(Vector3::new(0.3, 0.2, 0.5)), [0.3, 0.1, 0.8], coded(90), Surface::Unlit, 90),
            body(shapes::ring(0.2, 0.03), [0.7, 0.2, 0.9], coded(180), Surface::Unlit, 180),
        ],
        ..Frame::default()
    };
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let camera = Camera { projection, target: Point3::new(0.5, 0.0, 0.8), distance_m: 1.5, ..Camera::default() };
        let view = View { grid: false, ..View::new(camera, Theme::Dark, [160, 120]) };
        let image = offscreen.render(&frame, &view).unwrap();
        let mut picker = Picker::default();
        let (mut different, mut hits) = (0, 0);
        for (x, y, pixel) in image.enumerate_pixels() {
            let ray = camera.ray(Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), [160.0, 120.0]);
            let picked = picker.pick(&frame, ray, None).map_or(0, |hit| hit.pick_id);
            hits += usize::from(picked != 0);
            let [r, _, b, _] = pixel.0;
            let drawn = match b {
                255 => u32::from(r),
                // Mixed edges count as either.
                52..255 => picked,
                _ => 0,
            };
            // Where two bodies meet, the red of the mixed pixel is between theirs.
            different += usize::from(drawn != picked && [0, 40, 90, 180].contains(&drawn));
        }
        assert!(hits > 2000, "{hits} pixels hit");
        assert!(different <= 10, "{different} pixels differ in {projection:?}");
    }
}

#[test]
fn a_field_looks_like_its_bodies_one_by_one_and_turns_with_the_view() {
    let Some(mut offscreen) = offscreen() else { return };
    let cube = Arc::new(shapes::cuboid(Vector3::repeat(0.1)));
    for opacity in [1.0, 0.4] {
        let at = |k: u32| Isometry3::translation(0.3 + 0.12 * f64::from(k % 6), 0.12 * f64::from(k / 6) - 0.3, 0.7);
        let color = |k: u32| [0.03 * k as f32, 0.8 - 0.02 * k as f32, 0.2, opacity];
        let cell = |k: u32| MeshDraw {
            mesh: cube.clone(),
            X_WM: at(k),
            color: color(k),
            surface: Surface::Facet,
            pick_id: k + 1,
        };
        let bodies: Vec<MeshDraw> = (0..30).map(cell).collect();
        let one_by_one = Frame { meshes: bodies.clone(), ..Frame::default() };
        let field = Frame { fields: vec![Arc::new(bodies)], ..Frame::default() };
        for yaw_rad in [0.3, 2.2, 4.0] {
            let camera = Camera { yaw_rad, pitch_rad: 0.4, distance_m: 2.5, ..Camera::default() };
            let view = View { transparent: true, ..View::new(camera, Theme::Dark, [160, 120]) };
            let (a, b) = (offscreen.render(&one_by_one, &view).unwrap(), offscreen.render(&field, &view).unwrap());
            let far = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 2;
            let different = a.as_raw().iter().zip(b.as_raw()).filter(|pair| far(*pair)).count();
            assert!(a.pixels().any(|pixel| pixel.0[3] > 0), "something is seen");
            // Cells of one depth may swap.
            assert!(different < 160 * 120 * 4 / 200, "{different} bytes differ at opacity {opacity}, yaw {yaw_rad}");
            let ray = camera.ray(Point2::new(80.0, 60.0), [160.0, 120.0]);
            let hits =
                [&one_by_one, &field].map(|frame| Picker::default().pick(frame, ray, None).map(|hit| hit.pick_id));
            assert_eq!(hits[0], hits[1]);
        }
    }
}

#[test]
fn points_and_lines_have_the_size_they_are_given() {
    let Some(mut offscreen) = offscreen() else { return };
    let view = View { pixels_per_point: 2.0, transparent: true, ..top_view([200, 200], Theme::Dark) };
    let at = |x: f64, y: f64| Point3::new(0.6 + x, y, 0.7);
    // 100 px per metre: a disc of 0.4 m has 1257 px, a line of 1 m and 5 logical pixels has 1000 px and two round ends.
    let cloud =
        PointsDraw { points: Arc::new(vec![at(0.5, 0.0)]), colors: Arc::new(vec![bytes_of(RED)]), diameter_m: 0.4 };
    let line = LineDraw::new(vec![at(-0.5, -0.5), at(-0.5, 0.0), at(-0.5, 0.5)], [0.0, 1.0, 0.0, 1.0], 5.0);
    let dashed = LineDraw::new(vec![at(-0.8, -0.5), at(-0.8, 0.5)], [0.0, 0.0, 1.0, 1.0], 2.0).dashed(5.0);
    let frame = Frame { points: vec![cloud], lines: vec![line, dashed], ..Frame::default() };
    let image = offscreen.render(&frame, &view).unwrap();
    let area = |channel: usize| {
        let covered = image.pixels().map(|p| f64::from(p.0[channel]) / 255.0 * f64::from(p.0[3]) / 255.0);
        covered.sum::<f64>()
    };
    assert!((area(0) - 1257.0).abs() < 30.0, "disc covers {}", area(0));
    let expected = 1000.0 + 25.0 * std::f64::consts::PI;
    assert!((area(1) - expected).abs() < 40.0, "line covers {}", area(1));
    // Half of 100 × 4 px.
    assert!((area(2) - 200.0).abs() < 30.0, "dashes cover {}", area(2));
}

#[test]
fn data_that_is_not_finite_or_does_not_fit_draws_what_is_left() {
    let Some(mut offscreen) = offscreen() else { return };
    let mut broken = Mesh { positions: vec![Point3::origin(); 3], ..Mesh::default() };
    broken.triangles = vec![[0, 1, 2], [0, 1, 77]];
    let cloud = PointsDraw {
        points: Arc::new(vec![Point3::new(f64::NAN, 0.0, 0.0), Point3::new(0.6, 0.0, 0.7)]),
        colors: Arc::new(Vec::new()),
        diameter_m: 0.2,
    };
    let nowhere = LineDraw::new(vec![Point3::new(f64::INFINITY, 0.0, 0.0), Point3::origin()], RED, f32::NAN);
    let frame = Frame {
        meshes: vec![
            body(broken, [0.6, 0.0, 0.7], RED, Surface::Satin, 1),
            body(Mesh::default(), [0.6, 0.0, 0.7], RED, Surface::Ghost, 1),
            body(shapes::sphere(0.3), [f64::NAN, 0.0, 0.7], RED, Surface::Satin, 1),
        ],
        points: vec![cloud],
        lines: vec![nowhere],
        ..Frame::default()
    };
    let image = offscreen.render(&frame, &top_view([100, 100], Theme::Light)).unwrap();
    assert_eq!(image.get_pixel(50, 50).0, [128, 128, 128, 255], "the point that is left, in grey");
}

#[test]
fn ghosts_let_the_background_through_and_hide_their_own_inside() {
    let Some(mut offscreen) = offscreen() else { return };
    let ghost = |radius: f64| body(shapes::sphere(radius), [0.6, 0.0, 0.7], [1.0, 0.7, 0.2, 0.5], Surface::Ghost, 1);
    let view = View { transparent: true, ..top_view([100, 100], Theme::Dark) };
    let single = Frame { meshes: vec![ghost(0.5)], ..Frame::default() };
    let nested = Frame { meshes: vec![ghost(0.5), ghost(0.3)], ..Frame::default() };
    let one = offscreen.render(&single, &view).unwrap();
    let two = offscreen.render(&nested, &view).unwrap();
    let (middle, rim) = (one.get_pixel(50, 50).0[3], one.get_pixel(27, 50).0[3]);
    assert!((30..200).contains(&middle), "middle has alpha {middle}");
    assert!(rim > middle + 20, "rim {rim}, middle {middle}");
    assert_eq!(one, two, "an inner part of the same ghost is not seen");
}

#[test]
fn sizes_beyond_the_limit_are_refused_by_name() {
    let Some(mut offscreen) = offscreen() else { return };
    for size_px in [[0, 10], [10, MAX_SIDE_PX + 1]] {
        let error = offscreen.render(&Frame::default(), &top_view(size_px, Theme::Dark)).unwrap_err();
        assert!(matches!(error, OffscreenError::Size { .. }), "{error}");
    }
}

/// Every shader, as its module is put together.
const SHADERS: [(&str, &str); 5] = [
    ("lighting", concat!(include_str!("globals.wgsl"), include_str!("lighting.wgsl"))),
    ("floor", concat!(include_str!("globals.wgsl"), include_str!("shading.wgsl"), include_str!("floor.wgsl"))),
    (
        "meshes",
        concat!(
            include_str!("globals.wgsl"),
            include_str!("shading.wgsl"),
            include_str!("meshes.wgsl"),
            include_str!("bodies.wgsl")
        ),
    ),
    ("points", concat!(include_str!("globals.wgsl"), include_str!("points.wgsl"))),
    ("lines", concat!(include_str!("globals.wgsl"), include_str!("lines.wgsl"))),
];

#[test]
fn every_shader_can_be_said_in_the_language_of_webgl2() {
    use wgpu::naga::{back::glsl, front::wgsl, proc::BoundsCheckPolicies, valid};
    for (name, source) in SHADERS {
        let module = wgsl::parse_str(source).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        // Without any capability: nothing beyond WebGPU's core.
        let mut validator = valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::empty());
        let info =
            validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        let options = glsl::Options {
            version: glsl::Version::Embedded { version: 300, is_webgl: true },
            writer_flags: glsl::WriterFlags::ADJUST_COORDINATE_SPACE,
            ..glsl::Options::default()
        };
        for entry in &module.entry_points {
            let pipeline =
                glsl::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone(), multiview: None };
            let mut text = String::new();
            glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, BoundsCheckPolicies::default())
                .and_then(|mut writer| writer.write())
                .unwrap_or_else(|error| panic!("{name}, {}: {error}", entry.name));
            assert!(text.starts_with("#version 300 es"), "{name}, {}", entry.name);
        }
    }
}
