//! Values of arguments.

use std::ops::Range;
use std::path::PathBuf;

pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
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

pub(super) fn parse_frames(text: &str) -> Result<Range<u64>, String> {
    let parse = || {
        let (from, to) = text.split_once("..")?;
        Some(from.trim().parse().ok()?..to.trim().parse().ok()?)
    };
    let range: Range<u64> = parse().ok_or("write it as A..B, for instance 0..30")?;
    if range.is_empty() {
        return Err(format!("there is no frame from {} up to but without {}", range.start, range.end));
    }
    Ok(range)
}

pub(super) fn parse_time(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(time) if time.is_finite() && time >= 0.0 => Ok(time),
        _ => Err("give seconds, zero or more".to_owned()),
    }
}

/// A length of time \[s\] that something can be done in.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("give seconds, more than zero".to_owned()),
    }
}

pub(super) fn parse_output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("png" | "exr") => Ok(path),
        _ => Err("the name must end in .png or .exr".to_owned()),
    }
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
