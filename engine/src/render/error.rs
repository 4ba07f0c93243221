//! Errors of frames.

use super::rays::RayError;
use crate::graph::GraphError;

/// Why a frame could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The image has no pixels, or more than the device can hold.
    #[error("image size {width}x{height} is not between 1x1 and {limit}x{limit}, the limit of this adapter")]
    Size {
        /// Asked for.
        width: u32,
        /// Asked for.
        height: u32,
        /// Largest edge that the adapter can do.
        limit: u32,
    },
    /// A camera has values that do not define an image.
    #[error("camera `{camera}`: {what}")]
    Camera {
        /// Its name.
        camera: String,
        /// The fault and help.
        what: String,
    },
    /// A method of indirect light that the renderer does not know.
    #[error("there is no method of indirect light `{name}`; there are {known}")]
    UnknownMethod {
        /// Asked for.
        name: &'static str,
        /// Those that there are.
        known: String,
    },
    /// A method of indirect light refuses its settings or the scene.
    #[error("{what}")]
    Method {
        /// The fault and help.
        what: String,
        /// Why, where there is more to say.
        source: Option<Box<dyn std::error::Error + Send + Sync>>,
    },
    /// The scene does not fit the device as rays need it.
    #[error(transparent)]
    Rays(#[from] RayError),
    /// A pass failed, or the frame was put together wrongly.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The device is gone: it was taken away, or its driver has failed.
    #[error("the graphics device was lost: {0}; open the scene again to take up another one")]
    Lost(String),
    /// The device reported errors while drawing.
    #[error("the graphics device reported: {0}")]
    Device(String),
}

impl RenderError {
    /// A method's refusal: what is wrong and what would be right.
    pub fn method(what: impl Into<String>) -> Self {
        Self::Method { what: what.into(), source: None }
    }
}
