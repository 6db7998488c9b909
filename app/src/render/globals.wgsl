// What every shader knows. Positions are relative to the scene centre, in metres; colours with "srgb" in their name
// are display values, all others are linear.

struct Globals {
    clip_from_world: mat4x4<f32>,
    eye: vec4<f32>,          // position; w: 1 in perspective, 0 orthographic
    right: vec4<f32>,        // axis; w: half width of the picture (at depth 1 in perspective)
    up: vec4<f32>,           // axis; w: half height likewise
    forward: vec4<f32>,      // axis; w: pixels per logical pixel
    size: vec4<f32>,         // picture in pixels, and its inverse
    mask_size: vec4<f32>,    // mask in pixels, and mask pixels per picture pixel
    depth: vec4<f32>,        // first depth and range of the mask; factor and offset that lift lines off surfaces
    light_x: vec4<f32>,      // axes of the light, w: offset in metres
    light_y: vec4<f32>,
    light_z: vec4<f32>,      // the way the light travels
    light_size: vec4<f32>,   // extent of the shadow map in metres (x, y, depth), and its side in texels
    key: vec4<f32>,          // colour; w: tangent of the light's half angle
    fill_direction: vec4<f32>,
    fill: vec4<f32>,
    sky: vec4<f32>,
    ground: vec4<f32>,
    srgb_background_center: vec4<f32>,
    srgb_background_edge: vec4<f32>,
    srgb_grid: vec4<f32>,    // w: opacity, 0 without a grid
    floor: vec4<f32>,        // centre x, y, height, radius at which the floor has faded
    taps: vec4<f32>,         // of blockers, shadow and occlusion
    options: vec4<f32>,      // 1 if transparent; opacity of shadow on the floor; occlusion radius in metres; 1 if masked
    cut: vec4<f32>,          // plane: what is on its negative side is not drawn
}

@group(0) @binding(0) var<uniform> globals: Globals;

const TAU: f32 = 6.2831853;
const GOLDEN_ANGLE: f32 = 2.3999632;

fn linear_from_srgb(srgb: vec3<f32>) -> vec3<f32> {
    let low = srgb / 12.92;
    let high = pow((srgb + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, low, srgb <= vec3<f32>(0.04045));
}

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let low = linear * 12.92;
    let high = 1.055 * pow(max(linear, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3<f32>(0.0031308));
}

// Interleaved gradient noise (Jimenez 2014) in [0, 1).
fn noise(pixel: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// Half a step of an eight-bit channel up or down, so that gradients do not band.
fn dither(pixel: vec2<f32>) -> f32 {
    return (noise(pixel) - 0.5) / 255.0;
}

// How far a place lies on the side of the cut that stays.
fn side_of_cut(world: vec3<f32>) -> f32 {
    return dot(globals.cut.xyz, world) + globals.cut.w;
}

fn depth_of(world: vec3<f32>) -> f32 {
    return dot(world - globals.eye.xyz, globals.forward.xyz);
}

// Half of the picture's height in metres at a depth: lengths that should look alike are fractions of it.
fn half_height_at(depth: f32) -> f32 {
    return globals.up.w * mix(1.0, depth, globals.eye.w);
}

// Point i of n, evenly over a disc of radius 1.
fn disc(i: i32, n: i32, turn: f32) -> vec2<f32> {
    let radius = sqrt((f32(i) + 0.5) / f32(n));
    let angle = f32(i) * GOLDEN_ANGLE + turn;
    return radius * vec2<f32>(cos(angle), sin(angle));
}

// Numbers in [0, 1] in eight-bit channels.
fn pack2(value: f32) -> vec2<f32> {
    let whole = floor(clamp(value, 0.0, 1.0) * 65535.0 + 0.5);
    let high = floor(whole / 256.0);
    return vec2<f32>(high, whole - high * 256.0) / 255.0;
}

fn unpack2(packed: vec2<f32>) -> f32 {
    let bytes = floor(packed * 255.0 + 0.5);
    return (bytes.x * 256.0 + bytes.y) / 65535.0;
}

fn pack3(value: f32) -> vec3<f32> {
    let whole = floor(clamp(value, 0.0, 1.0) * 16777215.0);
    let high = floor(whole / 65536.0);
    let rest = whole - high * 65536.0;
    let middle = floor(rest / 256.0);
    return vec3<f32>(high, middle, rest - middle * 256.0) / 255.0;
}

fn unpack3(packed: vec3<f32>) -> f32 {
    let bytes = floor(packed * 255.0 + 0.5);
    return (bytes.x * 65536.0 + bytes.y * 256.0 + bytes.z) / 16777215.0;
}

// Unit vectors on an unfolded octahedron, in [0, 1]².
fn pack_normal(n: vec3<f32>) -> vec2<f32> {
    let flat = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let signs = select(vec2<f32>(-1.0), vec2<f32>(1.0), flat >= vec2<f32>(0.0));
    let folded = select(flat, (1.0 - abs(flat.yx)) * signs, n.z < 0.0);
    return folded * 0.5 + 0.5;
}

fn unpack_normal(packed: vec2<f32>) -> vec3<f32> {
    let flat = packed * 2.0 - 1.0;
    let z = 1.0 - abs(flat.x) - abs(flat.y);
    let signs = select(vec2<f32>(-1.0), vec2<f32>(1.0), flat >= vec2<f32>(0.0));
    let unfolded = select(flat, (1.0 - abs(flat.yx)) * signs, z < 0.0);
    return normalize(vec3<f32>(unfolded, z));
}

// Metres in the light's frame: across, along and away from the light.
fn light_from_world(world: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(globals.light_x.xyz, world) + globals.light_x.w,
        dot(globals.light_y.xyz, world) + globals.light_y.w,
        dot(globals.light_z.xyz, world) + globals.light_z.w,
    );
}
