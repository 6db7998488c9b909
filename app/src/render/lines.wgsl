// Polylines: each segment a capsule on the picture, so that joins are round.

struct Segment {
    @location(0) start: vec3<f32>,
    @location(1) end: vec3<f32>,
    @location(2) srgb: vec4<f32>,
    @location(3) style: vec4<f32>, // half width, dash length (0: solid), length before the start; in pixels
}

struct Stroke {
    @builtin(position) position: vec4<f32>,
    @location(0) along: vec4<f32>, // pixels along and across the segment; its length
    @location(1) @interpolate(flat, either) srgb: vec4<f32>,
    @location(2) @interpolate(flat, either) style: vec4<f32>,
}

@vertex
fn vs_line(@builtin(vertex_index) index: u32, segment: Segment) -> Stroke {
    var start = segment.start;
    var tip = segment.end;
    var out: Stroke;
    out.srgb = segment.srgb;
    out.style = segment.style;
    // Cut where the view is cut.
    let head_side = side_of_cut(start);
    let tail_side = side_of_cut(tip);
    if head_side < 0.0 && tail_side < 0.0 {
        out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        out.along = vec4<f32>(0.0);
        return out;
    }
    if head_side < 0.0 {
        start = mix(start, tip, head_side / (head_side - tail_side));
    } else if tail_side < 0.0 {
        tip = mix(tip, start, tail_side / (tail_side - head_side));
    }
    var a = globals.clip_from_world * vec4<f32>(start, 1.0);
    var b = globals.clip_from_world * vec4<f32>(tip, 1.0);
    // Cut at the near plane, where z = w.
    let before_a = a.w - a.z;
    let before_b = b.w - b.z;
    if before_a <= 0.0 && before_b <= 0.0 {
        out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        out.along = vec4<f32>(0.0);
        return out;
    }
    if before_a <= 0.0 {
        a = mix(a, b, before_a / (before_a - before_b) + 1e-4);
    } else if before_b <= 0.0 {
        b = mix(b, a, before_b / (before_b - before_a) + 1e-4);
    }
    let head = a.xyz / a.w;
    let tail = b.xyz / b.w;
    let way = (tail.xy - head.xy) * globals.size.xy * 0.5;
    let length_px = length(way);
    let direction = select(vec2<f32>(1.0, 0.0), way / max(length_px, 1e-6), length_px > 1e-6);
    let reach = segment.style.x + 1.0;
    let at_end = f32(index & 1u);
    let side = f32(index >> 1u) * 2.0 - 1.0;
    let along = mix(-reach, length_px + reach, at_end);
    let across = side * reach;
    let offset = direction * (along - length_px * at_end) + vec2<f32>(-direction.y, direction.x) * across;
    let end = mix(head, tail, at_end);
    // w = 1: everything below is even on the picture.
    let z = end.z * globals.depth.z + globals.depth.w;
    out.position = vec4<f32>(end.xy + offset * 2.0 * globals.size.zw, min(z, 1.0), 1.0);
    out.along = vec4<f32>(along, across, length_px, 0.0);
    return out;
}

@fragment
fn fs_line(in: Stroke) -> @location(0) vec4<f32> {
    let beyond = max(max(-in.along.x, in.along.x - in.along.z), 0.0);
    let distance = length(vec2<f32>(beyond, in.along.y));
    var coverage = clamp(in.style.x + 0.5 - distance, 0.0, 1.0);
    let dash = in.style.y;
    if dash > 0.0 {
        let at = (in.style.z + in.along.x) / (2.0 * dash);
        let from_middle = abs(fract(at) - 0.25) * 2.0 * dash;
        let wrapped = min(from_middle, 2.0 * dash - from_middle);
        coverage *= clamp(dash * 0.5 + 0.5 - wrapped, 0.0, 1.0);
    }
    let opacity = in.srgb.a * coverage;
    return vec4<f32>(in.srgb.rgb * opacity, opacity);
}
