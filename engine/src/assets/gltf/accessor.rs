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
        match offset.checked_add(length).and_then(|end| data.get(offset..end)) {
            Some(bytes) => Ok(bytes),
            None => self.fail(
                &format!("buffer view {}", view.index()),
                format!("bytes {offset} + {length} lie beyond the end of buffer {buffer} ({} bytes)", data.len()),
            ),
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
        if stride < size || stride > 252 {
            return self.fail(place, format!("stride {stride} of its buffer view must lie between {size} and 252"));
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

    /// Checks that all data the accessor refers to is there.
    pub fn check(&self, accessor: &Accessor) -> Result<(), AssetError> {
        let (place, count, size) = (place(accessor), accessor.count(), accessor.size());
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

    /// Reads all elements, sparse ones put in, each decoded by `decode`.
    fn read<T: Clone>(&self, accessor: &Accessor, zero: T, decode: impl Fn(&[u8]) -> T) -> Result<Vec<T>, AssetError> {
        self.check(accessor)?;
        let (place, count, size) = (place(accessor), accessor.count(), accessor.size());
        if let Some(bytes) = self.replaced.get(&accessor.index()) {
            return Ok(bytes.chunks_exact(size).map(decode).collect());
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
            match out.get_mut(index as usize) {
                Some(slot) => *slot = decode(value),
                None => {
                    return self.fail(&place, format!("sparse index {index} of {count} elements"));
                }
            }
        }
        Ok(out)
    }

    /// Reads vectors of `N` components as floats; integers are normalised where the accessor says so.
    pub fn vectors<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f32; N]>, AssetError> {
        if accessor.dimensions().multiplicity() != N || matches!(accessor.dimensions(), Dimensions::Mat2) {
            return self
                .fail(&place(accessor), format!("holds {:?} where vectors of {N} are wanted", accessor.dimensions()));
        }
        let zero = [0.0; N];
        if accessor.data_type() == DataType::F32 {
            return self.read(accessor, zero, |b| std::array::from_fn(|i| float(&b[4 * i..])));
        }
        let (kind, normalized, size) = (accessor.data_type(), accessor.normalized(), accessor.data_type().size());
        self.read(accessor, zero, |b| std::array::from_fn(|i| component(&b[size * i..], kind, normalized)))
    }

    /// Reads vertex indices.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, AssetError> {
        let kind = accessor.data_type();
        let unsigned_kind = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !unsigned_kind || accessor.normalized() {
            let problem =
                format!("indices must be unsigned integer scalars, not {:?} of {kind:?}", accessor.dimensions());
            return self.fail(&place(accessor), problem);
        }
        self.read(accessor, 0, unsigned)
    }
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
