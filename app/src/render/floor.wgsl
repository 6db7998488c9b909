// The background and the floor, which is only its shadow and its grid.

struct Floor {
    @builtin(position) position: vec4<f32>,
    @location(0) world: vec3<f32>,
}

@vertex
fn vs_background(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(corner * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn fs_background(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let from_center = (position.xy * globals.size.zw - vec2<f32>(0.5, 0.42)) * vec2<f32>(1.25, 1.35);
    let t = smoothstep(0.0, 1.0, length(from_center));
    let color = mix(globals.srgb_background_center.rgb, globals.srgb_background_edge.rgb, t);
    return vec4<f32>(color + dither(position.xy), 1.0);
}

@vertex
fn vs_floor(@builtin(vertex_index) index: u32) -> Floor {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    var out: Floor;
    out.world = vec3<f32>(globals.floor.xy + corner * globals.floor.w, globals.floor.z);
    out.position = globals.clip_from_world * vec4<f32>(out.world, 1.0);
    return out;
}

@fragment
fn fs_floor_depth(in: Floor) -> @location(0) vec4<f32> {
    let fraction = (depth_of(in.world) - globals.depth.x) / globals.depth.y;
    return vec4<f32>(pack2(fraction), pack_normal(vec3<f32>(0.0, 0.0, 1.0)));
}

// Opacity of lines one pixel wide at the whole numbers of `at`; they vanish before they would flicker.
fn grid_lines(at: vec2<f32>, footprint: vec2<f32>) -> f32 {
    let from_line = abs(fract(at - 0.5) - 0.5) / max(footprint, vec2<f32>(1e-6));
    let line = clamp(1.2 - from_line, vec2<f32>(0.0), vec2<f32>(1.0)) * smoothstep(vec2<f32>(0.35), vec2<f32>(0.08), footprint);
    return max(line.x, line.y);
}

@fragment
fn fs_floor(in: Floor) -> @location(0) vec4<f32> {
    let footprint = fwidth(in.world.xy);
    // Cells of 0.25 m and 1 m; the scene centre is a whole number of metres.
    let fine = grid_lines(in.world.xy * 4.0, footprint * 4.0) * 0.55;
    let coarse = grid_lines(in.world.xy, footprint);
    let out = length(in.world.xy - globals.floor.xy) / globals.floor.w;
    let fade = 1.0 - smoothstep(0.15, 1.0, out);
    let grid = max(fine, coarse) * fade * fade * globals.srgb_grid.w;

    var dark = 0.0;
    if globals.options.w > 0.5 && globals.eye.z > globals.floor.z {
        let light = masked_light(in.position.xy, depth_of(in.world));
        dark = 1.0 - (1.0 - (1.0 - light.y) * globals.options.y) * (1.0 - (1.0 - light.x) * globals.options.y * 0.9);
        dark = clamp(dark * fade + dither(in.position.xy) * 2.0 * sign(dark), 0.0, 1.0);
    }
    let opacity = 1.0 - (1.0 - grid) * (1.0 - dark);
    return vec4<f32>(globals.srgb_grid.rgb * grid * (1.0 - dark * 0.6), opacity);
}
