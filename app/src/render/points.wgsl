// Clouds: each point a small polygon that faces the eye.

struct Cloud {
    offset: vec4<f32>, // from the cloud's centre to the scene's; w: radius in metres
    shape: vec4<f32>,  // corners; least radius in pixels
}

@group(1) @binding(0) var<uniform> cloud: Cloud;
@group(2) @binding(0) var points: texture_2d<u32>; // three coordinates in metres and a colour, row by row

struct Splat {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) srgb: vec4<f32>,
}

@vertex
fn vs_point(@builtin(vertex_index) index: u32) -> Splat {
    let corners = u32(cloud.shape.x);
    let each = 3u * (corners - 2u);
    let number = index / each;
    let row = textureDimensions(points).x;
    let texel = textureLoad(points, vec2<u32>(number % row, number / row), 0);
    let point = bitcast<vec3<f32>>(texel.xyz);
    let clip = globals.clip_from_world * vec4<f32>(point + cloud.offset.xyz, 1.0);
    // A fan of triangles about the first corner.
    let vertex = index % each;
    let corner = select(vertex / 3u + vertex % 3u, 0u, vertex % 3u == 0u);
    let angle = (f32(corner) + 0.5) * TAU / cloud.shape.x;
    let radius_px = max(cloud.offset.w * globals.size.y * 0.5 / (globals.up.w * clip.w), cloud.shape.y);
    var out: Splat;
    let offset = vec2<f32>(cos(angle), sin(angle)) * radius_px * 2.0 * globals.size.zw;
    out.position = vec4<f32>(clip.xy + offset * clip.w, clip.zw);
    if side_of_cut(point + cloud.offset.xyz) < 0.0 {
        out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    out.srgb = unpack4x8unorm(texel.w);
    return out;
}

@fragment
fn fs_point(in: Splat) -> @location(0) vec4<f32> {
    return vec4<f32>(in.srgb.rgb * in.srgb.a, in.srgb.a);
}
