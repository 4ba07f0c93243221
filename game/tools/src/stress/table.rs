//! The worst deviation of each invariant with each method, as text and as an image.

use super::invariant::Invariant;
use super::setup::Method;
use crate::bench::plot;
use anyhow::Result;
use lightwell::measure::write_png_rgb8;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The worst that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// How far off.
    pub deviation: f64,
    /// Where.
    pub place: String,
    /// The scene's text.
    pub scene: String,
    /// How many were tried.
    pub tried: usize,
}

/// Worst deviations by invariant and method.
#[derive(Clone, Debug, Default)]
pub struct Table {
    cells: BTreeMap<(Invariant, Method), Worst>,
}

impl Table {
    /// Enters a deviation. NaN is worse than anything.
    pub fn enter(&mut self, invariant: Invariant, method: Method, deviation: f64, place: &str, scene: &str) {
        let deviation = if deviation.is_nan() { f64::INFINITY } else { deviation };
        let new = Worst { deviation, place: place.to_owned(), scene: scene.to_owned(), tried: 0 };
        let cell = self.cells.entry((invariant, method)).or_insert_with(|| new.clone());
        let tried = cell.tried + 1;
        if deviation > cell.deviation {
            *cell = new;
        }
        cell.tried = tried;
    }

    /// Cells beyond their bounds.
    pub fn broken(&self) -> impl Iterator<Item = (Invariant, Method, &Worst)> {
        self.iter().filter(|(invariant, method, worst)| worst.deviation > invariant.bound(*method).most)
    }

    /// All cells.
    pub fn iter(&self) -> impl Iterator<Item = (Invariant, Method, &Worst)> {
        self.cells.iter().map(|(&(invariant, method), worst)| (invariant, method, worst))
    }

    /// The table, where each worst case is, and why bounds are wider than the general ones.
    pub fn text(&self) -> String {
        let mut text = format!("{:15}", "");
        for method in Method::ALL {
            let _ = write!(text, " {:>20}", method.name());
        }
        text.push('\n');
        for invariant in Invariant::ALL {
            let _ = write!(text, "{:15}", invariant.name());
            for method in Method::ALL {
                let _ = write!(text, " {:>20}", self.cell(invariant, method));
            }
            text.push('\n');
        }
        text.push_str("\nworst deviation / bound; * beyond the bound; empty: not checked\n\nWider bounds\n");
        for (invariant, method) in Invariant::ALL.iter().flat_map(|i| Method::ALL.map(|m| (*i, m))) {
            let bound = invariant.bound(method);
            if let (Some(why), true) = (bound.why, self.cells.contains_key(&(invariant, method))) {
                let _ = writeln!(text, "  {}, {}: {:.0e}: {why}", invariant.name(), method.name(), bound.most);
            }
        }
        text.push_str("\nWhere the worst are\n");
        for (invariant, method, worst) in self.iter().filter(|(.., worst)| worst.deviation > 0.0) {
            let _ = writeln!(
                text,
                "  {}, {}: {:.2e} of {} tried: {}",
                invariant.name(),
                method.name(),
                worst.deviation,
                worst.tried,
                worst.place
            );
        }
        text
    }

    fn cell(&self, invariant: Invariant, method: Method) -> String {
        let Some(worst) = self.cells.get(&(invariant, method)) else { return String::new() };
        let bound = invariant.bound(method).most;
        let mark = if worst.deviation > bound { "*" } else { "" };
        format!("{mark}{} / {}", short(worst.deviation), short(bound))
    }

    /// Writes the image: green within the bound, the paler the closer to it, red beyond.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_picture(&self, path: &Path) -> Result<()> {
        let (cell, left, top) = ([130, 26], 150, 34);
        let size = [left + cell[0] * Method::ALL.len() as u32 + 10, top + cell[1] * Invariant::ALL.len() as u32 + 10];
        let mut rgb = vec![255; 3 * (size[0] * size[1]) as usize];
        for (column, method) in (0u32..).zip(Method::ALL) {
            let x = left + column * cell[0];
            plot::text(&mut rgb, size, [x as i32 + 6, 10], method.name())?;
            for (row, invariant) in (0u32..).zip(Invariant::ALL) {
                let y = top + row * cell[1];
                let Some(worst) = self.cells.get(&(invariant, method)) else { continue };
                fill(
                    &mut rgb,
                    size,
                    [x, y],
                    [cell[0] - 2, cell[1] - 2],
                    color(worst.deviation, invariant.bound(method).most),
                );
                plot::text(&mut rgb, size, [x as i32 + 6, y as i32 + 4], &self.cell(invariant, method))?;
            }
        }
        for (row, invariant) in (0u32..).zip(Invariant::ALL) {
            plot::text(&mut rgb, size, [8, (top + row * cell[1]) as i32 + 4], invariant.name())?;
        }
        Ok(write_png_rgb8(path, size, &rgb)?)
    }
}

fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

/// Full green at a thousandth of the bound or nothing at all, pale at the bound, red beyond it.
fn color(deviation: f64, bound: f64) -> [u8; 3] {
    if deviation > bound {
        return [240, 130, 120];
    }
    let decades = if deviation == 0.0 { 3.0 } else { (bound / deviation).log10().clamp(0.0, 3.0) };
    let fade = |full: f64, pale: f64| (pale + (full - pale) * decades / 3.0) as u8;
    [fade(130.0, 250.0), fade(205.0, 240.0), fade(140.0, 190.0)]
}

fn fill(rgb: &mut [u8], size: [u32; 2], at: [u32; 2], extent: [u32; 2], color: [u8; 3]) {
    for y in at[1]..at[1] + extent[1] {
        for x in at[0]..at[0] + extent[0] {
            let index = 3 * (y * size[0] + x) as usize;
            rgb[index..index + 3].copy_from_slice(&color);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_worst_is_kept_and_what_breaks_a_bound_is_marked() {
        let mut table = Table::default();
        table.enter(Invariant::Dark, Method::Sweep, 0.0, "here", "a");
        table.enter(Invariant::Dark, Method::Sweep, 2.0, "there", "b");
        table.enter(Invariant::Dark, Method::Sweep, 1.0, "nowhere", "c");
        table.enter(Invariant::Finite, Method::Vpl, f64::NAN, "odd", "d");
        table.enter(Invariant::Length, Method::Slc, 1e-6, "small", "e");
        let broken: Vec<_> = table.broken().map(|(i, m, w)| (i, m, w.place.as_str(), w.tried)).collect();
        assert_eq!(broken, [(Invariant::Finite, Method::Vpl, "odd", 1), (Invariant::Dark, Method::Sweep, "there", 3)]);
        let text = table.text();
        assert!(text.contains("*2.0e0 / 0") && text.contains("dark, sweep: 2.00e0 of 3 tried: there"), "{text}");
        let dir = tempfile::tempdir().unwrap();
        table.write_picture(&dir.path().join("a.png")).unwrap();
        assert!(dir.path().join("a.png").exists());
    }
}
