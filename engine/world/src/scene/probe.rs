//! Points in the scene whose light is asked for.

use glam::Vec3;

/// A point whose light is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePoint {
    /// Where \[m\].
    pub position: Vec3,
    /// Normal of the surface that is lit; none: the mean over all normals.
    pub normal: Option<Vec3>,
}
