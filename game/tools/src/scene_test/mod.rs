//! Headless scene tests.
//!
//! A scene test is a file `NAME.test.ron` that says which scene to draw, when and how, and what must hold:
//!
//! ```ron
//! SceneTest(
//!     description: "The Cornell box, with the light straight above and at the red wall",
//!     scene: "cornell",
//!     times: [0, 1.5],
//!     size: (128, 128),
//!     camera: "Camera",
//!     gi: Clpv,
//!     set: ["clpv.quality=Low", "Spot light.light.intensity=12"],
//!     aa: 1,
//!     expect: (
//!         golden: (flip: 0.01),
//!         errors: [
//!             (
//!                 layer: Direct,
//!                 reference: Image("$LIGHTWELL_REFERENCE/cornell/direct.exr"),
//!                 max: (nrmse: 0.05, bias: 0.01),
//!                 at: [0],
//!             ),
//!         ],
//!         frames: [
//!             (ran: ["gbuffer", "rsm*"], counts: {"propagate*": (cells: 7168), "*": (draws: (max: 40))}),
//!             (frame: Again, idle: true),
//!         ],
//!         deterministic: true,
//!     ),
//! )
//! ```
//!
//! | field | meaning | if not said |
//! |---|---|---|
//! | `scene` | a file, from the test's folder on; the name of a shipped scene; or a file below `$LIGHTWELL_MODELS/` or `$LIGHTWELL_REFERENCE/` | must be said |
//! | `times` | times \[s\], drawn in this order | `[0]` |
//! | `size` | width and height \[pixels\] | `(128, 128)` |
//! | `camera` | name of a camera | the scene's primary one |
//! | `gi` | method of indirect light, as for `--gi` | the scene's |
//! | `trace` | samples, bounces and seed of `gi: Reference` | `(samples: 64)` and unlimited bounces |
//! | `set` | changes to the loaded scene, as for `--set` | none |
//! | `aa` | frames with shifted pixel grids that are averaged for an image | 1 |
//!
//! What is expected holds at all times of the test, or at those named by `at`:
//!
//! - `golden`: what a screen would show looks like `goldens/NAME_TIMEs.png` beside the test, up to a mean FLIP (`flip`,
//!   0.01 if not said) and one of 99 % of the pixels (`flip_p99`, 0.1 if not said). On adapters that are not software
//!   drivers both are twice as large.
//!   `lightwell test --bless` writes these images; look at them before they are committed.
//! - `errors`: bounds on `nrmse`, `bias` (in size), `rmse`, `p95`, `flip` and `flip_p99` of the total, direct or indirect light,
//!   measured on linear radiance ([`lightwell::measure`]) against a stored image, which may be larger by a whole factor
//!   (blocks of its pixels are then averaged), or against the path tracer's image of the same view,
//!   `Traced(samples: 256, bounces: 1, seed: 0)`; `nrmse` and `rmse` are then free of that image's own noise.
//! - `frames`: passes of the frame that must have `ran`, be `cached`, `culled` or `skipped`, or must have `not_run` for
//!   whatever reason; `idle`: none may run; and `counts` of `draws`, `dispatches`, `triangles`, `texels`, `cells`,
//!   `lights`, `injections`, `merges`, `paths` and `bytes`, exact (`7`) or bounded (`(min: 5, max: 9)`). Names may hold `*` for any text; counts are
//!   then summed, so that `"*"` is the whole frame. `frame: Again` speaks of a second frame in which nothing changed.
//! - `deterministic`: a second run, with a freshly loaded scene, a fresh renderer and the times in reverse order (after
//!   an image of one second later, where there is one time alone), gives the same bits. So an image depends neither on chance nor on what was drawn before it.
//!
//! That no pixel is NaN or infinite is always checked. Where something fails, the actual, the expected and the
//! difference image are written and named. A test whose scene needs a third-party model that is not there, or whose
//! reference lies in a folder that is not given, is skipped with the reason, unless something else in it fails.

mod count;
mod discover;
mod document;
mod frames;
mod images;
mod place;
mod pool;
mod run;

pub use discover::{TestCase, default_folder, discover, select};
pub use document::SceneTest;
pub use pool::{default_workers, run_all};
pub use run::{Options, Outcome, Report, run};

#[cfg(test)]
mod tests;
