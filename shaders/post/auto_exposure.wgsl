// Log-average luminance of the image on a grid of samples, and the factor that makes it middle grey.
// Reinhard, Stark, Shirley, Ferwerda 2002, "Photographic tone reproduction for digital images", eq. 1 and 2.

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> factor: array<f32>;

const THREADS: u32 = 256u;
const GRID: u32 = 128u;           // samples along each axis, at most
const MIDDLE_GREY: f32 = 0.18;
const MAX_STOPS: f32 = 24.0;

var<workgroup> sums: array<vec2f, THREADS>;   // sum of logarithms, number of samples

@compute @workgroup_size(THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let size = textureDimensions(radiance);
    let count = min(size, vec2u(GRID));
    var sum = vec2f(0.0);
    for (var i = thread; i < count.x * count.y; i += THREADS) {
        let cell = vec2u(i % count.x, i / count.x);
        let color = textureLoad(radiance, (cell * size + size / 2u) / count, 0).rgb;
        let luminance = dot(color, vec3f(0.2126, 0.7152, 0.0722));
        // Black has no logarithm; it says nothing of the light either.
        if luminance > 1e-8 && luminance < 1e30 {
            sum += vec2f(log2(luminance), 1.0);
        }
    }
    sums[thread] = sum;
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            sums[thread] += sums[thread + half];
        }
    }
    if thread == 0u {
        let mean = sums[0].x / max(sums[0].y, 1.0);
        let stops = select(0.0, log2(MIDDLE_GREY) - mean, sums[0].y > 0.0);
        factor[0] = exp2(clamp(stops, -MAX_STOPS, MAX_STOPS));
    }
}
