// How surfaces take light. Needs the mask and the shadow map.

@group(1) @binding(0) var mask: texture_2d<f32>;
@group(1) @binding(1) var shadow_map: texture_2d<f32>;

// Occlusion and key light at a picture pixel whose surface lies at a depth, from the four mask pixels around it that
// see about the same depth.
fn masked_light(pixel: vec2<f32>, depth: f32) -> vec2<f32> {
    let at = pixel * globals.mask_size.zw;
    let base = vec2<i32>(floor(at));
    let part = fract(at);
    let last = vec2<i32>(globals.mask_size.xy) - 1;
    let tolerance = 0.025 * half_height_at(depth);
    var sum = vec2<f32>(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1);
        let stored = textureLoad(mask, clamp(base + corner, vec2<i32>(0), last), 0);
        let apart = abs(globals.depth.x + unpack2(stored.zw) * globals.depth.y - depth) / tolerance;
        let near = mix(1.0 - part, part, vec2<f32>(corner));
        let weight = (near.x * near.y + 1e-3) * (max(1.0 - apart, 0.0) + 1e-4);
        sum += stored.xy * weight;
        weights += weight;
    }
    return sum / weights;
}

// Key light without a mask, for bodies that one can see through.
fn simple_key_light(world: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>) -> f32 {
    let texel_m = max(globals.light_size.x, globals.light_size.y) / globals.light_size.w;
    let here = light_from_world(world + normal * (texel_m * 3.0));
    let turn = noise(pixel) * TAU;
    var lit = 0.0;
    for (var i = 0; i < 4; i++) {
        let at = (here.xy + disc(i, 4, turn) * texel_m * 4.0) / globals.light_size.xy;
        let texel = clamp(at, vec2<f32>(0.0), vec2<f32>(0.99999)) * globals.light_size.w;
        let stored = textureLoad(shadow_map, vec2<i32>(texel), 0);
        let blocked = stored.a < 0.5 && unpack3(stored.rgb) * globals.light_size.z < here.z - texel_m * 6.0;
        lit += select(0.25, 0.0, blocked);
    }
    return lit;
}

// Unit vector towards the eye.
fn toward_eye(world: vec3<f32>) -> vec3<f32> {
    return normalize(mix(-globals.forward.xyz, globals.eye.xyz - world, globals.eye.w));
}

// GGX distribution and visibility (Walter et al. 2007; Karis 2013), times the cosine to the light.
fn highlight(n: vec3<f32>, v: vec3<f32>, l: vec3<f32>, roughness: f32) -> f32 {
    let h = normalize(v + l);
    let n_l = max(dot(n, l), 0.0);
    let n_v = max(dot(n, v), 1e-3);
    let n_h = max(dot(n, h), 0.0);
    let alpha = roughness * roughness;
    let alpha2 = alpha * alpha;
    let spread = n_h * n_h * (alpha2 - 1.0) + 1.0;
    let k = alpha * 0.5;
    let visible = 0.25 / ((n_l * (1.0 - k) + k) * (n_v * (1.0 - k) + k));
    return alpha2 / (0.5 * TAU * spread * spread) * visible * n_l;
}

fn fifth_power(x: f32) -> f32 {
    let x2 = x * x;
    return x2 * x2 * x;
}

// The room that surfaces mirror: ground below, sky above, and two long soft lamps.
fn room(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let blur = 0.12 + roughness;
    let base = mix(globals.ground.rgb, globals.sky.rgb * 1.3, smoothstep(-blur, blur, direction.z));
    let lamp = smoothstep(0.80 - 0.5 * roughness, 0.93, dot(direction, globals.fill_direction.xyz));
    let key = smoothstep(0.80 - 0.5 * roughness, 0.97, -dot(direction, globals.light_z.xyz));
    return base + (globals.fill.rgb * 3.5 * lamp + globals.key.rgb * 0.6 * key) * (1.0 - 0.7 * roughness);
}

// Light from a surface towards the eye. `open` is 1 without occlusion, `lit` is 1 in the key light.
fn shade(albedo: vec3<f32>, n: vec3<f32>, v: vec3<f32>, roughness: f32, gloss: f32, open: f32, lit: f32) -> vec3<f32> {
    let l = -globals.light_z.xyz;
    let wrapped = dot(n, globals.fill_direction.xyz) * 0.5 + 0.5;
    let ambient = mix(globals.ground.rgb, globals.sky.rgb, n.z * 0.5 + 0.5) + globals.fill.rgb * wrapped * wrapped;
    // Light that bounces between near surfaces keeps their colour (Jimenez et al. 2016, simplified).
    let bounced = mix(vec3<f32>(open), vec3<f32>(1.0), albedo * (1.0 - open) * 0.5);
    let key = globals.key.rgb * lit;
    var color = albedo * (key * max(dot(n, l), 0.0) + ambient * bounced);

    let n_v = max(dot(n, v), 0.0);
    let edge = gloss + (max(1.0 - roughness, gloss) - gloss) * fifth_power(1.0 - n_v);
    color += key * highlight(n, v, l, roughness) * gloss * 2.0;
    color += room(reflect(-v, n), roughness) * edge * open;
    let rim = fifth_power(1.0 - n_v) * (n.z * 0.35 + 0.65);
    color += globals.fill.rgb * rim * 0.9 * open * (1.0 - 0.6 * roughness);
    return color;
}

// Compresses only what is brighter than 0.8 and keeps its hue (after the Khronos neutral tone mapper, 2024).
fn tone(color: vec3<f32>) -> vec3<f32> {
    let start = 0.8;
    let peak = max(color.r, max(color.g, color.b));
    if peak <= start {
        return color;
    }
    let room_above = 1.0 - start;
    let new_peak = 1.0 - room_above * room_above / (peak + room_above - start);
    let whiten = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3<f32>(new_peak), whiten);
}
