//! Vertex attributes, in the formats of glTF and in those that exporters write besides.

use super::accessor::place;
use super::reader::{Job, Reader};
use super::remarks::Remarks;
use crate::assets::AssetError;
use gltf::accessor::{Accessor, DataType};
use gltf::mesh::Semantic;

/// The components of an attribute.
pub(super) struct Format<const N: usize> {
    /// Fewest and most components that glTF allows.
    allowed: (usize, usize),
    /// Fewest components of which the attribute can be made.
    least: usize,
    /// Values of those that are missing.
    usual: [f32; N],
    /// Types of the components.
    types: Types,
    /// Value of an element that is not finite; `None` if the reader mends it otherwise.
    replacement: Option<[f32; N]>,
}

/// Types of components that glTF allows.
#[derive(Clone, Copy, PartialEq)]
enum Types {
    /// Floats, and integers with `KHR_mesh_quantization`.
    Quantized,
    /// Floats and normalised unsigned integers, and other integers with `KHR_mesh_quantization`.
    Coordinates,
    /// Floats and normalised unsigned integers.
    Unit,
    /// Unsigned integers that stand for themselves.
    Whole,
}

pub(super) const POSITION: Format<3> =
    Format { allowed: (3, 3), least: 3, usual: [0.0; 3], types: Types::Quantized, replacement: None };
pub(super) const NORMAL: Format<3> = POSITION;
pub(super) const TANGENT: Format<4> =
    Format { allowed: (4, 4), least: 3, usual: [1.0; 4], types: Types::Quantized, replacement: None };
pub(super) const UV: Format<2> =
    Format { allowed: (2, 2), least: 2, usual: [0.0; 2], types: Types::Coordinates, replacement: Some([0.0; 2]) };
pub(super) const COLOR: Format<4> =
    Format { allowed: (3, 4), least: 3, usual: [1.0; 4], types: Types::Unit, replacement: Some([1.0; 4]) };
pub(super) const JOINTS: Format<4> =
    Format { allowed: (4, 4), least: 1, usual: [0.0; 4], types: Types::Whole, replacement: None };
pub(super) const WEIGHTS: Format<4> =
    Format { allowed: (4, 4), least: 1, usual: [0.0; 4], types: Types::Unit, replacement: None };
/// Offsets of a morph target.
pub(super) const OFFSET: Format<3> = Format { replacement: Some([0.0; 3]), ..POSITION };

impl Types {
    /// The fault of an accessor's type; `None` if it has none.
    fn fault(self, accessor: &Accessor, is_quantized: bool) -> Option<&'static str> {
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let is_unit = kind == DataType::F32 || normalized && matches!(kind, DataType::U8 | DataType::U16);
        match self {
            Self::Quantized if kind != DataType::F32 && !is_quantized => {
                Some("integers need the extension KHR_mesh_quantization; read all the same")
            }
            Self::Coordinates if !is_unit && !is_quantized => {
                Some("integers that are not normalised need the extension KHR_mesh_quantization; read all the same")
            }
            Self::Unit if !is_unit => Some("must be floats or normalised unsigned integers; taken as normalised"),
            Self::Whole if normalized || !matches!(kind, DataType::U8 | DataType::U16) => {
                Some("must be unsigned bytes or shorts; taken as such")
            }
            _ => None,
        }
    }

    /// Whether integers are shares of the largest one of their type.
    fn is_normalized(self, accessor: &Accessor) -> bool {
        match self {
            Self::Quantized | Self::Coordinates => accessor.normalized(),
            Self::Unit => true,
            Self::Whole => false,
        }
    }
}

impl Reader<'_> {
    /// An attribute of so many vertices, if it is there.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub(super) fn attribute<const N: usize>(
        &self,
        job: &Job,
        semantic: Semantic,
        count: usize,
        format: &Format<N>,
        remarks: &mut Remarks,
    ) -> Result<Option<Vec<[f32; N]>>, AssetError> {
        let Some(accessor) = job.primitive.get(&semantic) else { return Ok(None) };
        self.formatted(job, &accessor, count, format, remarks).map(Some)
    }

    /// The first `count` elements of an accessor, as a format says.
    ///
    /// # Errors
    /// As [`Self::attribute`].
    pub(super) fn formatted<const N: usize>(
        &self,
        job: &Job,
        accessor: &Accessor,
        count: usize,
        format: &Format<N>,
        remarks: &mut Remarks,
    ) -> Result<Vec<[f32; N]>, AssetError> {
        let fault = |problem: String| format!("{}, {}: {problem}", job.place, place(accessor));
        let (found, wanted) = (accessor.count(), format!("{} elements, but {count} positions", accessor.count()));
        let normalized = format.types.is_normalized(accessor);
        let read = self.buffers.loose_vectors(accessor, count, format.least, format.usual, normalized);
        // Those of an accessor that says too few may lie behind it: many readers take them without looking at its count.
        let mut values =
            read.map_err(|error| if found < count { self.fail(job, accessor, wanted.clone()) } else { error })?;
        if found != count {
            let outcome = if found > count { "the first ones are read" } else { "those that follow are read too" };
            remarks.fault(fault(format!("{wanted}; {outcome}")));
        }
        let components = accessor.dimensions().multiplicity();
        if !(format.allowed.0..=format.allowed.1).contains(&components) {
            let outcome = if components > N { "the first ones are read" } else { "the others are taken as usual" };
            remarks.fault(fault(format!("{components} components where {N} are wanted; {outcome}")));
        }
        if let Some(problem) = format.types.fault(accessor, self.quantized) {
            remarks.fault(fault(format!("{:?} components: {problem}", accessor.data_type())));
        }
        if let Some(replacement) = format.replacement {
            let broken = values.iter_mut().filter(|value| value.iter().any(|x| !x.is_finite()));
            let count = broken.map(|value| *value = replacement).count();
            if count > 0 {
                remarks.fault(fault(format!("{count} elements are not finite numbers; replaced")));
            }
        }
        Ok(values)
    }
}
