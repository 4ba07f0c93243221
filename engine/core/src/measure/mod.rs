//! Images as numbers: linear RGB images in files, and how far one is from another.
//!
//! One definition of every error metric, used by the program, the tests and the benchmarks alike. All metrics
//! work on unexposed linear RGB, over all pixels and channels, without any gain fitting. `a` is the image under
//! test and `r` the reference:
//!
//! | name    | definition                                        |
//! |---------|---------------------------------------------------|
//! | `rmse`  | sqrt(mean((a − r)²))                              |
//! | `nrmse` | rmse / mean(r)                                    |
//! | `bias`  | mean(a) / mean(r) − 1                             |
//! | `p95`   | 95th percentile of abs(a − r), over mean(r)       |
//! | `flip`  | mean of the published FLIP on tone-mapped images  |
//! | `flip_p99` | 99th percentile of its pixels |
//!
//! Where mean(r) = 0 nothing can be relative to it: the image must then be exactly zero, and whether it is, is
//! what is reported.
//!
//! The features `exr` and `flip` of this crate add OpenEXR files and FLIP; both are off by default.

mod capacity;
mod difference;
#[cfg_attr(not(feature = "exr"), path = "no_exr.rs")]
mod exr_file;
mod figure;
mod file;
mod flip;
mod image;
mod metrics;

pub use crate::core::{srgb_decode, srgb_encode};
#[doc(hidden)]
pub use capacity::may_hold;
pub use difference::difference_picture;
#[doc(hidden)]
pub use exr_file::check_exr;
pub use figure::{displayed, figure};
pub use file::{ImageFileError, read_image, write_image, write_png_rgb8};
pub use flip::flip_exposure;
#[cfg(feature = "flip")]
pub use flip::{FlipMap, flip, flip_displayed};
pub use image::Image;
pub use metrics::{Comparison, MeasureError, TwoHalves, compare, two_halves};
