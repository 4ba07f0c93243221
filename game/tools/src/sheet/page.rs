//! The sheets: cells in rows and columns.

use super::cell::Cell;
use super::subject::Subject;
use crate::bench::{Canvas, text_width};
use crate::cli::SheetArgs;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Space between cells [pixels].
const GAP: u32 = 10;
/// Height of a line of text [pixels].
const LINE: u32 = 19;
/// Lines below an image: its name and what there is to say.
const LINES: u32 = 2;
/// Longest edge of a sheet [pixels], so that it can be looked at as a whole.
const MAX_EDGE: u32 = 1800;

/// Writes the sheets; gives their paths.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, args: &SheetArgs, subjects: &[Subject], cells: &[Cell]) -> Result<Vec<PathBuf>> {
    let [width, height] = [args.size[0] + GAP, args.size[1] + LINES * LINE + GAP];
    let columns = args.columns.map_or((MAX_EDGE - GAP) / width, u32::from).max(1);
    let rows = ((MAX_EDGE - GAP) / height).max(1);
    let all: Vec<_> = subjects.iter().zip(cells).collect();
    let mut paths = Vec::new();
    for (number, part) in all.chunks((columns * rows) as usize).enumerate() {
        let count = part.len() as u32;
        let size = [count.min(columns) * width + GAP, count.div_ceil(columns) * height + GAP];
        let mut canvas = Canvas::new(size);
        for (index, (subject, cell)) in (0u32..).zip(part) {
            let at = [GAP + (index % columns) * width, GAP + (index / columns) * height];
            put(&mut canvas, at, args.size, subject, cell)?;
        }
        let path = folder.join(format!("sheet_{:02}.png", number + 1));
        canvas.save(&path)?;
        paths.push(path);
    }
    Ok(paths)
}

fn put(canvas: &mut Canvas, at: [u32; 2], size: [u32; 2], subject: &Subject, cell: &Cell) -> Result<()> {
    match &cell.rgb {
        Some(rgb) => canvas.paste(at, size, rgb, 1),
        None => {
            let grey = [225u8].repeat(3 * size[0] as usize * size[1] as usize);
            canvas.paste(at, size, &grey, 1);
        }
    }
    if let Some(error) = &cell.error {
        let room = (size[1] / LINE) as usize;
        for (row, line) in (0u32..).zip(wrap(error, size[0] - 8)?.iter().take(room)) {
            canvas.text([at[0] + 4, at[1] + 2 + row * LINE], line)?;
        }
    }
    let below = at[1] + size[1] + 2;
    canvas.text([at[0], below], &shortened(&subject.name, size[0])?)?;
    canvas.text([at[0], below + LINE], &shortened(&remark(cell), size[0])?)
}

fn remark(cell: &Cell) -> String {
    match (&cell.error, cell.warnings.len()) {
        (Some(_), 0) => "error".to_owned(),
        (Some(_), count) => format!("error, {}", plural(count)),
        (None, 0) => format!("{} triangles", cell.triangles),
        (None, count) => format!("{} triangles, {}", cell.triangles, plural(count)),
    }
}

fn plural(count: usize) -> String {
    if count == 1 { "1 warning".to_owned() } else { format!("{count} warnings") }
}

/// The end of a text that is too wide: names differ there.
fn shortened(text: &str, width: u32) -> Result<String> {
    if text_width(text)? <= width {
        return Ok(text.to_owned());
    }
    let chars: Vec<char> = text.chars().collect();
    for start in 1..chars.len() {
        let short = format!("..{}", chars[start..].iter().collect::<String>());
        if text_width(&short)? <= width {
            return Ok(short);
        }
    }
    Ok(String::new())
}

/// Breaks a text into lines at spaces, and within words that are too long.
fn wrap(text: &str, width: u32) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if text_width(&longer)? <= width {
                line = longer;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for c in word.chars() {
                line.push(c);
                if text_width(&line)? > width {
                    line.pop();
                    lines.push(std::mem::take(&mut line));
                    line.push(c);
                }
            }
        }
        lines.push(line);
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn text_keeps_to_its_width() {
        let text = "buffer 0: a_file_name_that_is_far_too_long_for_one_line.bin is not there";
        let lines = wrap(text, 150).unwrap();
        assert!(lines.len() > 3 && lines.iter().all(|line| text_width(line).unwrap() <= 150), "{lines:?}");
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        let short = shortened(text, 150).unwrap();
        assert!(short.ends_with("is not there") && text_width(&short).unwrap() <= 150, "{short}");
    }
}
