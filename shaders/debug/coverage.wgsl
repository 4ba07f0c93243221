// Which cascade lights a pixel: the finest whose box holds its surface.

#import lightwell::gbuffer::world_position
#import lightwell::view::View
#import lightwell::volume::Volume

const MAX_CASCADES: u32 = 4u;

struct Coverage {
    volumes: array<Volume, MAX_CASCADES>,  // finest first
    colors: array<vec4f, MAX_CASCADES>,
    count: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> coverage: Coverage;
@group(0) @binding(2) var depth: texture_depth_2d;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        discard;
    }
    let point = world_position(pixel, view.size, z, view.world_from_clip);
    for (var level = 0u; level < coverage.count; level++) {
        let volume = coverage.volumes[level];
        let at = (point - volume.origin) / volume.cell;
        if all(at >= vec3f(0.0)) && all(at < vec3f(volume.cells)) {
            // Lines between cells, about a pixel wide; a surface that lies in a face of cells has none of it.
            let off = abs(at - round(at));
            let step = step_to_next(pixel, point) / volume.cell;
            let on_line = (off < 0.75 * step) & (step > vec3f(0.05 * max(step.x, max(step.y, step.z))));
            let strength = select(0.3, 0.75, any(on_line));
            return vec4f(coverage.colors[level].rgb, strength);
        }
    }
    return vec4f(0.0, 0.0, 0.0, 0.5);
}

// How far the next pixels' surfaces lie from this one [m], without derivatives, which would need uniform control.
fn step_to_next(pixel: vec2u, point: vec3f) -> vec3f {
    var width = vec3f(0.0);
    for (var axis = 0u; axis < 2u; axis++) {
        var other = pixel;
        other[axis] = select(pixel[axis] + 1u, pixel[axis] - 1u, pixel[axis] + 1u >= view.size[axis]);
        let z = textureLoad(depth, other, 0);
        if z > 0.0 {
            width += abs(world_position(other, view.size, z, view.world_from_clip) - point);
        }
    }
    return width;
}
