//! The invariants: how a deviation is counted, and how large it may be.

use super::setup::Method;

/// Something that holds for every scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Invariant {
    /// Every value is finite. Counted: those that are not.
    Finite,
    /// Without light there is exactly none. Counted: the brightest value.
    Dark,
    /// Twice the light is exactly twice the image. Counted: the largest difference, of the mean.
    Doubling,
    /// The image is proportional to the light, whatever its strength. Counted: nrmse against intensity 1.
    Intensity,
    /// A room of another size, lit so that its irradiance is the same, looks the same. Counted: nrmse against scale 1.
    Length,
    /// A room elsewhere looks the same. Counted: nrmse against the room at the origin.
    Position,
    /// A turned room looks the same. Counted: nrmse against the one along the axes.
    Orientation,
    /// A mirrored room gives the mirror image. Counted: nrmse.
    Mirror,
    /// A room turned by 90° looks the same. Counted: nrmse.
    QuarterTurn,
    /// A room moved by whole cells looks the same. Counted: nrmse.
    WholeCells,
    /// A room moved by a part of a cell looks nearly the same. Counted: nrmse.
    PartOfCell,
    /// The image of all lights is the sum of their images alone. Counted: nrmse.
    Superposition,
    /// The order of entities in the file does not matter. Counted: nrmse.
    Order,
    /// Two runs give the same bits. Counted: values that differ.
    Repeat,
    /// Caching never changes a bit. Counted: values that differ.
    Cache,
    /// Lights that are switched off leave nothing behind. Counted: the brightest value.
    SwitchedOff,
    /// Lights that are switched off and on again give the same bits. Counted: values that differ.
    Undo,
    /// A light moved by a little changes the image by a little. Counted: the mean change, of the mean, for a shift by
    /// one hundredth of the room.
    Moved,
    /// The image holds about as much light as the path tracer's. Counted: the relative difference of the means.
    Share,
    /// The image is about the path tracer's. Counted: nrmse, without that image's noise.
    Truth,
    /// What is bright and what is dark differs as much as in the path tracer's image. Counted: the share of its contrast
    /// that is missing.
    Contrast,
    /// A closed room holds no more light than its walls can send on: E·ρ/(1 − ρ). Counted: the relative excess.
    Energy,
    /// A closed room holds no less light than its walls send on. Counted: the relative deficit.
    Deficit,
    /// Broken input comes out as is stated of it: as a finite image, a black one, or an error that says what is wrong. Counted:
    /// those that do not.
    Degenerate,
}

impl Invariant {
    /// All of them.
    pub const ALL: [Self; 24] = [
        Self::Finite,
        Self::Dark,
        Self::Doubling,
        Self::Intensity,
        Self::Length,
        Self::Position,
        Self::Orientation,
        Self::Mirror,
        Self::QuarterTurn,
        Self::WholeCells,
        Self::PartOfCell,
        Self::Superposition,
        Self::Order,
        Self::Repeat,
        Self::Cache,
        Self::SwitchedOff,
        Self::Undo,
        Self::Moved,
        Self::Share,
        Self::Truth,
        Self::Contrast,
        Self::Energy,
        Self::Deficit,
        Self::Degenerate,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::Dark => "dark",
            Self::Doubling => "doubling",
            Self::Intensity => "intensity",
            Self::Length => "length",
            Self::Position => "position",
            Self::Orientation => "orientation",
            Self::Mirror => "mirror",
            Self::QuarterTurn => "quarter turn",
            Self::WholeCells => "whole cells",
            Self::PartOfCell => "part of a cell",
            Self::Superposition => "superposition",
            Self::Order => "order",
            Self::Repeat => "repeat",
            Self::Cache => "cache",
            Self::SwitchedOff => "switched off",
            Self::Undo => "undo",
            Self::Moved => "moved lamp",
            Self::Share => "share of light",
            Self::Truth => "truth",
            Self::Contrast => "contrast",
            Self::Energy => "energy",
            Self::Deficit => "deficit",
            Self::Degenerate => "degenerate",
        }
    }

    /// The largest deviation that is right. Of methods with noise most are counted in units of what other random numbers
    /// change.
    pub fn bound(self, method: Method) -> Bound {
        use Method::{Diffusion, Direct, Gather, HalfSweep, Reference, Slc, Sweep, Vpl};
        let exact = Bound { most: 0.0, why: None };
        match (self, method) {
            (Self::Order, Sweep | HalfSweep) => Bound::of(0.05, Some(SURFELS)),
            (Self::Intensity, Gather) => Bound::of(2e-3, Some(CHOICES)),
            (Self::Intensity, _) => Bound::of(1e-4, None),
            (Self::Superposition | Self::Order, Gather) => Bound::of(0.15, Some(CHOICES)),
            (image, Gather) if image.compares_places() => Bound::of(0.25, Some(CHOICES)),
            (Self::Share, Diffusion) => Bound::of(0.75, Some(THESIS)),
            (Self::Share, Direct | Reference) => Bound::of(0.05, None),
            (Self::Share, Gather | Vpl) => Bound::of(0.15, None),
            (Self::Share, _) => Bound::of(0.3, None),
            (Self::Truth, Diffusion) => Bound::of(0.9, Some(THESIS)),
            (Self::Truth, Reference) => Bound::of(1.5, Some(SAMPLES)),
            (Self::Truth, Direct | Gather) => Bound::of(0.3, None),
            (Self::Truth, _) => Bound::of(0.5, None),
            (Self::Contrast, _) => Bound::of(0.4, None),
            (Self::Deficit, Diffusion) => Bound::of(0.6, Some(THESIS)),
            (Self::Deficit, _) => Bound::of(0.1, None),
            (Self::Moved, _) => Bound::of(0.05, None),
            (Self::Energy, Sweep | HalfSweep | Gather) => Bound::of(0.08, Some(NEARER)),
            (Self::Energy, _) => Bound::of(0.05, Some(EVEN)),
            (Self::Superposition, Direct) => Bound::of(1e-4, None),
            (Self::Superposition, Diffusion) => Bound::of(0.05, Some(LOBES)),
            (Self::Superposition, Sweep | HalfSweep) => Bound::of(0.02, Some(MEANS)),
            (Self::Superposition, Slc) => Bound::of(0.01, Some(NUMBERS)),
            (Self::Order, Direct) => Bound::of(1e-6, Some(ROUNDING)),
            (Self::Order, Diffusion) => Bound::of(0.01, Some(TIES)),
            (Self::Order, Slc) => Bound::of(0.02, Some(NUMBERS)),
            (image, Vpl | Reference) if image.compares_places() => Bound::of(2.0, Some(NOISE)),
            (Self::Superposition | Self::Order, Vpl | Reference) => Bound::of(3.0, Some(PAIRS)),
            (Self::Mirror | Self::QuarterTurn, Direct | Diffusion | Sweep | HalfSweep | Slc) => {
                Bound::of(0.1, Some(TEXELS))
            }
            (Self::Orientation | Self::PartOfCell, Diffusion | Sweep | HalfSweep) => Bound::of(0.5, Some(CELLS)),
            (image, Direct | Slc) if image.compares_places() => Bound::of(0.1, Some(TEXELS)),
            (image, Diffusion | Sweep | HalfSweep) if image.compares_places() => Bound::of(0.3, Some(CELLS)),
            _ => exact,
        }
    }

    /// Whether it holds images of the room at two places, turns or sizes against each other.
    fn compares_places(self) -> bool {
        matches!(
            self,
            Self::Length
                | Self::Position
                | Self::Orientation
                | Self::Mirror
                | Self::QuarterTurn
                | Self::WholeCells
                | Self::PartOfCell
        )
    }
}

/// A bound, and why it is wider than the general one if it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The largest deviation that is right.
    pub most: f64,
    /// Why it is not less.
    pub why: Option<&'static str>,
}

impl Bound {
    fn of(most: f64, why: Option<&'static str>) -> Self {
        Self { most, why }
    }
}

const CHOICES: &str = "rays and lights are chosen by random numbers of the pixel, among what lies otherwise elsewhere";
const SURFELS: &str =
    "surfels are numbered as their objects stand in the file, and the random numbers of their rays go by that";
const THESIS: &str = "the thesis's transport loses most of the light";
const SAMPLES: &str = "noise of its own few samples";
const NOISE: &str = "in units of the difference that other random numbers make";
const PAIRS: &str = "in units of the difference that other random numbers make; of dozens of such differences one is nearly three times another";
const NUMBERS: &str = "lights are numbered as they stand in the file, and their random numbers go by that";
const EVEN: &str = "the series holds on the mean over all walls, an image is the mean over what it shows";
const NEARER: &str =
    "as for the others; and light is sent and found half a cell before the surfaces, which so are nearer to each other";
const LOBES: &str = "lobes of light are cut off below zero, of all lamps together";
const MEANS: &str = "what the surfaces of a cell send out leaves around one mean normal, of all lamps together";
const ROUNDING: &str = "light of three lamps is added in another order, which rounds otherwise";
const TIES: &str = "of two views that see as much of a cell the first one tells its orientation";
const TEXELS: &str = "a sun's map is laid on a grid of texels in the world, over which the edges of shadows shift";
const CELLS: &str = "the room lies otherwise among the cells, eight to sixteen of which are as wide as it";
