#define_import_path lightwell::visible_patches

// Patches of surfaces that are drawn, which know the identity of their primitive.
//   FORWARD   the bindings of a raster pass, whose first groups are taken

#import lightwell::patches::patch_at
#ifdef FORWARD
#import lightwell::patches::NO_PATCH
#import lightwell::sampling::basis
#endif

// Of the scene's primitives, in their order.
#ifdef FORWARD
@group(3) @binding(33) var<storage, read> primitive_ids: array<u32>;
// Irradiance of the patches [W/m²].
@group(3) @binding(34) var<storage, read> patch_light: array<vec4f>;
#else
@group(0) @binding(23) var<storage, read> primitive_ids: array<u32>;
#endif

const NO_PRIMITIVE: u32 = 0xffffffffu;

// Index of the primitive with an identity, or NO_PRIMITIVE.
fn primitive_with(id: u32) -> u32 {
    let count = arrayLength(&primitive_ids);
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if primitive_ids[middle] < id {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low < count && primitive_ids[low] == id {
        return low;
    }
    return NO_PRIMITIVE;
}

#ifdef FORWARD
// Irradiance of the patches around a point [W/m²], weighted by a tent two patches wide, so that their borders do not show;
// `size` is the edge of a patch [m].
fn irradiance_of_patches(id: u32, position: vec3f, n: vec3f, size: f32) -> vec3f {
    let primitive = primitive_with(id);
    if primitive == NO_PRIMITIVE {
        return vec3f(0.0);
    }
    let tangents = basis(n);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < 16u; i++) {
        let offset = 0.5 * vec2f(vec2u(i % 4u, i / 4u)) - 0.75;
        let weight = (1.0 - abs(offset.x)) * (1.0 - abs(offset.y));
        let found = patch_at(primitive, position + size * (offset.x * tangents[0] + offset.y * tangents[1]), n);
        if found != NO_PATCH {
            sum += weight * patch_light[found].rgb;
            weights += weight;
        }
    }
    return sum / max(weights, 1e-6);
}
#endif
