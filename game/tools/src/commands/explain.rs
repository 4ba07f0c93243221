//! `lightwell explain`: what a frame runs, reuses and skips, and why.

use crate::cli::ExplainArgs;
use anyhow::Result;
use lightwell::graph::{FrameReport, ResourceDesc};
use lightwell::render::GiMethod;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::say;
use lightwell_runtime::session::Session;

/// Time between two frames that show which objects are dynamic [s].
const STEP: f64 = 0.04;

/// Headings of the frames at one time.
const TITLES: [&str; 2] = ["frame 1", "frame 2, of the same time: what has not changed is reused"];

/// Draws two frames of the same time and, where something moves, some of the times after it, and prints what each pass
/// did, after what of the scene does not show.
///
/// # Errors
/// If the scene cannot be loaded or drawn.
pub fn run(args: &ExplainArgs, common: &Common) -> Result<()> {
    let mut session = Session::headless(&args.scene, &args.look, common)?;
    session.set_seconds(args.time);
    let scene = session.scene();
    let triangles: usize = scene.primitives.iter().map(|primitive| primitive.mesh.indices.len() / 3).sum();
    let particles: usize = scene.primitives.iter().filter_map(|p| p.mesh.balls.as_ref()).map(|balls| balls.len()).sum();
    say!(
        "{}: {} primitives with {triangles} triangles, {} lights, {} cameras, {}{}{}",
        session.path().display(),
        scene.primitives.len(),
        scene.lights.len(),
        scene.cameras.len(),
        if scene.clpv.is_some() { "light propagation volumes" } else { "no light propagation volumes" },
        if scene.media.is_empty() { String::new() } else { format!(", fog of {} entities", scene.media.len()) },
        match particles {
            0 => String::new(),
            count => format!(", {count} particles"),
        },
    );
    session.remarks().for_each(|remark| say!("note: {remark}"));
    session.model_warnings().for_each(|warning| say!("warning: {warning}"));
    let settings = session.render_settings(true);
    let view = SceneView { camera: session.camera()?, size: args.size, jitter: [0.0; 2] };
    for title in TITLES {
        // Extraction again, as in any other frame: nothing changed, so that it must find nothing.
        session.set_seconds(args.time);
        let report = session.render(&view, &settings)?;
        say!("\n{title}\n{report}");
        if args.targets && title == TITLES[0] {
            say_targets(&report);
        }
    }
    if let Some([tested, accepted]) = session.light_counts()? {
        let wrong = 100.0 * (tested - accepted) / tested.max(f64::MIN_POSITIVE);
        say!("virtual lights a pixel: {tested:.1} tested, {accepted:.1} accepted, {wrong:.0} % in vain");
    }
    if settings.gi == GiMethod::REFERENCE {
        return Ok(());
    }
    // The first frame in which something moves makes what the others keep.
    let mut moved = |frames: f64| {
        session.set_seconds(args.time + frames * STEP);
        session.render(&view, &settings)
    };
    let (first, second) = (moved(1.0)?, moved(2.0)?);
    if first.ran_count() > 0 {
        say!("\nframe 4, two steps of {STEP} s later: what moves is drawn over what was kept of the rest\n{second}");
    }
    Ok(())
}

fn say_targets(report: &FrameReport) {
    say!("targets");
    for resource in &report.resources {
        if let ResourceDesc::Texture(desc) = &resource.desc {
            let [_, _, slices] = desc.size;
            let more = if slices > 1 { format!(", {slices} slices") } else { String::new() };
            say!("  {:<44} {}{more}", resource.name, resource.desc);
        }
    }
}
