// The visible side of bodies.

fn body_color(in: Fragment, front: bool) -> vec3<f32> {
    let n = facing(in.normal, front);
    var light: vec2<f32>;
    if in.surface.w * globals.options.w > 0.5 {
        light = masked_light(in.position.xy, depth_of(in.world));
    } else {
        light = vec2<f32>(1.0, simple_key_light(in.world, n, in.position.xy));
    }
    let color = shade(in.color.rgb, n, toward_eye(in.world), in.surface.x, in.surface.y, light.x, light.y);
    return srgb_from_linear(tone(color)) + dither(in.position.xy);
}

@fragment
fn fs_body(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if side_of_cut(in.world) < 0.0 {
        discard;
    }
    var color = in.color.rgb;
    if in.surface.z > 0.5 {
        color = clamp(body_color(in, front), vec3<f32>(0.0), vec3<f32>(1.0));
    } else if in.surface.x < 0.5 {
        color *= 0.79 + 0.21 * dot(facing(in.normal, front), vec3<f32>(0.36, 0.24, 0.90));
    }
    return vec4<f32>(color * in.color.a, in.color.a);
}

// Something that is not there: clear where one looks straight at it, dense at its rim.
@fragment
fn fs_ghost(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if side_of_cut(in.world) < 0.0 {
        discard;
    }
    let n = facing(in.normal, front);
    let rim = 1.0 - abs(dot(n, toward_eye(in.world)));
    let rim2 = rim * rim;
    let shape = 0.82 + 0.18 * n.z;
    let color = mix(in.color.rgb * shape, min(in.color.rgb * 1.1 + 0.06, vec3<f32>(1.0)), rim2);
    let opacity = in.color.a * (0.62 + 0.38 * rim2) + (1.0 - in.color.a) * 0.6 * rim2 * rim2;
    return vec4<f32>(color * opacity, opacity);
}

@fragment
fn fs_ghost_depth(in: Fragment) -> @location(0) vec4<f32> {
    if side_of_cut(in.world) < 0.0 {
        discard;
    }
    return vec4<f32>(0.0);
}
