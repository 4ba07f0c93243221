//! Colour tables of three dimensions, from `.cube` files (Adobe, "Cube LUT specification 1.0", 2013).

use super::{AssetError, AssetId, Meter, read_file};
use glam::Vec3;
use std::path::Path;

/// Most entries along an edge.
const MOST: u32 = 128;

/// Colours for colours: a cube of entries, between which is interpolated. What it holds never changes.
#[derive(Clone, Debug)]
pub struct CubeTable {
    /// Identity.
    pub id: AssetId,
    /// Entries along each edge, 2 to 128.
    pub size: u32,
    /// Colour of the first entry, and of the last one.
    pub domain: [Vec3; 2],
    /// The entries, the red of the colour looked up changing fastest.
    pub entries: Vec<Vec3>,
}

impl PartialEq for CubeTable {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// What the lines before the entries say.
struct Head {
    size: Option<u32>,
    domain: [Vec3; 2],
}

/// A fault with the number of its line; 0: of the file as a whole.
type Fault = (usize, String);

impl CubeTable {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read or is no table, with the number of the line.
    pub fn load(path: &Path) -> Result<Self, AssetError> {
        let bytes = read_file(path, &Meter::default())?;
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| AssetError::format(path, "colour table", "is no text; give a .cube file"))?;
        Self::parse(text).map_err(|(line, problem)| {
            let place = if line == 0 { "colour table".to_owned() } else { format!("line {line}") };
            AssetError::format(path, place, problem)
        })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// If it is no table: the number of the line, 0 for the file as a whole, and what is wrong.
    pub fn parse(text: &str) -> Result<Self, Fault> {
        let mut head = Head { size: None, domain: [Vec3::ZERO, Vec3::ONE] };
        let mut entries = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let (number, line) = (index + 1, line.trim());
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if line.starts_with(|first: char| first.is_ascii_alphabetic()) && !line.starts_with(['n', 'N', 'i', 'I']) {
                if !entries.is_empty() {
                    return Err((number, "a keyword after the first entry; all keywords come before".into()));
                }
                head.keyword(line).map_err(|problem| (number, problem))?;
                continue;
            }
            let size = head.size.ok_or_else(|| (number, "an entry before LUT_3D_SIZE".to_owned()))?;
            entries.push(numbers(line).map_err(|problem| (number, problem))?);
            if entries.len() > count(size) {
                return Err((number, format!("more than the {} entries that LUT_3D_SIZE {size} has", count(size))));
            }
        }
        head.table(entries)
    }

    /// The table that leaves each colour as it is.
    pub fn identity(size: u32) -> Self {
        let size = size.clamp(2, MOST);
        let at =
            |index: u32| Vec3::new((index % size) as f32, (index / size % size) as f32, (index / size / size) as f32);
        let entries = (0..size * size * size).map(|index| at(index) / (size - 1) as f32).collect();
        Self { id: AssetId::fresh(), size, domain: [Vec3::ZERO, Vec3::ONE], entries }
    }
}

impl Head {
    fn keyword(&mut self, line: &str) -> Result<(), String> {
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match word {
            "TITLE" => {}
            "LUT_3D_SIZE" => match rest.trim().parse() {
                Ok(size @ 2..=MOST) => self.size = Some(size),
                _ => return Err(format!("LUT_3D_SIZE is `{}`; 2 to {MOST} entries an edge can be read", rest.trim())),
            },
            "LUT_1D_SIZE" => return Err("a table of one dimension; save it as LUT_3D_SIZE".into()),
            "DOMAIN_MIN" => self.domain[0] = numbers(rest)?,
            "DOMAIN_MAX" => self.domain[1] = numbers(rest)?,
            // As some programs write both.
            "LUT_3D_INPUT_RANGE" => {
                let range = numbers(&format!("{rest} 0"))?;
                self.domain = [Vec3::splat(range.x), Vec3::splat(range.y)];
            }
            _ => {
                let short: String = word.chars().take(40).collect();
                return Err(format!("`{short}` is no keyword of .cube files"));
            }
        }
        Ok(())
    }

    fn table(self, entries: Vec<Vec3>) -> Result<CubeTable, Fault> {
        let Some(size) = self.size else { return Err((0, "has no LUT_3D_SIZE; is it a .cube file?".into())) };
        let [low, high] = self.domain;
        if low.cmpge(high).any() {
            return Err((0, format!("DOMAIN_MIN {low} is not below DOMAIN_MAX {high}")));
        }
        if entries.len() != count(size) {
            let needed = count(size);
            return Err((
                0,
                format!("has {} entries, and LUT_3D_SIZE {size} needs {needed}: it is cut off", entries.len()),
            ));
        }
        Ok(CubeTable { id: AssetId::fresh(), size, domain: self.domain, entries })
    }
}

fn count(size: u32) -> usize {
    (size as usize).pow(3)
}

/// Three finite numbers.
fn numbers(text: &str) -> Result<Vec3, String> {
    let mut words = text.split_whitespace();
    let mut value = Vec3::ZERO;
    for axis in 0..3 {
        let word = words.next().ok_or_else(|| "three numbers are needed".to_owned())?;
        let short = || word.chars().take(40).collect::<String>();
        value[axis] = word.parse().map_err(|_| format!("`{}` is no number", short()))?;
        if !value[axis].is_finite() {
            return Err(format!("`{}` is not finite", short()));
        }
    }
    match words.next() {
        None => Ok(value),
        Some(_) => Err("more than three numbers".into()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn written(table: &CubeTable) -> String {
        let [low, high] = table.domain;
        let mut text = format!("# made by a test\nTITLE \"a\"\n\nLUT_3D_SIZE {}\n", table.size);
        text += &format!("DOMAIN_MIN {} {} {}\nDOMAIN_MAX {} {} {}\n", low.x, low.y, low.z, high.x, high.y, high.z);
        table.entries.iter().for_each(|entry| text += &format!("{} {} {}\n", entry.x, entry.y, entry.z));
        text
    }

    #[test]
    fn faults_name_their_line() {
        let entries = "0 0 0\n".repeat(8);
        for (text, line, part) in [
            ("", 0, "no LUT_3D_SIZE"),
            ("0 0 0\n", 1, "before LUT_3D_SIZE"),
            ("# a\nLUT_3D_SIZE 1\n", 2, "2 to 128"),
            ("LUT_3D_SIZE 99999999999\n", 1, "2 to 128"),
            ("LUT_1D_SIZE 16\n", 1, "one dimension"),
            ("LUT_3D_SIZE 2\nLUT_4D\n", 2, "`LUT_4D`"),
            ("LUT_3D_SIZE 2\n0 0 0\nDOMAIN_MIN 0 0 0\n", 3, "before"),
            ("LUT_3D_SIZE 2\n0 0\n", 2, "three numbers"),
            ("LUT_3D_SIZE 2\n0 0 0 0\n", 2, "more than three"),
            ("LUT_3D_SIZE 2\n0 0 -\n", 2, "`-`"),
            ("LUT_3D_SIZE 2\n0 nan 0\n", 2, "not finite"),
            ("LUT_3D_SIZE 2\ninf 0 0\n", 2, "not finite"),
            ("LUT_3D_SIZE 2\n0 0 0\n", 0, "cut off"),
            (&format!("LUT_3D_SIZE 2\n{entries}0 0 0\n"), 10, "more than the 8"),
            (&format!("LUT_3D_SIZE 2\nDOMAIN_MAX 1 0 1\n{entries}"), 0, "not below"),
        ] {
            let (found, problem) = CubeTable::parse(text).unwrap_err();
            assert!(found == line && problem.contains(part), "{text}: line {found}: {problem}");
        }
    }

    proptest! {
        #[test]
        fn tables_are_read_as_they_are_written(size in 2u32..6, low in -2.0f32..0.0, high in 0.1f32..9.0, scale in -3.0f32..3.0) {
            let mut table = CubeTable { domain: [Vec3::splat(low), Vec3::splat(high)], ..CubeTable::identity(size) };
            table.entries.iter_mut().for_each(|entry| *entry *= scale);
            let read = CubeTable::parse(&written(&table)).unwrap();
            prop_assert_eq!((read.size, read.domain, read.entries), (table.size, table.domain, table.entries));
        }

        #[test]
        fn any_text_is_read_or_refused(text in "[ -~\n]{0,200}", at in 0usize..200, part in "[^\r]{0,12}") {
            let _ = CubeTable::parse(&text);
            // A table with anything in it.
            let mut whole = written(&CubeTable::identity(2));
            let place = at.min(whole.len());
            whole.insert_str(place, &part);
            let _ = CubeTable::parse(&whole);
            whole.truncate(place);
            let _ = CubeTable::parse(&whole);
        }
    }
}
