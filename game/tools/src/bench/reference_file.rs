//! Traced images in files: EXR with both halves of direct and indirect light, and the key of what was traced.

use super::results::write_whole;
use anyhow::{Context, Result, anyhow, bail};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers,
    Text, WritableImage, f16,
};
use lightwell::measure::Image;
use lightwell::render::reference::Estimate;
use std::io::Cursor;
use std::path::Path;

/// Channels in the order of [`images`]: half a or b, direct or indirect light.
const LAYERS: [&str; 4] = ["direct_a", "direct_b", "indirect_a", "indirect_b"];
const COLORS: [&str; 3] = ["R", "G", "B"];

/// A traced image with what it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Key of scene, view and settings (see [`lightwell::render::reference::content_key`]).
    pub key: u128,
    /// The image.
    pub estimate: Estimate,
}

fn images(estimate: &Estimate) -> [&Image; 4] {
    [&estimate.direct[0], &estimate.direct[1], &estimate.indirect[0], &estimate.indirect[1]]
}

/// Writes the image; `half`: in half the bits, where the values allow it.
///
/// # Errors
/// If the image cannot be encoded or the file not be written.
pub fn write(path: &Path, stored: &Stored, half: bool) -> Result<()> {
    let images = images(&stored.estimate);
    let half = half && images.iter().all(|image| fits_half(image));
    let [width, height] = images[0].size().map(|size| size as usize);
    let channel = |layer: usize, color: usize| {
        let values = images[layer].pixels().iter().map(|pixel| pixel[color]);
        let samples = match half {
            true => FlatSamples::F16(values.map(f16::from_f32).collect()),
            false => FlatSamples::F32(values.collect()),
        };
        AnyChannel::new(format!("{}.{}", LAYERS[layer], COLORS[color]).as_str(), samples)
    };
    let channels = (0..12).map(|index| channel(index / 3, index % 3)).collect();
    let note = format!("lightwell reference key={:032x} samples={}", stored.key, stored.estimate.samples);
    let attributes =
        LayerAttributes { comments: Some(Text::new_or_panic(note.as_str())), ..LayerAttributes::default() };
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
    let layer = Layer::new((width, height), attributes, encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    let written = exr::prelude::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.with_context(|| format!("cannot encode {}", path.display()))?;
    write_whole(path, bytes.get_ref())
}

/// Half precision keeps eleven bits, but nothing above 65504 and less and less below 6e-5.
fn fits_half(image: &Image) -> bool {
    image.values().all(|value| value.abs() < 6e4) && (image.mean() == 0.0 || image.mean() > 1e-2)
}

/// Reads an image that [`write`] wrote; none if there is no such file.
///
/// # Errors
/// If the file holds something else.
pub fn read(path: &Path) -> Result<Option<Stored>> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    decode(&bytes).map(Some).with_context(|| format!("{} is no stored reference; remove it", path.display()))
}

fn decode(bytes: &[u8]) -> Result<Stored> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))?;
    let layer = &image.layer_data;
    let note = layer.attributes.comments.as_ref().map(ToString::to_string).unwrap_or_default();
    let field = |name: &str| note.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    let key = field("key").and_then(|key| u128::from_str_radix(key, 16).ok());
    let samples = field("samples").and_then(|samples| samples.parse().ok());
    let (Some(key), Some(samples)) = (key, samples) else { bail!("it does not say what it is of") };
    let size = [layer.size.0 as u32, layer.size.1 as u32];
    let read_layer = |name: &str| -> Result<Image> {
        let mut pixels = vec![[0.0_f32; 3]; layer.size.area()];
        for (index, color) in COLORS.iter().enumerate() {
            let name = format!("{name}.{color}");
            let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
            let channel = channel.ok_or_else(|| anyhow!("channel {name} is missing"))?;
            for (pixel, value) in pixels.iter_mut().zip(channel.sample_data.values_as_f32()) {
                pixel[index] = value;
            }
        }
        Image::from_pixels(size[0], size[1], pixels).context("it is incomplete")
    };
    let [direct_a, direct_b, indirect_a, indirect_b] = LAYERS.map(read_layer);
    let estimate = Estimate { direct: [direct_a?, direct_b?], indirect: [indirect_a?, indirect_b?], samples };
    Ok(Stored { key, estimate })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn stored() -> Stored {
        let image = |scale: f32| {
            let pixels = (0..12 * 8).map(|i| [scale * i as f32, scale, 0.37 * scale * (i % 7) as f32]).collect();
            Image::from_pixels(12, 8, pixels).unwrap()
        };
        let estimate = Estimate { direct: [image(1.0), image(2.0)], indirect: [image(0.5), image(0.25)], samples: 64 };
        Stored { key: 0xfeed_0123_4567_89ab_cdef_0011_2233_4455, estimate }
    }

    #[test]
    fn floats_come_back_bit_by_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        assert_eq!(read(&path).unwrap(), None);
        write(&path, &stored(), false).unwrap();
        assert_eq!(read(&path).unwrap().unwrap(), stored());
    }

    #[test]
    fn halves_come_back_to_eleven_bits_and_smaller() {
        let dir = tempfile::tempdir().unwrap();
        let (small, large) = (dir.path().join("a.exr"), dir.path().join("b.exr"));
        write(&small, &stored(), true).unwrap();
        write(&large, &stored(), false).unwrap();
        let back = read(&small).unwrap().unwrap();
        assert_eq!(back.key, stored().key);
        for (a, b) in images(&back.estimate).iter().zip(images(&stored().estimate)) {
            for (a, b) in a.values().zip(b.values()) {
                assert!((a - b).abs() <= b.abs() / 2048.0 + 1e-6, "{a} {b}");
            }
        }
        assert!(std::fs::metadata(small).unwrap().len() < std::fs::metadata(large).unwrap().len());
    }

    #[test]
    fn values_beyond_half_precision_stay_floats() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let mut bright = stored();
        bright.estimate.direct[0].pixels_mut()[3] = [1e6, 1.0, 1.0];
        write(&path, &bright, true).unwrap();
        assert_eq!(read(&path).unwrap().unwrap(), bright);
    }

    #[test]
    fn other_files_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        std::fs::write(&path, b"nothing").unwrap();
        let message = format!("{:#}", read(&path).unwrap_err());
        assert!(message.contains("a.exr") && message.contains("no stored reference"), "{message}");
    }
}
