//! Values of arguments.

use lightwell::render::UpdateRate;

/// Width and height \[pixels\], 1 to 16384, from `WIDTHxHEIGHT`.
///
/// # Errors
/// If it is written otherwise, or an edge is out of range.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some([width.trim().parse().ok()?, height.trim().parse().ok()?])
    };
    match parse() {
        Some(size @ [1..=16384, 1..=16384]) => Ok(size),
        Some(_) => Err("width and height must be 1 to 16384 pixels".to_owned()),
        None => Err("write it as WIDTHxHEIGHT, for instance 512x512".to_owned()),
    }
}

/// Frames per second.
///
/// # Errors
/// If it is no number from 1 to 1000.
pub fn parse_frame_rate(text: &str) -> Result<f32, String> {
    let rate = text.parse().ok().filter(|rate| *rate == 0.0 || (1.0..=1000.0).contains(rate));
    rate.ok_or_else(|| {
        "give a number of frames per second from 1 to 1000, or 0 for frames of the window's size".to_owned()
    })
}

/// Part of a window's size that is drawn.
///
/// # Errors
/// If it is not from 0.1 to 1.
pub fn parse_scale(text: &str) -> Result<f32, String> {
    let scale = text.parse().ok().filter(|scale| (0.1..=1.0).contains(scale));
    scale.ok_or_else(|| "give a number from 0.1 to 1".to_owned())
}

/// A path and its value, from `PATH=VALUE`.
///
/// # Errors
/// If there is no `=`, or nothing on one side of it.
pub fn parse_assignment(text: &str) -> Result<(String, String), String> {
    let (path, value) = text.split_once('=').ok_or("write it as PATH=VALUE, for instance clpv.steps=32")?;
    let (path, value) = (path.trim(), value.trim());
    if path.is_empty() || value.is_empty() {
        return Err("neither PATH nor VALUE may be empty".to_owned());
    }
    Ok((path.to_owned(), value.to_owned()))
}

/// Over how many frames light is brought up to date.
///
/// # Errors
/// If it is none of the numbers that there are.
pub fn parse_update(text: &str) -> Result<UpdateRate, String> {
    let frames = text.parse().ok().and_then(UpdateRate::over_frames);
    frames.ok_or_else(|| "give 1, 2 or 4 frames".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn update_rates_are_those_that_there_are() {
        assert_eq!(["1", "2", "4"].map(parse_update), UpdateRate::ALL.map(Ok));
        for wrong in ["0", "3", "8", "-1", "half", ""] {
            assert!(parse_update(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert!(parse_size("640").is_err() && parse_size("0x4").is_err() && parse_size("4x99999").is_err());
        let assignment = parse_assignment("a.b=(x = 1)");
        assert_eq!(assignment, Ok(("a.b".to_owned(), "(x = 1)".to_owned())));
        assert!(parse_assignment("a.b").is_err() && parse_assignment("=1").is_err());
    }
}
