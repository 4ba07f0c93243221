//! Buffer views compressed by meshoptimizer: `EXT_meshopt_compression` and `KHR_meshopt_compression`.

use super::accessor::Buffers;
use super::remarks::Remarks;
use crate::assets::{AssetError, parallel};
use gltf::Document;
use gltf::json::Value;
use std::collections::HashMap;

/// Names under which the extension goes.
pub(super) const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Most bytes that a view may decode to.
const MAX_BYTES: usize = 1 << 30;
/// Most bytes that a byte can decode to: a block of the vertex codec holds 256 elements and spends at least a byte on
/// four bytes of them.
const MAX_RATIO: usize = 1024;

/// What becomes of a view that cannot be decoded.
const UNPACKED: &str = "its uncompressed bytes are read, if there are any";

/// The extension of a buffer view or buffer, under whichever name.
fn extension<'a>(get: impl Fn(&str) -> Option<&'a Value>) -> Option<&'a Value> {
    NAMES.iter().find_map(|name| get(name))
}

/// Whether a buffer holds nothing for readers that know the extension.
pub(super) fn is_fallback(buffer: &gltf::json::Buffer) -> bool {
    let found = extension(|name| buffer.extensions.as_ref()?.others.get(name));
    found.and_then(|e| e.get("fallback")).and_then(Value::as_bool).unwrap_or(false)
}

/// A compressed view.
struct Packed<'a> {
    index: usize,
    bytes: &'a [u8],
    count: usize,
    stride: usize,
    mode: &'a str,
    filter: &'a str,
}

/// Decodes all compressed buffer views, by their index.
pub(super) fn decode(
    document: &Document,
    buffers: &Buffers,
    remarks: &mut Remarks,
) -> Result<HashMap<usize, Vec<u8>>, AssetError> {
    let mut packed = Vec::new();
    for (index, view) in document.as_json().buffer_views.iter().enumerate() {
        if let Some(found) = extension(|name| view.extensions.as_ref()?.others.get(name)) {
            let result = read(index, found, view.byte_length.0 as usize, buffers);
            packed.extend(remarks.part(result, UNPACKED)?);
        }
    }
    let fail = |view: &Packed, problem: String| AssetError::format(buffers.path, place(view.index), problem);
    let total: usize = packed.iter().map(|view| view.count * view.stride).sum();
    if total > MAX_BYTES {
        let problem = format!("the compressed views decode to {total} bytes; at most {MAX_BYTES}");
        return Err(AssetError::format(buffers.path, "bufferViews", problem));
    }
    let decoded = parallel::map(&packed, |view| view.decode().map_err(|problem| fail(view, problem)));
    let mut views = HashMap::new();
    for (view, bytes) in packed.iter().zip(decoded) {
        views.extend(remarks.part(bytes, UNPACKED)?.map(|bytes| (view.index, bytes)));
    }
    Ok(views)
}

fn place(index: usize) -> String {
    format!("buffer view {index}")
}

fn read<'a>(index: usize, e: &'a Value, length: usize, buffers: &'a Buffers) -> Result<Packed<'a>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, place(index), problem));
    let number = |name: &str| e.get(name).and_then(Value::as_u64).and_then(|v| usize::try_from(v).ok());
    let (Some(buffer), Some(size), Some(stride), Some(count)) =
        (number("buffer"), number("byteLength"), number("byteStride"), number("count"))
    else {
        return fail("its compression lacks buffer, byteLength, byteStride or count".into());
    };
    let offset = number("byteOffset").unwrap_or(0);
    let data = buffers.data.get(buffer).map_or(&[] as &[u8], |d| d.as_ref());
    let Some(bytes) = offset.checked_add(size).and_then(|end| data.get(offset..end)) else {
        return fail(format!("compressed bytes {offset} + {size} lie beyond the end of buffer {buffer}"));
    };
    let whole = count.checked_mul(stride);
    if whole != Some(length) {
        return fail(format!("{count} elements of {stride} bytes do not make its {length} bytes"));
    }
    if length > size.saturating_mul(MAX_RATIO) {
        return fail(format!("{size} bytes cannot decode to {length}"));
    }
    let text = |name: &str, usual: &'static str| e.get(name).and_then(Value::as_str).unwrap_or(usual);
    Ok(Packed { index, bytes, count, stride, mode: text("mode", ""), filter: text("filter", "NONE") })
}

impl Packed<'_> {
    fn decode(&self) -> Result<Vec<u8>, String> {
        let broken = |e: meshopt::Error| format!("the compressed data is broken: {e}");
        let mut bytes = match (self.mode, self.stride) {
            ("ATTRIBUTES", 4..=256) if self.stride.is_multiple_of(4) => {
                vertices(self.bytes, self.count, self.stride).map_err(broken)?
            }
            ("TRIANGLES", 2) if self.count.is_multiple_of(3) => {
                bytes_of(&meshopt::decode_index_buffer::<u16>(self.bytes, self.count).map_err(broken)?)
            }
            ("TRIANGLES", 4) if self.count.is_multiple_of(3) => {
                bytes_of(&meshopt::decode_index_buffer::<u32>(self.bytes, self.count).map_err(broken)?)
            }
            ("INDICES", 2) => bytes_of(&meshopt::decode_index_sequence::<u16>(self.bytes, self.count).map_err(broken)?),
            ("INDICES", 4) => bytes_of(&meshopt::decode_index_sequence::<u32>(self.bytes, self.count).map_err(broken)?),
            (mode, stride) => return Err(format!("mode \"{mode}\" with {stride} bytes an element is not there")),
        };
        self.filter(&mut bytes)?;
        Ok(bytes)
    }

    fn filter(&self, bytes: &mut Vec<u8>) -> Result<(), String> {
        match (self.filter, self.stride) {
            ("NONE", _) => {}
            ("OCTAHEDRAL", 4) => filtered::<[i8; 4]>(bytes, meshopt::decode_filter_oct),
            ("OCTAHEDRAL", 8) => filtered::<[i16; 4]>(bytes, meshopt::decode_filter_oct),
            ("QUATERNION", 8) => filtered::<[i16; 4]>(bytes, meshopt::decode_filter_quat),
            ("EXPONENTIAL", stride) if stride.is_multiple_of(4) => {
                filtered::<[u32; 1]>(bytes, meshopt::decode_filter_exp)
            }
            ("COLOR", 4) => filtered::<[u8; 4]>(bytes, meshopt::decode_filter_color),
            ("COLOR", 8) => filtered::<[u16; 4]>(bytes, meshopt::decode_filter_color),
            (filter, stride) => return Err(format!("filter \"{filter}\" with {stride} bytes an element is not there")),
        }
        Ok(())
    }
}

fn bytes_of<T: bytemuck::NoUninit>(values: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(values).to_vec()
}

/// Applies a filter in place; by way of a copy that is aligned.
fn filtered<T: bytemuck::Pod>(bytes: &mut Vec<u8>, filter: impl Fn(&mut [T])) {
    let mut values: Vec<T> = bytemuck::pod_collect_to_vec(bytes);
    filter(&mut values);
    *bytes = bytes_of(&values);
}

/// An element of so many words: the codec takes the size from the type.
#[derive(Clone)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn vertices(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, meshopt::Error> {
    fn of<const N: usize>(bytes: &[u8], count: usize) -> Result<Vec<u8>, meshopt::Error> {
        let elements = meshopt::decode_vertex_buffer::<Words<N>>(bytes, count)?;
        Ok(elements.iter().flat_map(|element| bytemuck::cast_slice::<u32, u8>(&element.0).iter().copied()).collect())
    }
    macro_rules! by_words {
        ($($n:literal)*) => {
            match stride / 4 { $($n => of::<$n>(bytes, count),)* _ => Ok(Vec::new()) }
        };
    }
    by_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38
        39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}
