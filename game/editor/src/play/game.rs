//! The game that plays in the window: begun and ended, time passes, and what it draws over the view.

use super::player::Player;
use super::playing::{End, Overlay, Playing};
use crate::editor::camera::FlyCamera;
use crate::editor::{PlayFacts, PlayRequest, Request};
use anyhow::Result;
use egui::{Pos2, RawInput, Rect, ViewportId, ViewportInfo};
use lightwell::files::OverrideFile;
use lightwell::gpu::Gpu;
use lightwell::scene::SceneId;
use lightwell::world::GameWorld;
use lightwell_runtime::probe_light::ProbeLight;
use lightwell_runtime::session::RenderState;
use lightwell_runtime::window::{Area, GatheredInput, Painted, UiPainter};
use std::path::Path;
use winit::event::{DeviceEvent, ElementState, WindowEvent};

/// A game that plays, with what it keeps of the edited scene.
pub struct Play {
    pub playing: Playing,
    pub light: ProbeLight,
    /// What drew the edited scene, and the camera that looked at it.
    resting: RenderState,
    pub camera: FlyCamera,
    layer: Option<Layer>,
}

impl Play {
    /// What the panels are told of it. `edited` is the world that rests, with its file.
    pub fn facts<'a>(&self, trouble: Option<&'a str>, edited: (&'a GameWorld, &'a Path)) -> PlayFacts<'a> {
        let time = self.playing.time();
        PlayFacts {
            paused: self.playing.paused,
            step: time.step,
            seconds: time.elapsed,
            trouble,
            overlay: self.layer.as_ref().map(|layer| layer.id),
            edited: self.playing.is_in_edited_scene().then_some(edited),
        }
    }
}

/// What a game draws over the view, on a texture of its own.
struct Layer {
    painter: UiPainter,
    texture: wgpu::Texture,
    id: egui::TextureId,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

fn texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("overlay"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

impl Player {
    /// Does what is asked of the game.
    pub(super) fn answer_play(&mut self, request: PlayRequest) {
        let playing = self.play.as_mut().map(|play| &mut play.playing);
        match (request, playing) {
            // What draws lies with the thread that draws.
            (request @ (PlayRequest::Begin | PlayRequest::Stop), _) if !self.render_thread.is_idle() => {
                self.render_thread.drop_frame();
                self.waiting.push(Request::Play(request));
            }
            (PlayRequest::Begin, None) => {
                if let Err(error) = self.begin_play() {
                    self.editor.tell(format!("cannot play: {error:#}"), true);
                }
            }
            (PlayRequest::Stop, Some(_)) => self.end_play(None),
            (PlayRequest::Pause(paused), Some(playing)) => {
                playing.paused = paused;
                self.editor.view.takes_input = !paused;
            }
            (PlayRequest::Step, Some(playing)) => playing.step_once(),
            (PlayRequest::Apply(edits), Some(_)) => self.apply(&edits),
            _ => {}
        }
    }

    fn begin_play(&mut self) -> Result<()> {
        if self.job.is_some() {
            anyhow::bail!("an export goes on: cancel it first, or wait for it");
        }
        let parts = self.session.parts();
        self.editor.begin_play(parts.world)?;
        let playing = match Playing::begin(&self.new_game, parts.world, parts.files.library, parts.files.path) {
            Ok(playing) => playing,
            Err(error) => {
                self.editor.end_play();
                return Err(error);
            }
        };
        let resting = &self.session.rendering;
        let mut rendering =
            RenderState::with_methods(resting.gpu.clone(), resting.look.clone(), resting.custom_methods());
        rendering.display = self.session.rendering.display;
        playing.played().add_passes(&mut rendering);
        let resting = std::mem::replace(&mut self.session.rendering, rendering);
        let camera = std::mem::take(&mut self.camera);
        let play = self.play.insert(Play { playing, light: ProbeLight::default(), resting, camera, layer: None });
        self.session.rendering.follow(&mut play.playing.game_mut().world);
        self.picture.forget();
        self.editor.tell("the game plays on a copy of the scene; F5 stops it", false);
        Ok(())
    }

    /// Ends the game, if one plays: the edited scene is there again as it was. `why` is an error to be told.
    pub(super) fn end_play(&mut self, why: Option<String>) {
        let Some(play) = self.play.take() else { return };
        let ended = std::mem::replace(&mut self.session.rendering, play.resting);
        // How the view is looked at is no part of the scene.
        (self.session.rendering.look, self.session.rendering.display) = (ended.look, ended.display);
        self.camera = play.camera;
        self.editor.end_play();
        self.picture.forget();
        match why {
            Some(why) => self.editor.tell(why, true),
            None => self.editor.tell("the game has ended; the scene is as it was before", false),
        }
    }

    fn apply(&mut self, edits: &[(SceneId, OverrideFile)]) {
        let result = self.with_stage(true, |window, stage| window.editor.apply_to_scene(stage, edits));
        match result {
            Ok(()) => self.editor.tell("applied to the scene; after Stop it can be undone", false),
            Err(error) => self.editor.tell(format!("not applied: {error:#}"), true),
        }
    }

    /// Lets time pass in the game: `elapsed` seconds, or none while a picture of it is being drawn.
    pub(super) fn pass_time(&mut self, elapsed: Option<f64>) {
        // What its interface is told waits for its next step.
        let input = elapsed.is_some().then(|| self.overlay_input());
        let Some(play) = &mut self.play else { return };
        let rendering = &mut self.session.rendering;
        let origin = rendering.scene.origin;
        let passed = elapsed.zip(input).map(|(elapsed, input)| {
            if let Err(error) = play.light.take_late(play.playing.game_mut(), rendering) {
                log::error!("{error:#}");
            }
            let events = self.input.take();
            play.playing.advance(elapsed, events, input, |world| rendering.follow(world))
        });
        let passed = passed.unwrap_or_default();
        if let Some(end) = passed.end {
            return self.end_by_itself(end);
        }
        if !passed.ran {
            // Edits count at once.
            let world = &mut play.playing.game_mut().world;
            world.update();
            rendering.follow(world);
        }
        self.camera.rebase((rendering.scene.origin - origin).as_vec3());
        if let Some(overlay) = passed.overlay {
            self.show_overlay(overlay);
        }
    }

    fn end_by_itself(&mut self, end: End) {
        let why = match end {
            End::Quit => None,
            End::Panic(message) => {
                let text = format!("the game was stopped, a system panicked: {message}");
                log::error!("{text}");
                Some(text)
            }
        };
        // Time passes only while no picture is drawn, so that nothing has to wait.
        self.end_play(why);
    }

    /// What egui of the game begins with: a screen that is the view.
    fn overlay_input(&mut self) -> RawInput {
        let scale = self.ui.context.pixels_per_point();
        let size = self.editor.view.size.map(|edge| edge.max(1) as f32 / scale);
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size.into())),
            events: std::mem::take(&mut self.editor.view.forwarded),
            ..RawInput::default()
        };
        let viewport = ViewportInfo { native_pixels_per_point: Some(scale), ..ViewportInfo::default() };
        input.viewports.insert(ViewportId::ROOT, viewport);
        input
    }

    fn show_overlay(&mut self, Overlay { context, mut output }: Overlay) {
        let gpu = self.session.gpu.clone();
        let limit = gpu.limits.max_texture_dimension_2d;
        let size = self.editor.view.size.map(|edge| edge.clamp(1, limit));
        let Some(play) = &mut self.play else { return };
        let mut layer = play.layer.take().unwrap_or_else(|| {
            let (painter, texture) = (UiPainter::transparent(&gpu, FORMAT), texture(&gpu, size));
            Layer { painter, id: self.ui.set_overlay(&gpu, &texture), texture }
        });
        if [layer.texture.width(), layer.texture.height()] != size {
            layer.texture = texture(&gpu, size);
            layer.id = self.ui.set_overlay(&gpu, &layer.texture);
        }
        let target = layer.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("overlay") });
        layer.painter.paint(&gpu, &mut encoder, &context, (&target, size), Painted::new(&mut output));
        gpu.queue.submit([encoder.finish()]);
        self.ui.touch_overlay();
        play.layer = Some(layer);
    }

    /// Gives the game an event of the window, while it has mouse and keyboard.
    pub(super) fn forward(&mut self, event: &WindowEvent) {
        if let WindowEvent::CursorMoved { position, .. } = event {
            self.cursor = [position.x as f32, position.y as f32];
        }
        let area = self.editor.view.area(self.ui.context.pixels_per_point());
        let presses = matches!(event, WindowEvent::MouseInput { state: ElementState::Pressed, .. });
        if self.editor.view.has_input && (!presses || contains(area, self.cursor)) {
            self.input.window(event, area);
        }
    }

    /// Gives the game an event of a device, while it has the mouse.
    pub fn device_event(&mut self, event: &DeviceEvent) {
        if self.editor.view.has_input {
            self.input.device(event);
        }
    }

    /// Takes mouse and keyboard back from the game where the view has lost them, and tells it of the view's shape.
    pub(super) fn settle_input(&mut self) {
        if !self.editor.view.has_input {
            self.input.let_go();
        }
        match self.play {
            Some(_) => self.input.size(self.editor.view.size),
            None => self.input = GatheredInput::default(),
        }
    }

    /// Whether time passes in a game.
    pub(super) fn game_runs(&self) -> bool {
        self.play.as_ref().is_some_and(|play| !play.playing.paused)
    }
}

fn contains(area: Area, [x, y]: [f32; 2]) -> bool {
    let inside = |at: f32, min: f32, size: f32| (min..min + size).contains(&at);
    inside(x, area.min[0], area.size[0]) && inside(y, area.min[1], area.size[1])
}
