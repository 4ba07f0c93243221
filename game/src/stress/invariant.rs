//! What must hold, how a deviation from it is counted, and how large it may be.

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
    /// The light of all lamps is the sum of what they give alone. Counted: nrmse.
    Superposition,
    /// The order of entities in the file does not matter. Counted: nrmse.
    Order,
    /// Two runs give the same bits. Counted: values that differ.
    Repeat,
    /// Caching never changes a bit. Counted: values that differ.
    Cache,
    /// Lamps switched off leave nothing behind. Counted: the brightest value.
    SwitchedOff,
    /// Lamps switched off and on again give the same bits. Counted: values that differ.
    Undo,
    /// A lamp moved by a little changes the image by a little. Counted: the mean change, of the mean, for a shift by
    /// one hundredth of the room.
    Moved,
    /// A closed room holds no more light than its walls can send on: E·ρ/(1 − ρ). Counted: the relative excess.
    Energy,
    /// Broken input gives a finite image or an error that says what is wrong. Counted: those that do neither.
    Degenerate,
}

impl Invariant {
    /// All of them.
    pub const ALL: [Self; 20] = [
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
        Self::Energy,
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
            Self::Energy => "energy",
            Self::Degenerate => "degenerate",
        }
    }

    /// The largest deviation that is right.
    pub fn bound(self, method: Method) -> Bound {
        let random = |bound| if method.is_random() { Bound::because(2.0, NOISE) } else { Bound::at(bound) };
        match self {
            Self::Intensity => Bound::at(1e-4),
            Self::Superposition => random(1e-4),
            Self::Length | Self::Mirror | Self::QuarterTurn | Self::WholeCells => random(1e-3),
            Self::Position => random(1e-2),
            Self::Orientation | Self::PartOfCell => random(0.1),
            Self::Order => random(1e-6),
            Self::Moved => Bound::at(0.1),
            Self::Energy => Bound::at(0.01),
            _ => Bound::at(0.0),
        }
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

const NOISE: &str = "in units of the difference that other random numbers make";

impl Bound {
    fn because(most: f64, why: &'static str) -> Self {
        Self { most, why: Some(why) }
    }

    fn at(most: f64) -> Self {
        Self { most, why: None }
    }
}
