//! OpenEXR files.

use super::Image;
use super::capacity::may_hold;
use std::io::Cursor;

/// Checks the sizes in the headers of an EXR file, which memory is taken by.
#[doc(hidden)]
pub fn check_exr(bytes: &[u8]) -> Result<(), exr::error::Error> {
    use exr::meta::BlockDescription;
    use exr::prelude::{Error, MetaData, Vec2};
    const TILE: usize = 4096;
    let fail = |problem: String| Err(Error::Invalid(problem.into()));
    for header in MetaData::read_from_buffered(Cursor::new(bytes), false)?.headers {
        let Vec2(width, height) = header.layer_size;
        if !may_hold(bytes, width as u64, height as u64) {
            return fail(format!("{width}x{height} pixels are more than {} bytes can hold", bytes.len()));
        }
        if let BlockDescription::Tiles(tiles) = header.blocks
            && tiles.tile_size.0.max(tiles.tile_size.1) > TILE
        {
            let Vec2(width, height) = tiles.tile_size;
            return fail(format!("its tiles have {width}x{height} pixels; at most {TILE} on an edge can be read"));
        }
    }
    Ok(())
}

/// The pixels of an EXR file.
pub(super) fn decode_exr(bytes: &[u8]) -> Result<Image, String> {
    read(bytes).map_err(|error| format!("not a readable EXR image: {error}"))
}

fn read(bytes: &[u8]) -> Result<Image, exr::error::Error> {
    use exr::prelude::*;
    check_exr(bytes)?;
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| super::Image::filled(size.width() as u32, size.height() as u32, [0.0; 3]),
            |image, at, (r, g, b): (f32, f32, f32)| {
                let width = image.size()[0] as usize;
                image.pixels_mut()[at.y() * width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))?;
    Ok(read.layer_data.channel_data.pixels)
}

/// An EXR file of float32 values, not compressed.
pub(super) fn encode_exr(image: &Image) -> Result<Vec<u8>, exr::error::Error> {
    use exr::prelude::{Encoding, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
    let [width, height] = image.size().map(|s| s as usize);
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = image.pixels()[at.y() * width + at.x()];
        (r, g, b)
    });
    let layer = Layer::new((width, height), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    let mut bytes = Cursor::new(Vec::new());
    // One thread: blocks lie in the file in the order in which threads finish them.
    exr::prelude::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}
