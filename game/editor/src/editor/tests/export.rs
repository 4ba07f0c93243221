//! What an export writes: asked for by clicks, drawn as the window does it, compared to what is rendered without one.

use super::dialogs::enter_path;
use super::*;
use crate::editor::Export;
use crate::play::export::{Job, Next};
use egui::{Key, Modifiers};
use lightwell::render::ToneMap;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::session::Session;

/// Types a number where a question asks for one.
fn enter(bench: &mut Bench, name: &str, value: &str) {
    find(bench, name).focus();
    bench.run_steps(2);
    press(bench, Modifiers::COMMAND, Key::A);
    bench.event(egui::Event::Text(value.to_owned()));
    press(bench, Modifiers::NONE, Key::Enter);
}

/// Asks for an export of a few small frames, two a second.
fn ask(bench: &mut Bench, folder: &Path, frames: &str, video: bool) -> Export {
    click(bench, "File");
    click(bench, "Export the animation…");
    enter_path(bench, folder);
    for (name, value) in [("Width", "48"), ("Height", "32"), ("Frames a second", "2"), ("Frames", frames)] {
        enter(bench, name, value);
    }
    if video {
        click(bench, "make one with ffmpeg");
    }
    click(bench, "Export");
    match bench.state_mut().requests.pop() {
        Some(Request::Export(export)) => export,
        other => panic!("{other:?}"),
    }
}

/// The test scene before a sky, without which little of it is seen.
fn session(path: &Path) -> Session {
    let text = std::fs::read_to_string(path).unwrap();
    let path = path.with_file_name("sky.scene.ron");
    let sky = "duration: 4, sky: (0.2, 0.3, 0.4), sky_light: false";
    std::fs::write(&path, text.replace("duration: 4", sky)).unwrap();
    Session::headless(path.to_str().unwrap(), &LookArgs::default(), &Common::default()).unwrap()
}

/// Does what the window does, frame by frame, until the end or so many frames.
fn work(job: &mut Job, session: &mut Session, most: u64) -> anyhow::Result<()> {
    while job.progress().0 < most {
        match job.next(session, |session| session.camera())? {
            Next::Frame(frame) => {
                session.render(&frame.0, &frame.1)?;
                job.keep(session)?;
            }
            Next::Wait => std::thread::sleep(std::time::Duration::from_millis(20)),
            Next::Done => return Ok(()),
        }
    }
    Ok(())
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_export_has_all_frames_as_they_are_rendered_without_a_window() {
    let (mut bench, folder) = bench();
    bench.state_mut().editor.panels.ffmpeg = Some(false);
    let out = folder.path().join("deep/frames");
    let export = ask(&mut bench, &out, "3", false);
    assert_eq!((export.size, export.rate, export.frames, export.video), ([48, 32], 2, 3, false));
    let path = bench.state().path.clone();
    let mut drawn = session(&path);
    work(&mut Job::new(export.clone()), &mut drawn, u64::MAX).unwrap();
    assert_eq!(files(&out), ["frame_0001.png", "frame_0002.png", "frame_0003.png"]);
    let mut other = session(&path);
    for number in 0..3 {
        other.set_seconds(f64::from(number) * 0.5);
        let file = folder.path().join("one.png");
        let view = SceneView { camera: other.camera().unwrap(), size: [48, 32], jitter: [0.0; 2] };
        let settings = other.display_settings();
        other.render(&view, &settings).unwrap();
        let (size, rgb) = other.display_bytes().unwrap();
        lightwell::measure::write_png_rgb8(&file, size, &rgb).unwrap();
        let exported = std::fs::read(out.join(format!("frame_{:04}.png", number + 1))).unwrap();
        assert!(exported == std::fs::read(file).unwrap(), "frame {number} differs");
    }
    let first = std::fs::read(out.join("frame_0001.png")).unwrap();
    assert!(first != std::fs::read(out.join("frame_0003.png")).unwrap(), "something moves");
    // What the display makes of light is exported too.
    drawn.rendering.display.tone_map = Some(ToneMap::Filmic);
    drawn.rendering.display.auto_exposure = true;
    work(&mut Job::new(export), &mut drawn, 1).unwrap();
    assert!(first != std::fs::read(out.join("frame_0001.png")).unwrap(), "tone map and exposure count");
}

#[test]
fn an_export_that_cannot_be_written_says_why() {
    let (mut bench, folder) = bench();
    let blocked = folder.path().join("file");
    std::fs::write(&blocked, "no folder").unwrap();
    let export = ask(&mut bench, &blocked.join("frames"), "2", false);
    let mut session = session(&bench.state().path);
    let error = format!("{:#}", work(&mut Job::new(export), &mut session, u64::MAX).unwrap_err());
    assert!(error.contains("cannot make the folder") && error.contains("file/frames"), "{error}");
}

#[test]
fn an_export_is_watched_and_cancelled() {
    let (mut bench, folder) = bench();
    assert!(bench.query_by_label("Cancel the export").is_none());
    let out = folder.path().join("frames");
    let export = ask(&mut bench, &out, "5", false);
    let mut session = session(&bench.state().path);
    let mut job = Job::new(export);
    work(&mut job, &mut session, 2).unwrap();
    bench.state_mut().working.export = Some(job.progress());
    bench.run_steps(2);
    assert!(bench.query_by_label("exported 2 of 5").is_some());
    click(&mut bench, "Cancel the export");
    assert_eq!(bench.state().requests, [Request::CancelExport]);
    drop(job);
    assert_eq!(files(&out), ["frame_0001.png", "frame_0002.png"], "what is written stays");
}

#[test]
fn videos_are_made_where_they_can_be() {
    let (mut bench, folder) = bench();
    bench.state_mut().editor.panels.ffmpeg = Some(false);
    click(&mut bench, "File");
    click(&mut bench, "Export the animation…");
    assert!(find(&bench, "ffmpeg is not installed: images alone").accesskit_node().is_disabled());
    click(&mut bench, "Cancel");
    bench.state_mut().editor.panels.ffmpeg = Some(true);
    let out = folder.path().join("frames");
    let export = ask(&mut bench, &out, "2", true);
    assert!(export.video);
    let mut session = session(&bench.state().path);
    let mut job = Job::with_encoder(export.clone(), "no-such-ffmpeg");
    let error = format!("{:#}", work(&mut job, &mut session, u64::MAX).unwrap_err());
    assert!(error.contains("ffmpeg cannot be started") && error.contains("the images are in"), "{error}");
}

#[lightwell_needs::needs("ffmpeg")]
fn videos_hold_the_frames_of_the_export_alone() {
    let (mut bench, folder) = bench();
    bench.state_mut().editor.panels.ffmpeg = Some(true);
    let out = folder.path().join("frames");
    let export = ask(&mut bench, &out, "2", true);
    let mut session = session(&bench.state().path);
    work(&mut Job::with_encoder(export.clone(), "no-such-ffmpeg"), &mut session, u64::MAX).unwrap_err();
    // Frames that a longer export left are not in the video.
    std::fs::copy(out.join("frame_0001.png"), out.join("frame_0003.png")).unwrap();
    work(&mut Job::new(export), &mut session, u64::MAX).unwrap();
    let video = out.join("video.mp4");
    let probe = std::process::Command::new("ffmpeg").arg("-i").arg(&video).args(["-f", "null", "-"]).output().unwrap();
    let said = String::from_utf8_lossy(&probe.stderr);
    assert!(said.contains("48x32") && said.contains("frame=    2"), "{said}");
}
