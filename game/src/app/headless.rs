//! A game without a window: a script in, images out.

use super::canvas::Canvas;
use super::player::Drawn;
use super::{App, CustomPassAdder, GameArgs, Hud, Sounds, default_folder};
use anyhow::{Context, Result};
use lightwell::game::{Game, InputScript, Time};
use lightwell::gpu::Gpu;
use lightwell::measure;
use lightwell::render::UpdateRate;
use lightwell_runtime::say;
use lightwell_runtime::window::Painted;
use lightwell_runtime::writer::numbered;
use lightwell_runtime::{progress, session};
use std::path::PathBuf;

/// Which images are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// Size \[pixels\].
    pub size: [u32; 2],
    /// Steps from image to image, at least one. Light probes are answered at each.
    pub every: u64,
    /// Folder for them; none: they are drawn and not kept.
    pub folder: Option<PathBuf>,
}

/// The outcome of a run.
pub struct Outcome {
    /// The game as it stands.
    pub game: Game,
    /// The last image: size, and sRGB bytes, three a pixel.
    pub picture: Option<([u32; 2], Vec<u8>)>,
    /// Number of images.
    pub count: u64,
}

/// Plays as the command line says.
pub(super) fn run_args(mut app: App, args: &GameArgs, script: Option<InputScript>) -> Result<()> {
    let name = app.name();
    let folder = args.output.clone().unwrap_or_else(|| default_folder(&name));
    let passes = std::mem::take(&mut app.passes);
    let game = app.start_with(args.scene.as_deref(), &args.sets, &args.common)?;
    let rate = u64::from(game.world.ecs.resource::<Time>().rate);
    let mut script = script.unwrap_or(InputScript { steps: 2 * rate, events: Vec::new() });
    script.steps = args.steps.unwrap_or(script.steps);
    let pictures = Pictures { size: args.size.unwrap_or([512, 320]), every: args.every, folder: Some(folder.clone()) };
    let gpu = session::open_gpu(&args.common)?;
    say!("playing {} steps of `{name}`, pictures in {}/ ...", script.steps, folder.display());
    let mut drawn = Drawn::new(game, gpu.into(), args.look(), &passes);
    let outcome = go_on(&mut drawn, &script, &pictures)?;
    say!("wrote {} pictures, {:.2} s apart", outcome.1, args.every as f64 / rate as f64);
    Ok(())
}

/// Plays a script.
pub(super) fn play(
    game: Game,
    gpu: Gpu,
    passes: &[CustomPassAdder],
    script: &InputScript,
    pictures: &Pictures,
) -> Result<Outcome> {
    let mut drawn = Drawn::new(game, gpu.into(), Default::default(), passes);
    let (picture, count) = go_on(&mut drawn, script, pictures)?;
    Ok(Outcome { game: drawn.game, picture, count })
}

type Picture = ([u32; 2], Vec<u8>);

fn go_on(drawn: &mut Drawn, script: &InputScript, pictures: &Pictures) -> Result<(Option<Picture>, u64)> {
    if let Some(folder) = &pictures.folder {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let (mut canvas, mut last, mut count) = (Canvas::new(&drawn.rendering.gpu, pictures.size), None, 0);
    let bar = progress::bar(script.steps, "playing");
    let every = pictures.every.max(1);
    for step in 1..=script.steps {
        let place = || format!("step {step}");
        drawn.step(&script.at(step)).with_context(place)?;
        drawn.game.world.ecs.resource_mut::<Sounds>().take();
        bar.inc(1);
        if step % every == 0 || drawn.game.has_ended() {
            let picture = picture(drawn, &mut canvas, every).with_context(place)?;
            count += 1;
            if let Some(folder) = &pictures.folder {
                let (size, bytes) = &picture;
                measure::write_png_rgb8(&numbered(&folder.join("step.png"), step), *size, bytes)?;
            }
            last = Some(picture);
        }
        if drawn.game.has_ended() {
            break;
        }
    }
    bar.finish_and_clear();
    Ok((last, count))
}

/// Draws the image with what stands over it.
fn picture(drawn: &mut Drawn, canvas: &mut Canvas, steps: u64) -> Result<Picture> {
    let rate = drawn.game.world.ecs.resource::<Time>().rate;
    let gpu = drawn.rendering.gpu.clone();
    let size = canvas.size();
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size.map(|edge| edge as f32).into());
    let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
    let (result, mut output) = drawn.frame(steps as f32 / rate as f32, Some(input));
    result?;
    drawn.render(size, UpdateRate::Whole)?;
    let image = canvas.set_image(&gpu, drawn.rendering.display_texture());
    let context = drawn.game.world.ecs.resource::<Hud>().context().clone();
    let painted = Painted::over(image, screen, &mut output);
    let picture = canvas.paint(&gpu, &context, painted)?;
    drawn.take_light()?;
    Ok(picture)
}
