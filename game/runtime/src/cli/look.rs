//! Choices that change the picture, which several commands take.

use super::{built_in_methods, method_parser, parse_assignment, parse_update};
use clap::{Args, ValueEnum};
use lightwell::render::debug::{DebugView, ShownTarget};
use lightwell::render::{GiMethod, UpdateRate};

/// Part of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Only {
    /// Direct and indirect light
    #[default]
    Total,
    /// Light that comes straight from lights
    Direct,
    /// Light that other surfaces pass on
    Indirect,
    /// Base colour
    Albedo,
    /// Normals in world space
    Normal,
    /// Distance along the view direction
    Depth,
}

impl Only {
    /// Whether it shows light, rather than what the surfaces are.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Total | Self::Direct | Self::Indirect)
    }
}

/// What tells an edge that is smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Edges {
    /// Colours as displayed
    #[default]
    Color,
    /// Depth: outlines of what stands before something
    Depth,
    /// Normals: where surfaces of different directions meet
    Normal,
}

/// Whether something is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// It is
    On,
    /// It is not
    Off,
}

/// Choices that change the picture.
#[derive(Args, Clone, Debug, Default)]
pub struct LookArgs {
    /// Indirect light [default: what the scene asks for]
    #[arg(long, value_name = "GI", value_parser = method_parser(built_in_methods()))]
    pub gi: Option<GiMethod>,
    /// Part of the picture to show
    #[arg(long, value_enum, default_value_t = Only::Total)]
    pub only: Only,
    /// Leave the edges of single display frames as they are drawn (averaged and measured images always do: --quality,
    /// --aa, EXR, layers)
    #[arg(long)]
    pub no_mlaa: bool,
    /// What tells the edges that are smoothed
    #[arg(long, value_enum, default_value_t = Edges::Color)]
    pub mlaa_edges: Edges,
    /// Average light with that of the frames before: each casts few rays, light that goes is gone within three frames, edges
    /// are smoothed over frames, and a view that rests comes to rest after 64. An image then depends on those before it
    /// [default: on in windows, off elsewhere]
    #[arg(long, value_enum)]
    pub average: Option<Switch>,
    /// Bring the light between surfaces up to date over so many frames, where light is averaged over frames: 1, 2 or 4
    /// [default: 1; windows choose it by the time that frames take]
    #[arg(long, value_name = "N", value_parser = parse_update)]
    pub light_over: Option<UpdateRate>,
    /// Settings of `--gi reference`.
    #[command(flatten)]
    pub trace: TraceArgs,
    /// Draw each light in a pass of its own; without this those without shadows share one
    #[arg(long)]
    pub each_light_alone: bool,
    /// Instant radiosity: show the light of one virtual light alone, by its number from 0
    #[arg(long, value_name = "N")]
    pub virtual_light: Option<u32>,
    /// Instant radiosity: draw the ways of the first N particles of every source over the image
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub particle_paths: u32,
    /// What is drawn over display images.
    #[command(flatten)]
    pub debug: DebugArgs,
    /// Camera by name [default: the scene's primary camera]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Change a value of the loaded scene: `ENTITY.COMPONENT.FIELD=VALUE`, `clpv.FIELD=VALUE`, `vpl.FIELD=VALUE`,
    /// `slc.FIELD=VALUE` or `scene.FIELD=VALUE`, with the value as in scene files, or `preset=NAME` for a set of changes
    /// that the scene's
    /// file lists; may be given many times
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = parse_assignment)]
    pub sets: Vec<(String, String)>,
}

/// What is drawn over display images.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct DebugArgs {
    /// Draw over the image (PNG and window): lights, cameras, cascades, coverage, light, blockers, voxels, bvh,
    /// virtual-lights, directions; several with commas
    #[arg(long = "debug", value_name = "NAME", value_delimiter = ',')]
    pub views: Vec<DebugView>,
    /// Light volume whose cells `light`, `blockers` and `voxels` show; 0 is the finest
    #[arg(long = "debug-cascade", value_name = "N", default_value_t = 0)]
    pub cascade: u32,
    /// Level of the ray hierarchy that `bvh` shows; 0 is the box around everything
    #[arg(long = "debug-level", value_name = "N", default_value_t = 8)]
    pub bvh_level: u32,
    /// Lay a target of a pass over the image, as `explain` names it, such as `gbuffer depth.r=0..0.1`: its name, then @slice,
    /// /mip, .channel and =LOW..HIGH where they are wanted; may be given many times, for tiles side by side
    #[arg(long = "debug-target", value_name = "TARGET")]
    pub targets: Vec<ShownTarget>,
}

impl DebugArgs {
    /// Whether nothing is drawn over the image.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty() && self.targets.is_empty()
    }
}

impl LookArgs {
    /// As windows take them: light is averaged over frames unless that is not wanted.
    pub fn in_window(&self) -> Self {
        Self { average: self.average.or(Some(Switch::On)), ..self.clone() }
    }
}

impl Default for DebugArgs {
    fn default() -> Self {
        Self { views: Vec::new(), cascade: 0, bvh_level: 8, targets: Vec::new() }
    }
}

/// Settings of path tracing.
#[derive(Args, Clone, Debug)]
pub struct TraceArgs {
    /// Path tracing: samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub spp: u32,
    /// Path tracing: indirect bounces [default: unlimited]
    #[arg(long, value_name = "K")]
    pub bounces: Option<u32>,
    /// Path tracing: seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
}

impl Default for TraceArgs {
    fn default() -> Self {
        Self { spp: 64, bounces: None, seed: 0 }
    }
}
