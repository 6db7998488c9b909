// Clouds: each point a small polygon that faces the eye.

struct Cloud {
    offset: vec4<f32>, // from the cloud's centre to the scene's; w: radius in metres
    shape: vec4<f32>,  // corners; least radius in pixels
}

@group(1) @binding(0) var<uniform> cloud: Cloud;

struct Splat {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) srgb: vec4<f32>,
}

@vertex
fn vs_point(
    @builtin(vertex_index) index: u32,
    @location(0) point: vec3<f32>,
    @location(1) srgb: vec4<f32>,
) -> Splat {
    let clip = globals.clip_from_world * vec4<f32>(point + cloud.offset.xyz, 1.0);
    // The strip goes to and fro between the two sides of the polygon.
    let corners = cloud.shape.x;
    let step = f32((index + 1u) >> 1u);
    let corner = select(-step, step, (index & 1u) == 1u);
    let angle = (corner + 0.5) * TAU / corners;
    let radius_px = max(cloud.offset.w * globals.size.y * 0.5 / (globals.up.w * clip.w), cloud.shape.y);
    var out: Splat;
    let offset = vec2<f32>(cos(angle), sin(angle)) * radius_px * 2.0 * globals.size.zw;
    out.position = vec4<f32>(clip.xy + offset * clip.w, clip.zw);
    out.srgb = srgb;
    return out;
}

@fragment
fn fs_point(in: Splat) -> @location(0) vec4<f32> {
    return vec4<f32>(in.srgb.rgb * in.srgb.a, in.srgb.a);
}
