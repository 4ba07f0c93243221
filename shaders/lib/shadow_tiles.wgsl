#define_import_path lightwell::shadow_tiles

// Tiles of the image, with what the shadow rays of their pixels found.

const TILE: u32 = 8u;
// Kinds of samples: some met something, some arrived.
const DARK: u32 = 1u;
const LIT: u32 = 2u;
const MIXED: u32 = 3u;

// Number of a pixel's tile.
fn tile_of(pixel: vec2u, size: vec2u) -> u32 {
    return pixel.x / TILE + pixel.y / TILE * ((size.x + TILE - 1u) / TILE);
}

// Kinds of samples that a pixel has, by their sums: none where no point of the light was in sight of the surface.
fn kinds_of(s: vec4f) -> u32 {
    return select(DARK, 0u, s.x == s.y && s.z == s.w) | select(LIT, 0u, s.x == 0.0 && s.z == 0.0);
}
