//! What all of the engine shares: boxes and rays, transforms and projections, identities, limits, and the choice of a method of
//! indirect light. Imports nothing of it.

mod bounds;
mod color;
mod gi_method;
mod id;
mod light_kind;
mod limits;
mod projection;
mod ray;
mod replace_file;
mod transform;

pub use bounds::{Aabb, Frustum};
pub use color::{srgb_decode, srgb_encode};
pub use gi_method::GiMethod;
pub use id::{AssetId, SceneId};
pub use light_kind::LightKind;
pub use limits::MAX_IMAGE_SIZE;
pub use projection::{DEFAULT_NEAR, ORTHOGRAPHIC_HEIGHTS, ViewProjection, orthographic, perspective};
pub use ray::{Ray, intersect_triangle};
pub use replace_file::replace_file;
#[doc(hidden)]
pub use replace_file::{beside, discard, write_in_place_of};
pub use transform::{GlobalTransform, Orientation, Transform, look_rotation};
