//! How a frame is to be drawn.

use super::debug_settings::DebugSettings;
pub use crate::core::GiMethod;
pub use crate::world::ToneMap;
use crate::world::{Exposure, Lens};

/// Settings of the path tracer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TraceSettings {
    /// Indirect bounces: the rays that go on after the surface that the camera sees. None: unlimited (Russian roulette
    /// from the fourth on).
    pub bounces: Option<u32>,
    /// Seed of all random numbers. Different seeds give independent images.
    pub seed: u32,
}

/// Settings of a path-traced image that is shown as a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ReferenceSettings {
    /// The light that is traced.
    pub trace: TraceSettings,
    /// Samples a pixel of the finished image.
    pub samples: u32,
    /// Samples a pixel that one frame adds at most. Less than `samples` shows the image while it gets better.
    pub samples_a_frame: u32,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self { trace: TraceSettings::default(), samples: 64, samples_a_frame: 64 }
    }
}

/// The light that an image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layer {
    /// All light [W/(m² sr)].
    #[default]
    Total,
    /// Light that reaches the surface straight from a light, emission and sky [W/(m² sr)].
    Direct,
    /// Light that has met at least one other surface before [W/(m² sr)].
    Indirect,
    /// Base colour.
    Albedo,
    /// World normal, mapped from −1..1 to 0..1.
    Normal,
    /// Distance from the eye \[m\].
    Depth,
}

impl Layer {
    /// Whether it shows light, rather than what the surfaces are.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Total | Self::Direct | Self::Indirect)
    }

    /// Whether it holds indirect light.
    pub fn shows_indirect(self) -> bool {
        matches!(self, Self::Total | Self::Indirect)
    }

    /// Its number in shaders: `LAYER`.
    pub(in crate::render) fn index(self) -> u32 {
        match self {
            Self::Total => 0,
            Self::Direct => 1,
            Self::Indirect => 2,
            Self::Albedo => 3,
            Self::Normal => 4,
            Self::Depth => 5,
        }
    }
}

/// The reference beside the drawn image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// The light that is traced, and how far.
    pub reference: ReferenceSettings,
    /// The part of it that the display image shows.
    pub shown: Shown,
}

/// How two images are shown in one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// The drawn image on the left of this share of the width, the traced one on the right: 0 shows the traced image
    /// alone, 1 the drawn one.
    Wipe(f32),
    /// Drawn minus traced: red too bright, blue too dark, in full colour at a mean error of this much [W/(m² sr)].
    Difference(f32),
}

/// Choices of the display step. They never touch a measured image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplaySettings {
    /// Tone map in place of the camera's; none: the camera's.
    pub tone_map: Option<ToneMap>,
    /// Exposure on top of the scene's and the camera's, as a power of two.
    pub exposure: f32,
    /// Exposes the image so that the mean of the logarithm of its luminance is middle grey (0.18), as Reinhard et al. (2002)
    /// do, whatever the camera says.
    pub auto_exposure: bool,
}

/// How edges for morphological anti-aliasing are found (thesis 5.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MlaaEdges {
    /// Colours as displayed: all edges that show, those within textures too.
    #[default]
    Color,
    /// Depth: outlines of what stands before something, whatever the colours. Blended surfaces have none.
    Depth,
    /// Normals: where surfaces of different directions meet, in front of one another or in a corner.
    Normal,
}

/// Over how many frames the light between surfaces is brought up to date, where frames are averaged and light or objects
/// change slowly. The surfels have their turns: a part of them casts its rays of the first bounce and of the links in a frame,
/// and a frame computes one more bounce of the light of the frame before in place of all bounces. A light that is switched, jumps
/// or changes by more than a few per cent from one frame to the next is computed whole, and so is all light eight frames after
/// the last change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UpdateRate {
    /// All in each frame.
    #[default]
    Whole,
    /// Half of the surfels in each frame.
    Half,
    /// A quarter of them.
    Quarter,
}

impl UpdateRate {
    /// From the highest rate to the lowest.
    pub const ALL: [Self; 3] = [Self::Whole, Self::Half, Self::Quarter];

    /// The rate by which all surfels have had their turn after so many frames; none: there is none.
    pub fn over_frames(frames: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.frames() == frames)
    }

    /// Frames after which all surfels have had their turn.
    pub fn frames(self) -> u32 {
        match self {
            Self::Whole => 1,
            Self::Half => 2,
            Self::Quarter => 4,
        }
    }
}

/// Settings of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Method of indirect light.
    pub gi: GiMethod,
    /// Settings of the path tracer where it is the method.
    pub reference: ReferenceSettings,
    /// The light that the image shows.
    pub only: Layer,
    /// Display exposure as a power of two. Never touches the radiance image.
    pub exposure: f32,
    /// Exposes the display image by its own brightness where the camera has no exposure of its own; `exposure` comes on
    /// top.
    pub auto_exposure: bool,
    /// Recompute everything, whatever the cache holds.
    pub no_cache: bool,
    /// A pass for each light, those without shadows too.
    pub each_light_alone: bool,
    /// Instant radiosity: the light of this virtual light alone, by its place in the list.
    pub virtual_light: Option<u32>,
    /// Instant radiosity: ways of so many particles of each source, drawn over the image as lines. Changes the
    /// radiance image.
    pub particle_paths: u32,
    /// Make the display image too: exposure, tone map, sRGB.
    pub display: bool,
    /// Smooth the edges of the display image (morphological anti-aliasing). Never touches the radiance image.
    pub mlaa: bool,
    /// How those edges are found. A path-traced frame has colours alone.
    pub mlaa_edges: MlaaEdges,
    /// How the display image is made.
    pub show: DisplaySettings,
    /// The tick of the scene's clock, for what varies with time alone: grain.
    pub moment: u64,
    /// Averages indirect light with that of the frames before, each with other random numbers: for interactive views. The
    /// image then depends on what was drawn before it. See [`Renderer::is_settling`](super::Renderer::is_settling).
    pub average: bool,
    /// How many images, this one among them, with other jitter each, the caller averages: what is filtered against noise
    /// is then filtered less. 1 for an image that stands for itself.
    pub images: u32,
    /// Shift of the pixel grid \[pixels\] of the image that gathers light for this one, as
    /// [`SceneView::jitter`](crate::scene::SceneView::jitter): this one takes its light where both see the same surface. Images
    /// that share it differ in their edges alone, and of a row of them the first one casts all rays. None: light is gathered
    /// at the image's own pixels. Nothing to methods that do not gather, nor where frames are averaged.
    pub gathered_at: Option<[f32; 2]>,
    /// Continues tracing the reference with every frame, and shows it beside the drawn image. Never touches the radiance
    /// image.
    pub beside: Option<Beside>,
    /// Over how many frames the light between surfaces is brought up to date while frames are averaged and light or objects
    /// change: see [`UpdateRate`].
    pub update: UpdateRate,
    /// What is drawn over the display image.
    pub debug: DebugSettings,
}

impl RenderSettings {
    /// Factor of the display on radiance: of the scene, the display and the camera.
    pub(super) fn exposure_factor(&self, lens: &Lens) -> f32 {
        power_of_two(self.exposure + self.show.exposure + lens.exposure.stops())
    }

    /// The same on top of an exposure that follows the image: of the display, and of the scene where it is the scene that
    /// asks for it.
    pub(super) fn correction_factor(&self, lens: &Lens) -> f32 {
        power_of_two(self.show.exposure + if self.scene_is_auto_exposed(lens) { self.exposure } else { 0.0 })
    }

    /// Whether the exposure follows the image.
    pub(super) fn is_auto_exposed(&self, lens: &Lens) -> bool {
        self.show.auto_exposure || lens.exposure == Exposure::Automatic || self.scene_is_auto_exposed(lens)
    }

    fn scene_is_auto_exposed(&self, lens: &Lens) -> bool {
        self.auto_exposure && lens.exposure == Exposure::Scene
    }
}

/// Between 2⁻⁶⁰ and 2⁶⁰, which shows anything that a float can hold.
fn power_of_two(stops: f32) -> f32 {
    if stops.is_finite() { stops.clamp(-60.0, 60.0).exp2() } else { 1.0 }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            gi: GiMethod::default(),
            reference: ReferenceSettings::default(),
            only: Layer::Total,
            exposure: 0.0,
            auto_exposure: false,
            no_cache: false,
            each_light_alone: false,
            virtual_light: None,
            particle_paths: 0,
            display: true,
            mlaa: false,
            mlaa_edges: MlaaEdges::default(),
            show: DisplaySettings::default(),
            moment: 0,
            average: false,
            images: 1,
            gathered_at: None,
            beside: None,
            update: UpdateRate::Whole,
            debug: DebugSettings::default(),
        }
    }
}
