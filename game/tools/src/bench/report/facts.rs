//! The facts that tables, plots and words share: each variant of a scene with its time and error.

use crate::bench::pareto;
use crate::bench::plot::Dot;
use crate::bench::results::{LayerError, Mode, Results, Timing, VariantFigures};

/// A layer whose error is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// All light.
    Total,
    /// Indirect light.
    Indirect,
}

impl Light {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Indirect => "indirect",
        }
    }
}

/// One variant in one scene: time of a whole frame, and errors averaged over the scene's times.
pub struct Fact<'a> {
    /// The variant.
    pub variant: &'a VariantFigures,
    /// Times, everything computed.
    pub timing: &'a Timing,
    /// Time of the image whose errors are taken, all that are averaged together [ms], if it is known.
    pub image_time: Option<f64>,
    /// Errors of all light, means over the times.
    pub total: LayerError,
    /// Errors of direct light.
    pub direct: LayerError,
    /// Errors of indirect light.
    pub indirect: LayerError,
}

impl Fact<'_> {
    /// Errors of a layer.
    pub fn of(&self, light: Light) -> &LayerError {
        match light {
            Light::Total => &self.total,
            Light::Indirect => &self.indirect,
        }
    }

    /// Time of a frame from start to end, on the clock that path tracing is measured with too [ms].
    pub fn time(&self) -> f64 {
        self.timing.wall.median
    }

    /// The share of the device's passes [ms].
    pub fn device_time(&self) -> f64 {
        self.timing.total.median
    }
}

/// Indirect bounces of the references that plots and tables show: the first that were measured.
pub fn bounces(results: &Results) -> Option<u32> {
    results.errors.first().and_then(|error| error.bounces)
}

/// The timings of a scene that plots show: at the first size.
pub fn timing<'a>(results: &'a Results, scene: &str, variant: &str, mode: Mode) -> Option<&'a Timing> {
    let of_scene = || results.timings.iter().filter(|t| t.scene == scene);
    let size = of_scene().filter(|t| t.mode == Mode::Full).map(|timing| timing.size).min()?;
    of_scene().find(|timing| timing.variant == variant && timing.size == size && timing.mode == mode)
}

/// All variants of a scene whose time and error are known, in the order of the results. `swept`: the points of
/// sweeps, or all others.
pub fn of<'a>(results: &'a Results, scene: &str, swept: bool) -> Vec<Fact<'a>> {
    let bounces = bounces(results);
    let belongs = |variant: &&VariantFigures| {
        variant.sweep.is_some() == swept && variant.scene.as_deref().is_none_or(|of| of == scene)
    };
    let fact = |variant: &'a VariantFigures| {
        let errors = || {
            let of_variant = results.errors.iter().filter(|e| e.scene == scene && e.variant == variant.name);
            of_variant.filter(|error| error.bounces == bounces)
        };
        let images = errors().next()?.aa;
        let of_mode = |mode| timing(results, scene, &variant.name, mode);
        let timing = of_mode(Mode::Full)?;
        let more = match images {
            0 | 1 => Some(0.0),
            _ => of_mode(Mode::Shifted).map(|shifted| f64::from(images - 1) * shifted.wall.median),
        };
        Some(Fact {
            variant,
            timing,
            image_time: more.map(|more| timing.wall.median + more),
            total: mean(errors().map(|error| &error.total)),
            direct: mean(errors().map(|error| &error.direct)),
            indirect: mean(errors().map(|error| &error.indirect)),
        })
    };
    results.variants.iter().filter(belongs).filter_map(fact).collect()
}

/// Mean over the times: of squares where errors are roots of them.
pub fn mean<'a>(errors: impl Iterator<Item = &'a LayerError> + Clone) -> LayerError {
    let count = errors.clone().count().max(1) as f64;
    let plain = |value: fn(&LayerError) -> f64| errors.clone().map(value).sum::<f64>() / count;
    let root = |value: fn(&LayerError) -> f64| (errors.clone().map(|e| value(e).powi(2)).sum::<f64>() / count).sqrt();
    LayerError {
        mean: plain(|e| e.mean),
        rmse: root(|e| e.rmse),
        nrmse: root(|e| e.nrmse),
        noisy_nrmse: root(|e| e.noisy_nrmse),
        bias: plain(|e| e.bias),
        p95: plain(|e| e.p95),
        flip: plain(|e| e.flip),
        noise: root(|e| e.noise),
    }
}

/// The points of a plot of a scene, the Pareto front marked.
pub fn dots(facts: &[Fact], light: Light) -> Vec<Dot> {
    let mut dots: Vec<Dot> = facts
        .iter()
        .map(|fact| Dot {
            label: fact.variant.name.clone(),
            time: fact.time(),
            range: (fact.timing.wall.min, fact.timing.wall.max),
            error: fact.of(light).nrmse,
            baseline: is_baseline(fact),
            on_front: false,
        })
        .filter(|dot| dot.time > 0.0 && dot.error > 0.0 && dot.error.is_finite())
        .collect();
    let points: Vec<(f64, f64)> = dots.iter().map(|dot| (dot.time, dot.error)).collect();
    pareto::front(&points).into_iter().for_each(|index| dots[index].on_front = true);
    dots
}

/// Plain path tracing is the baseline; other traced variants are points like any other.
pub fn is_baseline(fact: &Fact) -> bool {
    fact.variant.traced && fact.variant.name.starts_with("path tracing ")
}

/// The curve of plain path tracing: (time, error).
pub fn baseline(facts: &[Fact], light: Light) -> Vec<(f64, f64)> {
    facts.iter().filter(|fact| is_baseline(fact)).map(|fact| (fact.time(), fact.of(light).nrmse)).collect()
}
