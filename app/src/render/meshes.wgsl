// Bodies: their shadow, their depth and normal, their light.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // One per instance: rows of the world from the mesh's frame, sRGB with opacity, and the surface
    // (roughness, reflectance, 1 if lit, 1 if the mask holds its light).
    @location(2) row_x: vec4<f32>,
    @location(3) row_y: vec4<f32>,
    @location(4) row_z: vec4<f32>,
    @location(5) srgb: vec4<f32>,
    @location(6) surface: vec4<f32>,
}

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) @interpolate(flat, either) color: vec4<f32>,
    @location(3) @interpolate(flat, either) surface: vec4<f32>,
}

fn world_position(vertex: Vertex) -> vec3<f32> {
    let p = vec4<f32>(vertex.position, 1.0);
    return vec3<f32>(dot(vertex.row_x, p), dot(vertex.row_y, p), dot(vertex.row_z, p));
}

@vertex
fn vs_body(vertex: Vertex) -> Fragment {
    let world = world_position(vertex);
    let n = vertex.normal;
    var out: Fragment;
    out.position = globals.clip_from_world * vec4<f32>(world, 1.0);
    out.world = world;
    out.normal = vec3<f32>(dot(vertex.row_x.xyz, n), dot(vertex.row_y.xyz, n), dot(vertex.row_z.xyz, n));
    // Linear where it takes light, sRGB where it is shown as it is.
    let rgb = select(vertex.srgb.rgb, linear_from_srgb(vertex.srgb.rgb), vertex.surface.z > 0.5);
    out.color = vec4<f32>(rgb, vertex.srgb.a);
    out.surface = vertex.surface;
    return out;
}

fn facing(normal: vec3<f32>, front: bool) -> vec3<f32> {
    let n = normalize(normal);
    return select(-n, n, front);
}

@fragment
fn fs_depth_and_normal(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if side_of_cut(in.world) < 0.0 {
        discard;
    }
    // The last value means "nothing here".
    let fraction = min((depth_of(in.world) - globals.depth.x) / globals.depth.y, 65534.0 / 65535.0);
    return vec4<f32>(pack2(fraction), pack_normal(facing(in.normal, front)));
}

struct Shadow {
    @builtin(position) position: vec4<f32>,
    @location(0) depth: f32,
    @location(1) world: vec3<f32>,
}

@vertex
fn vs_shadow(vertex: Vertex) -> Shadow {
    let world = world_position(vertex);
    let light = light_from_world(world) / globals.light_size.xyz;
    var out: Shadow;
    out.world = world;
    out.position = vec4<f32>(light.x * 2.0 - 1.0, 1.0 - light.y * 2.0, light.z, 1.0);
    out.depth = light.z;
    return out;
}

@fragment
fn fs_shadow(in: Shadow) -> @location(0) vec4<f32> {
    if side_of_cut(in.world) < 0.0 {
        discard;
    }
    return vec4<f32>(pack3(in.depth), 0.0);
}
