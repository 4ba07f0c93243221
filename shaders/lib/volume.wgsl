#define_import_path lightwell::volume

// A light propagation volume: cells of light, and blockers on the cells' corners (one more along each axis).
// A cell of light is three vectors, one a colour channel, of four SH coefficients of I/h² [W/(m² sr)].

struct Volume {
    origin: vec3f,         // lower corner [m]
    cell: f32,             // edge of a cell [m]
    cells: vec3u,
    padding: u32,
}

// Surfaces are taken this far behind where they are [cells]. A wall that stands right between two cells falls to the
// one behind it with all of its texels, whatever the rounding of their positions; else it would leak.
const BEHIND: f32 = 1e-3;

fn cell_index(volume: Volume, cell: vec3u) -> u32 {
    return (cell.z * volume.cells.y + cell.y) * volume.cells.x + cell.x;
}

fn corner_index(volume: Volume, corner: vec3u) -> u32 {
    return (corner.z * (volume.cells.y + 1u) + corner.y) * (volume.cells.x + 1u) + corner.x;
}
