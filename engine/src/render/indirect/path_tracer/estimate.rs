//! A traced image with what is known of its own noise.

use crate::measure::{Image, MeasureError, two_halves};
use crate::render::Layer;

/// Traced radiance [W/(m² sr)] in two independent halves: the means of the even and of the odd samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Light straight from lights, emission and sky that the camera sees.
    pub direct: [Image; 2],
    /// All other light.
    pub indirect: [Image; 2],
    /// Samples a pixel, of both halves together.
    pub samples: u32,
}

impl Estimate {
    /// Direct light.
    pub fn direct(&self) -> Image {
        mean(&self.direct)
    }

    /// Indirect light.
    pub fn indirect(&self) -> Image {
        mean(&self.indirect)
    }

    /// All light.
    pub fn total(&self) -> Image {
        mean(&self.halves(Layer::Total))
    }

    /// Both halves of a layer of light; of the total for layers that show no light.
    pub fn halves(&self, layer: Layer) -> [Image; 2] {
        match layer {
            Layer::Direct => self.direct.clone(),
            Layer::Indirect => self.indirect.clone(),
            _ => [0, 1].map(|half| sum(&self.direct[half], &self.indirect[half])),
        }
    }

    /// A layer's own noise: the standard error of its pixels over its mean.
    ///
    /// # Errors
    /// If the images hold NaN or infinity.
    pub fn noise(&self, layer: Layer) -> Result<f64, MeasureError> {
        let [a, b] = self.halves(layer);
        two_halves(&mean(&[a.clone(), b.clone()]), &a, &b).map(|measured| measured.noise)
    }
}

fn mean([a, b]: &[Image; 2]) -> Image {
    let mut image = sum(a, b);
    image.pixels_mut().iter_mut().flatten().for_each(|value| *value *= 0.5);
    image
}

fn sum(a: &Image, b: &Image) -> Image {
    let mut image = a.clone();
    for (sum, value) in image.pixels_mut().iter_mut().flatten().zip(b.values()) {
        *sum += value;
    }
    image
}
