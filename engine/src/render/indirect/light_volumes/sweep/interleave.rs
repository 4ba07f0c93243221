//! Which pixels rays are cast for: all of them, or where frames are averaged one of each square of four, another one in each
//! frame (interleaved sampling: Keller and Heidrich 2001). What lies between takes the light of those around it, see
//! `gather_upsample`.

use crate::graph::TextureDesc;
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::UVec2;

/// Pixels along the edge of a square of which one is gathered at.
const STRIDE: u32 = 2;
/// The order in which the pixels of a square take turns: any two that follow each other touch at a corner or an edge, and
/// two frames see both rows and both columns.
const TURNS: [[u32; 2]; 4] = [[0, 0], [1, 1], [1, 0], [0, 1]];

/// How many sparse frames the first one counts for, in which all pixels have all their rays.
const FIRST: f32 = 8.0;

/// The pixels of a frame that are gathered at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interleave {
    stride: u32,
    offset: [u32; 2],
    size: [u32; 2],
    /// How much the frame counts among others.
    weight: f32,
}

/// `Interleave` of `lib/interleave.wgsl`.
#[derive(ShaderType)]
pub(crate) struct InterleaveUniform {
    stride: u32,
    offset: UVec2,
    texels: UVec2,
}

impl Interleave {
    /// All pixels of a frame that stands for itself or is the first of its row, and a quarter of one that is averaged with many
    /// others because it is known how the light of its patches changes.
    pub fn new(frame: &Frame, has_patches: bool) -> Self {
        let size = frame.view.size;
        let (stride, offset, weight) = match frame.number().filter(|_| has_patches) {
            Some(0) => (1, [0, 0], FIRST),
            Some(number) if frame.history.follows_patches() => (STRIDE, TURNS[(number % 4) as usize], 1.0),
            _ => (1, [0, 0], 1.0),
        };
        Self { stride, offset, size, weight }
    }

    /// Whether it leaves pixels out.
    pub fn is_sparse(&self) -> bool {
        self.stride > 1
    }

    /// Share of the pixels that are gathered at.
    pub fn share(&self) -> f32 {
        1.0 / (self.stride * self.stride) as f32
    }

    /// Size of the image that holds a texel for each gathered pixel.
    pub fn texels(&self) -> [u32; 2] {
        self.size.map(|edge| edge.div_ceil(self.stride))
    }

    /// An image of that size of linear values, rgba32float.
    pub fn image_desc(&self, frame: &Frame) -> TextureDesc {
        let [width, height] = self.texels();
        TextureDesc { size: [width, height, 1], ..frame.image_desc() }
    }
    /// How much the frame counts among others.
    pub fn weight(&self) -> f32 {
        self.weight
    }

    /// A filter's radius in texels, from pixels.
    pub fn radius(&self, pixels: f32) -> f32 {
        pixels / self.stride as f32
    }

    /// The values that shaders read.
    pub fn uniform(&self) -> InterleaveUniform {
        InterleaveUniform { stride: self.stride, offset: self.offset.into(), texels: self.texels().into() }
    }
}
