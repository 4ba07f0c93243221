#define_import_path lightwell::haze_along

// What media do to light along a ray that does not come to the eye: as much as passes, and what they scatter towards the
// ray's beginning, by the first harmonics of light and phase function: J·(1 − 3g·F·ω/(4π·J)) of the mean radiance J and the net flux
// F there, no less than none (Pharr, Jakob and Humphreys 2023, section 11.4).
//   LAMPS_ALONE  the cells hold light straight from the lights only, three vectors a cell; and light that is scattered once more
//                counts as if it went on, so that only what is absorbed is lost

#import lightwell::media::{FARTHEST, MEDIA, Span, depth_of, media, span_in}
#import lightwell::volume::{Volume, cell_index}

@group(0) @binding(45) var<uniform> haze_volume: Volume;
@group(0) @binding(46) var<storage, read> haze_cells: array<vec4f>;

const STEPS: u32 = 6u;

struct Along {
    passing: vec3f,        // share of light from the end that passes
    added: vec3f,          // [W/(m² sr)]
}

struct InCell {
    light: vec3f,          // mean radiance [W/(m² sr)]
    flux: vec3f,           // net flux of all channels over 4π times their mean radiance
}

// Light of the cell around a point, which lies in the volume or is moved into it.
fn light_in_cell(position: vec3f) -> InCell {
    let x = (position - haze_volume.origin) / haze_volume.cell;
    let cell = vec3u(clamp(x, vec3f(0.0), vec3f(haze_volume.cells) - 0.5));
    let index = cell_index(haze_volume, cell);
#ifdef LAMPS_ALONE
    let light = haze_cells[3u * index].rgb;
    let flux = vec3f(haze_cells[3u * index].w, haze_cells[3u * index + 1u].w, haze_cells[3u * index + 2u].w);
#else
    let light = haze_cells[2u * index].rgb;
    let flux = haze_cells[2u * index + 1u].xyz;
#endif
    return InCell(light, flux / max(12.5663706 * (light.r + light.g + light.b), 1e-30));
}

// Where a ray leaves the volume [m]; beyond, light is as it is there.
fn exit_of(origin: vec3f, direction: vec3f) -> f32 {
    let size = vec3f(haze_volume.cells) * haze_volume.cell;
    let along = select(direction, vec3f(1e-30), abs(direction) < vec3f(1e-30));
    let far = (haze_volume.origin + select(vec3f(0.0), size, along > vec3f(0.0)) - origin) / along;
    return max(min(far.x, min(far.y, far.z)), 0.0);
}

fn haze_along(origin: vec3f, direction: vec3f, distance: f32, random: f32) -> Along {
    let reach = min(distance, FARTHEST);
    var begin = FARTHEST;
    var end = 0.0;
    for (var i = 0u; i < MEDIA; i++) {
        let span = span_in(media[i], origin, direction, reach);
        let is_met = span.end > span.begin;
        begin = select(begin, min(begin, span.begin), is_met);
        end = select(end, max(end, span.end), is_met);
    }
    var result = Along(vec3f(1.0), vec3f(0.0));
    if end <= begin {
        return result;
    }
    // One part more lies beyond the volume.
    let last = clamp(exit_of(origin, direction), begin, end);
    let step = (last - begin) / f32(STEPS);
    for (var i = 0u; i <= STEPS; i++) {
        let is_beyond = i == STEPS;
        let from_here = begin + f32(i) * step;
        let to_here = select(from_here + step, end, is_beyond);
        let at = from_here + select(random * step, 0.0, is_beyond);
        let here = light_in_cell(origin + direction * at);
        let onward = -3.0 * dot(here.flux, direction);
        var depth = 0.0;
        var scattered = vec3f(0.0);
        var absorbed = vec3f(0.0);
        for (var k = 0u; k < MEDIA; k++) {
            let whole = span_in(media[k], origin, direction, reach);
            let part = Span(max(whole.begin, from_here), min(whole.end, to_here));
            let of_medium = depth_of(media[k], origin, direction, part);
            depth += of_medium;
            scattered += of_medium * max(1.0 + media[k].anisotropy * onward, 0.0) * media[k].albedo;
            absorbed += of_medium * (1.0 - media[k].albedo);
        }
        if depth > 0.0 {
            let light = here.light;
#ifdef LAMPS_ALONE
            let kept = exp(-absorbed);
            // Of what is absorbed in the part itself half lies before the point.
            result.added += result.passing * sqrt(kept) * scattered * light;
            result.passing *= kept;
#else
            let kept = exp(-depth);
            result.added += result.passing * (1.0 - kept) * scattered / depth * light;
            result.passing *= kept;
#endif
        }
    }
    return result;
}
