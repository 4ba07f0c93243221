//! Values of arguments.

use std::ops::Range;
use std::path::PathBuf;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        assert_eq!(parse_frames("3..7"), Ok(3..7));
        assert!(parse_frames("7..7").is_err() && parse_frames("7").is_err());
        assert!(parse_time("NaN").is_err() && parse_time("-1").is_err());
        assert_eq!(parse_time("1.5"), Ok(1.5));
        assert!(parse_seconds("0").is_err() && parse_seconds("inf").is_err() && parse_seconds("soon").is_err());
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
        assert!(parse_output("a.jpg").is_err() && parse_output("png").is_err() && parse_output("a.PNG").is_ok());
    }
}
