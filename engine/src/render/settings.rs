//! How a frame is to be drawn.

use super::reference::TraceSettings;

/// Method of indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GiMethod {
    /// Direct light only.
    None,
    /// Cascaded light propagation volumes, as the scene's `Clpv` component sets them; without one, none.
    #[default]
    Clpv,
    /// Instant radiosity, as the scene's `InstantRadiosity` component sets it; without one, with its defaults.
    Vpl,
    /// Stochastic light culling, as the scene's `StochasticLightCulling` component sets it; without one, by default.
    Slc,
    /// Path tracing, the reference: all light, direct and indirect.
    Reference(ReferenceSettings),
}

/// Settings of a path-traced image that is shown as a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ReferenceSettings {
    /// What is traced.
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

/// What the image shows.
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
}

/// Settings of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Method of indirect light.
    pub gi: GiMethod,
    /// What the image shows.
    pub only: Layer,
    /// Display exposure as a power of two. Never touches the radiance image.
    pub exposure: f32,
    /// Recompute everything, whatever the cache holds.
    pub no_cache: bool,
    /// Instant radiosity: the light of this virtual light alone, by its place in the list.
    pub virtual_light: Option<u32>,
    /// Instant radiosity: ways of so many particles of each source, drawn over the image as lines. Changes the
    /// radiance image.
    pub particle_paths: u32,
    /// Make the display image too: exposure, tone map, sRGB.
    pub display: bool,
    /// Smooth the edges of the display image (morphological anti-aliasing). Never touches the radiance image.
    pub mlaa: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            gi: GiMethod::default(),
            only: Layer::Total,
            exposure: 0.0,
            no_cache: false,
            virtual_light: None,
            particle_paths: 0,
            display: true,
            mlaa: false,
        }
    }
}
