// Soft shadow and ambient occlusion, computed on a small picture of depths and normals and then smoothed.
// The mask holds: occlusion (1 is open), light from the key (1 is lit), depth in two bytes.

@group(1) @binding(0) var first: texture_2d<f32>;  // depths and normals; for smoothing, the rough mask
@group(1) @binding(1) var second: texture_2d<f32>; // shadow map

// Widest half-shadow in metres: beyond it, more blur would need more taps.
const WIDEST_M: f32 = 0.06;

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(corner * 4.0 - 1.0, 0.5, 1.0);
}

// The point that mask pixel `pixel` (its centre, in pixels) sees at a depth.
fn world_at(pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    let screen = (pixel / globals.mask_size.xy * 2.0 - 1.0) * vec2<f32>(globals.right.w, -globals.up.w);
    let spread = mix(1.0, depth, globals.eye.w);
    return globals.eye.xyz + globals.forward.xyz * depth
        + (globals.right.xyz * screen.x + globals.up.xyz * screen.y) * spread;
}

fn depth_at(pixel: vec2<i32>) -> f32 {
    let last = vec2<i32>(globals.mask_size.xy) - 1;
    let stored = textureLoad(first, clamp(pixel, vec2<i32>(0), last), 0);
    return globals.depth.x + unpack2(stored.xy) * globals.depth.y;
}

fn blocker_depth(at_m: vec2<f32>) -> f32 {
    let side = globals.light_size.w;
    let texel = clamp(at_m / globals.light_size.xy, vec2<f32>(0.0), vec2<f32>(0.99999)) * side;
    let stored = textureLoad(second, vec2<i32>(texel), 0);
    return select(unpack3(stored.rgb) * globals.light_size.z, 1e9, stored.a > 0.5);
}

// Percentage-closer soft shadows (Fernando 2005): the half-shadow grows with the distance to what casts it.
fn key_light(world: vec3<f32>, normal: vec3<f32>, turn: f32) -> f32 {
    let toward = -dot(normal, globals.light_z.xyz);
    if toward <= 0.0 {
        return 0.0;
    }
    let texel_m = max(globals.light_size.x, globals.light_size.y) / globals.light_size.w;
    let lifted = world + normal * (texel_m * 1.5);
    let here = light_from_world(lifted);
    if any(here.xy < vec2<f32>(0.0)) || any(here.xy > globals.light_size.xy) {
        return 1.0;
    }
    // How the receiver's own plane falls away from the light, so that it does not shade itself.
    let across = vec2<f32>(dot(normal, globals.light_x.xyz), dot(normal, globals.light_y.xyz));
    let slope = clamp(across / max(toward, 0.05), vec2<f32>(-4.0), vec2<f32>(4.0));
    let bias = texel_m * (0.7 + 0.7 * (abs(slope.x) + abs(slope.y)));

    let blocker_taps = i32(globals.taps.x);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < blocker_taps; i++) {
        let offset = disc(i, blocker_taps, turn) * WIDEST_M;
        let blocker = blocker_depth(here.xy + offset);
        if blocker < here.z + dot(slope, offset) - bias - 0.004 {
            sum += blocker;
            count += 1.0;
        }
    }
    var width = texel_m * 2.0;
    if count > 0.0 {
        width = clamp((here.z - sum / count) * globals.key.w, texel_m * 2.0, WIDEST_M);
    }
    let shadow_taps = i32(globals.taps.y);
    var lit = 0.0;
    for (var i = 0; i < shadow_taps; i++) {
        let offset = disc(i, shadow_taps, turn + 1.0) * width;
        let blocker = blocker_depth(here.xy + offset);
        lit += select(0.0, 1.0, blocker >= here.z + dot(slope, offset) - bias);
    }
    return lit / globals.taps.y;
}

// Scalable ambient obscurance (McGuire, Mara and Luebke 2012).
fn occlusion(pixel: vec2<f32>, world: vec3<f32>, normal: vec3<f32>, depth: f32, turn: f32) -> f32 {
    let radius = globals.options.z;
    let half_height = half_height_at(depth);
    let radius_px = clamp(radius * globals.mask_size.y * 0.5 / half_height, 2.0, 0.15 * globals.mask_size.y);
    let least = 0.004 * half_height;
    let taps = i32(globals.taps.z);
    var sum = 0.0;
    for (var i = 0; i < taps; i++) {
        let at = vec2<i32>(floor(pixel + disc(i, taps, turn) * radius_px));
        let toward = world_at(vec2<f32>(at) + 0.5, depth_at(at)) - world;
        let squared = dot(toward, toward);
        let falloff = max(1.0 - squared / (radius * radius), 0.0);
        sum += falloff * falloff * falloff * max(dot(toward, normal) - least, 0.0) / (squared + 1e-5) * radius;
    }
    return clamp(1.0 - 2.8 * sum / globals.taps.z, 0.0, 1.0);
}

@fragment
fn fs_mask(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let stored = textureLoad(first, vec2<i32>(position.xy), 0);
    let fraction = unpack2(stored.xy);
    if fraction >= 1.0 {
        return vec4<f32>(1.0);
    }
    let depth = globals.depth.x + fraction * globals.depth.y;
    let world = world_at(position.xy, depth);
    let normal = unpack_normal(stored.zw);
    // Sixteen turns in a square of 4 × 4 pixels, which the smoothing averages exactly.
    let cell = vec2<u32>(position.xy) & vec2<u32>(3u);
    let turn = f32((cell.x * 5u + cell.y * 7u + (cell.x >> 1u) * 2u + (cell.y & 1u) * cell.x * 3u) % 16u) * (TAU / 16.0);
    let lit = key_light(world, normal, turn);
    let open = occlusion(position.xy, world, normal, depth, turn);
    return vec4<f32>(open, lit, stored.xy);
}

// Mean of 4 × 4 pixels of about the same depth. The result stands for the upper left corner of its pixel.
@fragment
fn fs_smooth(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let last = vec2<i32>(globals.mask_size.xy) - 1;
    let center = textureLoad(first, pixel, 0);
    let center_depth = globals.depth.x + unpack2(center.zw) * globals.depth.y;
    let tolerance = 0.04 * half_height_at(center_depth);
    var sum = center.xy * 1e-3;
    var weights = 1e-3;
    for (var y = -2; y < 2; y++) {
        for (var x = -2; x < 2; x++) {
            let tap = textureLoad(first, clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last), 0);
            let apart = abs(globals.depth.x + unpack2(tap.zw) * globals.depth.y - center_depth);
            let weight = max(1.0 - apart / tolerance, 0.0);
            sum += tap.xy * weight;
            weights += weight;
        }
    }
    return vec4<f32>(sum / weights, center.zw);
}
