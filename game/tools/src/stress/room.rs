//! A closed room: all light that its walls send on is a geometric series, and what is drawn is about as much.

use super::rig::Rig;
use super::setup::{Grid, Method};
use anyhow::Result;

/// Indirect light in a closed room, against what it should be.
pub struct Energy {
    /// Relative excess over all bounces.
    pub excess: f64,
    /// Relative deficit against the bounces that the method has.
    pub deficit: f64,
}

/// Excess and deficit of the indirect light in a closed cube with walls of albedo ρ and a lamp of 1 W/sr in its middle. The flux
/// Φ = 4π of the lamp meets the walls of area A = 24 m², they send on ρΦ, and of that all bounces make ρΦ/(1 − ρ)
/// arrive, nearly even over the walls: their indirect radiance is ρ/π · ρΦ/((1 − ρ)·A) at most. A method of one bounce has
/// the first term of the series, ρ/π · ρΦ/A.
///
/// # Errors
/// If it cannot be drawn.
pub fn energy(rig: &mut Rig, method: Method, grid: Grid, albedo: f32) -> Result<Energy> {
    let mut session = rig.open(&text(method, albedo), &method.look(grid, 0))?;
    let indirect = rig.draw(&mut session, false)?.mean();
    let albedo = f64::from(albedo);
    let most = albedo * albedo / (6.0 * (1.0 - albedo));
    log::info!("closed room, {}, albedo {albedo}: {:.4} of the series", method.name(), indirect / most);
    let least = if method == Method::Slc { albedo * albedo / 6.0 } else { most };
    Ok(Energy { excess: (indirect / most - 1.0).max(0.0), deficit: (1.0 - indirect / least).max(0.0) })
}

/// A cube of two metres with walls of a tenth, seen from one wall towards the other.
fn text(method: Method, albedo: f32) -> String {
    let (quality, transport) = (method.quality(), method.transport());
    let walls = [("Left", [-1.05, 0.0, 0.0], [0.1, 2.2, 2.2]), ("Right", [1.05, 0.0, 0.0], [0.1, 2.2, 2.2])]
        .into_iter()
        .chain([("Floor", [0.0, -1.05, 0.0], [2.0, 0.1, 2.0]), ("Ceiling", [0.0, 1.05, 0.0], [2.0, 0.1, 2.0])])
        .chain([("Back", [0.0, 0.0, -1.05], [2.0, 2.2, 0.1]), ("Front", [0.0, 0.0, 1.05], [2.0, 2.2, 0.1])])
        .map(|(name, p, s): (&str, [f32; 3], [f32; 3])| {
            format!(
                "(name: \"{name}\", transform: (translation: ({}, {}, {})), mesh: Box(size: ({}, {}, {})), material: \"wall\"),\n",
                p[0], p[1], p[2], s[0], s[1], s[2]
            )
        })
        .collect::<String>();
    format!(
        "Scene(materials: {{\"wall\": (color: ({albedo}, {albedo}, {albedo}), specular: 0)}}, entities: [\n{walls}\
         (name: \"Lamp\", light: (kind: Point, intensity: 1, rsm_size: 64)),\n\
         (name: \"Methods\", clpv: ({quality}, {transport}, cells: (18, 18, 18), cell_size: Meters(0.125), \
         cascades: 1, steps: 1000), vpl: (particles: 256), slc: (rsm_size: 64, interleave: 2)),\n\
         (name: \"Camera\", transform: (translation: (0, 0, 0.99)), camera: (fov: 90, near: 0.005)),\n])\n"
    )
}
