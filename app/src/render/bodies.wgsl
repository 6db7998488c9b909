// The visible side of bodies.

fn body_color(in: Fragment, front: bool) -> vec3<f32> {
    let n = facing(in.normal, front);
    var light: vec2<f32>;
    if in.surface.w * globals.options.w > 0.5 {
        light = masked_light(in.position.xy, depth_of(in.world));
    } else {
        light = vec2<f32>(1.0, simple_key_light(in.world, n, in.position.xy));
    }
    let albedo = linear_from_srgb(in.srgb.rgb);
    let color = shade(albedo, n, toward_eye(in.world), in.surface.x, in.surface.y, light.x, light.y);
    return srgb_from_linear(tone(color)) + dither(in.position.xy);
}

@fragment
fn fs_body(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    var color = in.srgb.rgb;
    if in.surface.z > 0.5 {
        color = clamp(body_color(in, front), vec3<f32>(0.0), vec3<f32>(1.0));
    }
    return vec4<f32>(color * in.srgb.a, in.srgb.a);
}

// Something that is not there: clear where one looks straight at it, dense at its rim.
@fragment
fn fs_ghost(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let n = facing(in.normal, front);
    let rim = 1.0 - abs(dot(n, toward_eye(in.world)));
    let rim2 = rim * rim;
    let shape = 0.82 + 0.18 * n.z;
    let color = mix(in.srgb.rgb * shape, min(in.srgb.rgb * 1.1 + 0.06, vec3<f32>(1.0)), rim2);
    let opacity = in.srgb.a * mix(0.55, 1.0, rim2) + (1.0 - in.srgb.a) * 0.5 * in.srgb.a * rim2 * rim2;
    return vec4<f32>(color * opacity, opacity);
}

@fragment
fn fs_ghost_depth() -> @location(0) vec4<f32> {
    return vec4<f32>(0.0);
}
