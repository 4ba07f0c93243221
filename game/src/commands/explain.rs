//! `lightwell explain`: what a frame runs, reuses and skips, and why.

use crate::cli::{Common, ExplainArgs};
use crate::session::Session;
use anyhow::Result;
use lightwell::scene::SceneView;

/// Draws two frames of the same time and prints what each pass did.
///
/// # Errors
/// If the scene cannot be loaded or drawn.
pub fn run(args: &ExplainArgs, common: &Common) -> Result<()> {
    let mut session = Session::headless(&args.scene, &args.look, common)?;
    session.set_seconds(args.time);
    let scene = session.scene();
    let triangles: usize = scene.primitives.iter().map(|primitive| primitive.mesh.indices.len() / 3).sum();
    say!(
        "{}: {} primitives with {triangles} triangles, {} lights, {} cameras, {}",
        session.path().display(),
        scene.primitives.len(),
        scene.lights.len(),
        scene.cameras.len(),
        if scene.clpv.is_some() { "light propagation volumes" } else { "no light propagation volumes" },
    );
    let settings = session.render_settings(true);
    let view = SceneView { camera: session.camera()?, size: args.size, jitter: [0.0; 2] };
    for title in ["frame 1", "frame 2, of the same time: what has not changed is reused"] {
        // Extraction again, as in any other frame: nothing changed, so that it must find nothing.
        session.set_seconds(args.time);
        let report = session.render(&view, &settings)?;
        say!("\n{title}\n{report}");
    }
    if let Some([tested, accepted]) = session.light_counts()? {
        let wrong = 100.0 * (tested - accepted) / tested.max(f64::MIN_POSITIVE);
        say!("virtual lights a pixel: {tested:.1} tested, {accepted:.1} accepted, {wrong:.0} % in vain");
    }
    Ok(())
}
