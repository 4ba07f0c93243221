//! Which debug views there are, and which of them are on.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// What can be drawn over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DebugView {
    /// Reach and shape of all lights.
    Lights,
    /// What the other cameras see.
    Cameras,
    /// Boxes of the cascades.
    Cascades,
    /// Which cascade lights a pixel, and its cells.
    Coverage,
    /// Light in the cells of a cascade, as spheres.
    Light,
    /// What stops light in the cells of a cascade, by direction, as spheres.
    Blockers,
    /// Cells with surfaces in them, in the colour of their reflectance.
    Voxels,
    /// Boxes of one level of the ray hierarchy.
    Bvh,
    /// Virtual lights of instant radiosity or stochastic light culling.
    VirtualLights,
    /// Directions that light is swept along.
    Directions,
}

impl DebugView {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Lights,
        Self::Cameras,
        Self::Cascades,
        Self::Coverage,
        Self::Light,
        Self::Blockers,
        Self::Voxels,
        Self::Bvh,
        Self::VirtualLights,
        Self::Directions,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Cameras => "cameras",
            Self::Cascades => "cascades",
            Self::Coverage => "coverage",
            Self::Light => "light",
            Self::Blockers => "blockers",
            Self::Voxels => "voxels",
            Self::Bvh => "bvh",
            Self::VirtualLights => "virtual-lights",
            Self::Directions => "directions",
        }
    }

    /// What it shows, in a line.
    pub fn help(self) -> &'static str {
        match self {
            Self::Lights => "reach and shape of all lights; without a range: as far as 0.1 W/m² reach",
            Self::Cameras => "what the other cameras see",
            Self::Cascades => "boxes of the light volumes, finest red, then green, blue, yellow",
            Self::Coverage => "which light volume lights a pixel, with its cells",
            Self::Light => "light in the cells of one light volume, as spheres",
            Self::Blockers => "what stops light in the cells of one light volume, by direction, as spheres",
            Self::Voxels => "cells with surfaces in them, in the colour of their reflectance",
            Self::Bvh => "boxes of one level of the ray hierarchy",
            Self::VirtualLights => "virtual lights, in the colour of their light",
            Self::Directions => "directions that light is swept along",
        }
    }
}

impl fmt::Display for DebugView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for DebugView {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|view| view.name() == text);
        known.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no debug view `{text}`; there are {names}")
        })
    }
}

/// A line in world space: `Line` of `debug/lines.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Line {
    /// One end \[m\].
    pub from: [f32; 3],
    /// sRGB-encoded bytes, red lowest, alpha highest.
    pub color: u32,
    /// The other end \[m\].
    pub to: [f32; 3],
    /// Width \[pixels\]; below 0: the same, before all surfaces.
    pub width: f32,
}

impl Line {
    /// A line of an sRGB-encoded colour.
    pub fn new(from: Vec3, to: Vec3, color: Vec3) -> Self {
        let [r, g, b] = (color.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round().to_array().map(|c| c as u32);
        let color = r | g << 8 | b << 16 | 255 << 24;
        Self { from: from.into(), color, to: to.into(), width: 1.5 }
    }

    /// The same before all surfaces.
    pub fn on_top(self) -> Self {
        Self { width: -self.width.abs(), ..self }
    }
}

/// A target of a pass that is laid over the image, and what is shown of it.
///
/// As text: its name, then what is given of `@` slice, `/` mip level, `.` channel (`r`, `g`, `b`, `a`) and `=` range of
/// values, in this order: `rsm Sun@2`, `gbuffer depth.r=0..0.1`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownTarget {
    /// Its name in the render graph.
    pub name: String,
    /// Layer of an array or slice of a volume; beyond the last: the last.
    pub slice: u32,
    /// Mip level; beyond the last: the last.
    pub mip: u32,
    /// The channel that is shown in grey, 0 to 3; none: the first three as a colour.
    pub channel: Option<u8>,
    /// Values that become black and white; none: the least and the largest.
    pub range: Option<[f32; 2]>,
}

impl ShownTarget {
    /// Equal for equal ones.
    pub fn key(&self) -> impl std::hash::Hash + use<> {
        (self.name.clone(), self.slice, self.mip, self.channel, self.range.map(|range| range.map(f32::to_bits)))
    }
}

impl FromStr for ShownTarget {
    type Err = String;

    /// What cannot be read as an ending belongs to the name: entities may have any.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut target = Self::default();
        let (text, range) = ending(text, '=', read_range);
        let (text, channel) = ending(text, '.', |name| "rgba".find(name).filter(|_| name.len() == 1));
        let (text, mip) = ending(text, '/', |number| number.parse().ok());
        let (text, slice) = ending(text, '@', |number| number.parse().ok());
        if text.is_empty() {
            return Err("the name of a target is missing; `lightwell explain SCENE` lists those of a scene".into());
        }
        target.name = text.to_owned();
        target.range = range;
        target.channel = channel.map(|index| index as u8);
        (target.mip, target.slice) = (mip.unwrap_or(0), slice.unwrap_or(0));
        Ok(target)
    }
}

/// The text before a mark and the value after it, if that can be read.
fn ending<T>(text: &str, mark: char, read: impl Fn(&str) -> Option<T>) -> (&str, Option<T>) {
    let parts = text.rsplit_once(mark).and_then(|(before, after)| Some((before, read(after)?)));
    parts.map_or((text, None), |(before, value)| (before, Some(value)))
}

fn read_range(text: &str) -> Option<[f32; 2]> {
    let (low, high) = text.split_once("..")?;
    let range = [low.parse::<f32>().ok()?, high.parse::<f32>().ok()?];
    (range.iter().all(|end| end.is_finite()) && range[0] < range[1]).then_some(range)
}

impl fmt::Display for ShownTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        if self.slice > 0 {
            write!(f, "@{}", self.slice)?;
        }
        if self.mip > 0 {
            write!(f, "/{}", self.mip)?;
        }
        if let Some(name) = self.channel.and_then(|index| "rgba".chars().nth(index.into())) {
            write!(f, ".{name}")?;
        }
        self.range.map_or(Ok(()), |[low, high]| write!(f, "={low}..{high}"))
    }
}

/// What is drawn over the image.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugSettings {
    /// Views that are on.
    pub views: BTreeSet<DebugView>,
    /// Cascade whose cells are shown, 0 the finest; beyond the last: the last.
    pub cascade: u32,
    /// Level of the ray hierarchy, 0 the box around everything.
    pub bvh_level: u32,
    /// Primitives with an outline: the low 32 bits of their identities, ascending.
    pub outlined: Vec<u32>,
    /// Lines that a game draws.
    pub lines: Vec<Line>,
    /// Targets of passes, laid side by side from the lower left.
    pub targets: Vec<ShownTarget>,
}

impl Default for DebugSettings {
    fn default() -> Self {
        Self {
            views: BTreeSet::new(),
            cascade: 0,
            bvh_level: 8,
            outlined: Vec::new(),
            lines: Vec::new(),
            targets: Vec::new(),
        }
    }
}

impl DebugSettings {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty() && self.outlined.is_empty() && self.lines.is_empty() && self.targets.is_empty()
    }

    /// Whether a view is on.
    pub fn shows(&self, view: DebugView) -> bool {
        self.views.contains(&view)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_are_refused() {
        for view in DebugView::ALL {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        let error = "lamps".parse::<DebugView>().expect_err("no such view");
        assert!(error.contains("lamps") && error.contains("virtual-lights"), "{error}");
    }

    #[test]
    fn targets_are_read_back_whatever_their_name() {
        let target = |text: &str| text.parse::<ShownTarget>().expect("a target");
        let all = target("rsm Sun@2/1.g=-0.5..2");
        assert_eq!((all.name.as_str(), all.slice, all.mip, all.channel), ("rsm Sun", 2, 1, Some(1)));
        assert_eq!(all.range, Some([-0.5, 2.0]));
        for text in ["axes, cascade 0", "shadow a.b@c", "gbuffer depth=0..0.1", "rsm Sun@2/1.g=-0.5..2", "x=1..NaN"] {
            assert_eq!(target(text).to_string(), text);
        }
        assert_eq!(target("shadow a.b@c").name, "shadow a.b@c", "a name is not cut");
        assert_eq!(target("x=1..0").range, None, "an empty range is part of the name, which is then not found");
        assert!("@2".parse::<ShownTarget>().is_err());
    }
}
