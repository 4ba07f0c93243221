//! Typed data in buffers. Every range is checked before it is read, and before memory for it is allocated.

use crate::assets::AssetError;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::View;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Most elements of an accessor that is not backed by a buffer view (all of its values are zero but the sparse ones).
const MAX_UNBACKED: usize = 1 << 24;

/// The loaded buffers of an asset.
pub(super) struct Buffers<'a> {
    pub path: &'a Path,
    pub data: Vec<Cow<'a, [u8]>>,
    /// Buffer views that were compressed, by index.
    pub decoded: HashMap<usize, Vec<u8>>,
    /// Decoded contents of accessors of compressed primitives, tightly packed, by index.
    pub replaced: HashMap<usize, Vec<u8>>,
    /// Accessors whose compressed contents are broken, and that have no others.
    pub lost: HashSet<usize>,
}

/// A checked range of elements.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Elements<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        let size = self.size;
        self.bytes.chunks(self.stride).map(move |c| &c[..size])
    }
}

/// Names an accessor in messages.
pub(super) fn place(accessor: &Accessor) -> String {
    match accessor.name() {
        Some(name) => format!("accessor {} \"{name}\"", accessor.index()),
        None => format!("accessor {}", accessor.index()),
    }
}

fn view_place(view: &View) -> String {
    format!("buffer view {}", view.index())
}

fn beyond_end(view: &View, found: usize) -> String {
    let (offset, length, buffer) = (view.offset(), view.length(), view.buffer().index());
    format!("bytes {offset} + {length} lie beyond the end of buffer {buffer} ({found} bytes)")
}

impl<'a> Buffers<'a> {
    /// Buffers of which nothing is compressed.
    pub fn new(path: &'a Path, data: Vec<Cow<'a, [u8]>>) -> Self {
        Self { path, data, decoded: HashMap::new(), replaced: HashMap::new(), lost: HashSet::new() }
    }
}

impl Buffers<'_> {
    fn fail<T>(&self, place: &str, problem: impl Into<String>) -> Result<T, AssetError> {
        Err(AssetError::format(self.path, place, problem))
    }

    /// Bytes of a buffer view.
    pub fn view(&self, view: &View) -> Result<&[u8], AssetError> {
        if let Some(bytes) = self.decoded.get(&view.index()) {
            return Ok(bytes);
        }
        let (buffer, offset, length) = (view.buffer().index(), view.offset(), view.length());
        let data = self.data.get(buffer).map_or(&[] as &[u8], |d| d.as_ref());
        // What lies beyond the end is missed by the accessors that need it.
        let end = offset.checked_add(length).map(|end| end.min(data.len()));
        match end.and_then(|end| data.get(offset..end)).filter(|bytes| !bytes.is_empty() || length == 0) {
            Some(bytes) => Ok(bytes),
            None => self.fail(&view_place(view), beyond_end(view, data.len())),
        }
    }

    /// Checks that a buffer view ends within its buffer.
    pub fn check_length(&self, view: &View) -> Result<(), AssetError> {
        let found = self.data.get(view.buffer().index()).map_or(0, |data| data.len());
        let is_inside = view.offset().checked_add(view.length()).is_some_and(|end| end <= found);
        match is_inside || self.decoded.contains_key(&view.index()) {
            true => Ok(()),
            false => self.fail(&view_place(view), beyond_end(view, found)),
        }
    }

    fn elements(
        &self,
        place: &str,
        view: &View,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<Elements<'_>, AssetError> {
        let bytes = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return self.fail(place, format!("stride {stride} of its buffer view is less than its {size} bytes"));
        }
        let end = count.checked_sub(1).and_then(|n| n.checked_mul(stride)).and_then(|n| n.checked_add(size));
        let range = end.and_then(|n| n.checked_add(offset)).and_then(|end| bytes.get(offset..end));
        match range {
            Some(bytes) => Ok(Elements { bytes, stride, size }),
            None => self.fail(
                place,
                format!(
                    "{count} elements of {stride} bytes at {offset} do not fit its buffer view ({} bytes)",
                    bytes.len()
                ),
            ),
        }
    }

    /// Checks that all data the accessor refers to is there, and what reading passes over.
    pub fn check_all(&self, accessor: &Accessor) -> Result<(), AssetError> {
        let count = accessor.count();
        self.check(accessor, count)?;
        let Some(sparse) = accessor.sparse() else { return Ok(()) };
        let (place, indices) = (place(accessor), sparse.indices());
        let at =
            self.elements(&place, &indices.view(), indices.offset(), sparse.count(), indices.index_type().size())?;
        match at.iter().map(unsigned).find(|index| *index as usize >= count) {
            Some(index) => self.fail(&place, format!("sparse index {index} of {count} elements")),
            None => Ok(()),
        }
    }

    /// Checks that so many elements of an accessor are there.
    fn check(&self, accessor: &Accessor, count: usize) -> Result<(), AssetError> {
        let (place, size) = (place(accessor), accessor.size());
        if count == 0 {
            return self.fail(&place, "has no elements");
        }
        if self.replaced.contains_key(&accessor.index()) {
            return Ok(());
        }
        if self.lost.contains(&accessor.index()) {
            return self.fail(&place, "its compressed contents are broken");
        }
        match accessor.view() {
            Some(view) => {
                self.elements(&place, &view, accessor.offset(), count, size)?;
            }
            None if count > MAX_UNBACKED => {
                return self.fail(&place, format!("{count} elements without a buffer view; at most {MAX_UNBACKED}"));
            }
            None => {}
        }
        let Some(sparse) = accessor.sparse() else {
            return Ok(());
        };
        if sparse.count() == 0 || sparse.count() > count {
            return self.fail(&place, format!("{} sparse values for {count} elements", sparse.count()));
        }
        let (indices, values) = (sparse.indices(), sparse.values());
        self.elements(&place, &indices.view(), indices.offset(), sparse.count(), indices.index_type().size())?;
        self.elements(&place, &values.view(), values.offset(), sparse.count(), size)?;
        Ok(())
    }

    /// Reads the first `count` elements, sparse ones put in, each decoded by `decode`. A count beyond that of the accessor reads
    /// on in its buffer view.
    fn read<T: Clone>(
        &self,
        accessor: &Accessor,
        count: usize,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, AssetError> {
        self.check(accessor, count)?;
        let (place, size) = (place(accessor), accessor.size());
        if let Some(bytes) = self.replaced.get(&accessor.index()) {
            let elements: Vec<T> = bytes.chunks_exact(size).take(count).map(decode).collect();
            let is_whole = elements.len() == count;
            return if is_whole { Ok(elements) } else { self.fail(&place, format!("has less than {count} elements")) };
        }
        let mut out: Vec<T> = match accessor.view() {
            Some(view) => self.elements(&place, &view, accessor.offset(), count, size)?.iter().map(&decode).collect(),
            None => vec![zero; count],
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(out);
        };
        let (indices, values) = (sparse.indices(), sparse.values());
        let index_size = indices.index_type().size();
        let at = self.elements(&place, &indices.view(), indices.offset(), sparse.count(), index_size)?;
        let values = self.elements(&place, &values.view(), values.offset(), sparse.count(), size)?;
        for (index, value) in at.iter().map(unsigned).zip(values.iter()) {
            // One beyond the end is noted when all is checked.
            if let Some(slot) = out.get_mut(index as usize) {
                *slot = decode(value);
            }
        }
        Ok(out)
    }

    /// Reads vectors of `N` components as floats; integers are normalised where the accessor says so.
    pub fn vectors<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f32; N]>, AssetError> {
        let found = accessor.dimensions();
        if found.multiplicity() != N || matches!(found, Dimensions::Mat2) {
            return self.fail(&place(accessor), format!("holds {found:?} where vectors of {N} are wanted"));
        }
        self.components(accessor, accessor.count(), [0.0; N], accessor.normalized())
    }

    /// Reads `count` vectors of at least `least` components. Those beyond `N` are dropped, and those that are missing are taken
    /// from `usual`.
    pub fn loose_vectors<const N: usize>(
        &self,
        accessor: &Accessor,
        count: usize,
        least: usize,
        usual: [f32; N],
        normalized: bool,
    ) -> Result<Vec<[f32; N]>, AssetError> {
        let found = accessor.dimensions();
        if found.multiplicity() < least || matches!(found, Dimensions::Mat2 | Dimensions::Mat3 | Dimensions::Mat4) {
            return self.fail(&place(accessor), format!("holds {found:?} where vectors of {N} are wanted"));
        }
        self.components(accessor, count, usual, normalized)
    }

    fn components<const N: usize>(
        &self,
        accessor: &Accessor,
        count: usize,
        usual: [f32; N],
        normalized: bool,
    ) -> Result<Vec<[f32; N]>, AssetError> {
        let (kind, found) = (accessor.data_type(), accessor.dimensions().multiplicity());
        let size = kind.size();
        if kind == DataType::F32 && found >= N {
            return self.read(accessor, count, [0.0; N], |b| std::array::from_fn(|i| float(&b[4 * i..])));
        }
        let one = |b: &[u8], i: usize| if i < found { component(&b[size * i..], kind, normalized) } else { usual[i] };
        self.read(accessor, count, [0.0; N], |b| std::array::from_fn(|i| one(b, i)))
    }

    /// Reads vertex indices. Those that are no unsigned integers are taken as such; what is none becomes one that no mesh has.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, AssetError> {
        let kind = accessor.data_type();
        if accessor.dimensions() != Dimensions::Scalar {
            let problem =
                format!("indices must be unsigned integer scalars, not {:?} of {kind:?}", accessor.dimensions());
            return self.fail(&place(accessor), problem);
        }
        if is_index(kind) {
            return self.read(accessor, accessor.count(), 0, unsigned);
        }
        self.read(accessor, accessor.count(), 0, |b| {
            let value = component(b, kind, false);
            if value >= 0.0 && value.fract() == 0.0 && value < u32::MAX as f32 { value as u32 } else { u32::MAX }
        })
    }
}

/// Whether vertex indices may be of a type.
pub(super) fn is_index(kind: DataType) -> bool {
    matches!(kind, DataType::U8 | DataType::U16 | DataType::U32)
}

fn float(b: &[u8]) -> f32 {
    f32::from_le_bytes([b[0], b[1], b[2], b[3]])
}

/// A little-endian unsigned integer of 1, 2 or 4 bytes.
fn unsigned(b: &[u8]) -> u32 {
    b.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

/// A component as a float (glTF 2.0, section 3.6.2.2: normalised integers).
fn component(b: &[u8], kind: DataType, normalized: bool) -> f32 {
    let (value, most) = match kind {
        DataType::I8 => (f32::from(b[0] as i8), 127.0),
        DataType::U8 => (f32::from(b[0]), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
        DataType::U32 => (unsigned(&b[..4]) as f32, 4_294_967_295.0),
        DataType::F32 => return float(b),
    };
    if normalized { (value / most).max(-1.0) } else { value }
}
