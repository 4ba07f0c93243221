//! Figures in the README and the book are those of reports and tests: `docs/figures.md` says for each where it comes from.

use lightwell_tests::root;
use std::path::Path;

/// Cells of the rows of all tables of a Markdown text whose first column's head is the given one.
fn rows(text: &str, head: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut is_wanted = false;
    for line in text.lines() {
        if !line.starts_with('|') {
            is_wanted = false;
            continue;
        }
        let cells = cells(line);
        if cells.first().is_some_and(|cell| cell == head) {
            is_wanted = true;
        } else if is_wanted && !is_rule(&cells) {
            found.push(cells);
        }
    }
    found
}

fn cells(line: &str) -> Vec<String> {
    line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
}

fn is_rule(cells: &[String]) -> bool {
    cells.iter().all(|cell| cell.chars().all(|c| "-: ".contains(c)))
}

/// A number as texts have it, with its last digit's unit; whether it is a percentage.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Figure {
    value: f64,
    unit: f64,
    is_percent: bool,
}

impl Figure {
    /// Of `165×`, `(31×)`, `−4.9 %`, `.051`, `1,620 ms`; none of what holds no number.
    fn read(text: &str) -> Option<Self> {
        let text = text.replace('−', "-").replace(',', "");
        let start = text.find(|c: char| c.is_ascii_digit() || c == '.')?;
        let number: String = text[start..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let sign = if text[..start].ends_with('-') { -1.0 } else { 1.0 };
        let value = number.trim_end_matches('.').parse::<f64>().ok()?;
        Some(Self { value: sign * value, unit: 0.1_f64.powi(decimals as i32), is_percent: text.contains('%') })
    }

    /// Whether a text that shows this number says what a report's cell says, as exactly as both are written.
    fn is(self, cell: Self) -> bool {
        let factor = match (self.is_percent, cell.is_percent) {
            (true, false) => 100.0,
            (false, true) => 0.01,
            _ => 1.0,
        };
        let far = (self.value - factor * cell.value).abs();
        far <= 0.5 * self.unit.max(factor * cell.unit) * (1.0 + 1e-6)
    }
}

/// The cell of a report: the first table after a line that begins so, which has that row and column.
fn cell(report: &str, place: &str, row: &str, column: &str) -> Result<String, String> {
    let after = match place.is_empty() {
        true => report,
        false => {
            let from = report.find(&format!("\n{place}")).ok_or_else(|| format!("no line begins with `{place}`"))?;
            &report[from..]
        }
    };
    let mut head: Option<Vec<String>> = None;
    for line in after.lines() {
        if !line.starts_with('|') {
            head = None;
            continue;
        }
        let cells = cells(line);
        let Some(names) = &head else {
            head = Some(cells);
            continue;
        };
        let Some(index) = names.iter().position(|name| name == column) else { continue };
        if is_row(&cells, row) {
            return cells.get(index).cloned().ok_or_else(|| format!("row `{row}` is too short"));
        }
    }
    Err(format!("no row `{row}` with a column `{column}` after `{place}`"))
}

/// Whether a row begins with these cells: one, or several with ` / ` between them.
fn is_row(cells: &[String], row: &str) -> bool {
    let mut wanted = row.split(" / ").zip(cells);
    wanted.all(|(wanted, cell)| wanted.trim_matches('`') == cell.trim_matches('`'))
}

/// The words of a claim without the marks of its figure, and the figure. Rows of tables have `¦` for their bars.
fn claim(text: &str) -> Result<(String, Figure), String> {
    let text = text.replace('¦', "|");
    let parts: Vec<&str> = text.split("**").collect();
    let [before, figure, after] = parts[..] else { return Err("one figure stands between `**`".to_owned()) };
    let found = Figure::read(figure).ok_or_else(|| format!("`{figure}` is no number"))?;
    Ok((format!("{before}{figure}{after}"), found))
}

/// Text with its line breaks as spaces, as claims are quoted.
fn flowing(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The flowing texts of README and book. The page of figures quotes all words itself and is none of them.
fn pages() -> Vec<String> {
    let docs = std::fs::read_dir(root().join("docs")).expect("the book").map(|entry| entry.expect("an entry").path());
    let pages =
        docs.filter(|path| path.extension().is_some_and(|ending| ending == "md") && !path.ends_with("figures.md"));
    pages.chain([root().join("README.md")]).map(|path| flowing(&read(&path).expect("a page"))).collect()
}

/// Whether a page says these words.
fn is_said(pages: &[String], words: &str) -> Result<(), String> {
    let is_said = pages.iter().any(|page| page.contains(words));
    is_said.then_some(()).ok_or_else(|| "neither the README nor a page of the book says so".to_owned())
}

fn check_measured(pages: &[String], row: &[String]) -> Result<(), String> {
    let [words, report, place, name, column] = row else { return Err("five columns are wanted".to_owned()) };
    let (words, figure) = claim(words)?;
    is_said(pages, &words)?;
    let report = read(&root().join("tests/results").join(report))?;
    let cell = cell(&report, place, name, column)?;
    let measured = Figure::read(&cell).ok_or_else(|| format!("`{cell}` is no number"))?;
    figure.is(measured).then_some(()).ok_or_else(|| format!("the report has {cell}"))
}

fn check_tested(pages: &[String], row: &[String]) -> Result<(), String> {
    let [words, file, function, bound] = row else { return Err("four columns are wanted".to_owned()) };
    is_said(pages, words)?;
    let text = read(&root().join(file.trim_matches('`')))?;
    let function = function.trim_matches('`');
    let from = text.find(&format!("fn {function}(")).ok_or_else(|| format!("{file} has no `{function}`"))?;
    let body = &text[from..];
    let body = &body[..body.find("\n}").unwrap_or(body.len())];
    let bound = bound.trim_matches('`');
    body.contains(bound).then_some(()).ok_or_else(|| format!("`{function}` does not hold `{bound}`"))
}

#[test]
fn figures_of_readme_and_book_are_those_of_reports_and_tests() {
    let pages = pages();
    assert!(pages.len() > 20, "{} pages", pages.len());
    let page = read(&root().join("docs/figures.md")).expect("the page of figures");
    let measured = rows(&page, "measured");
    let tested = rows(&page, "tested");
    assert!(measured.len() > 100 && tested.len() > 10, "{} and {} rows", measured.len(), tested.len());
    let of = |check: fn(&[String], &[String]) -> Result<(), String>, rows: &[Vec<String>]| -> Vec<String> {
        let wrong = |row: &Vec<String>| check(&pages, row).err().map(|why| format!("{}: {why}", row[0]));
        rows.iter().filter_map(wrong).collect()
    };
    let wrong = [of(check_measured, &measured), of(check_tested, &tested)].concat();
    assert!(wrong.is_empty(), "docs/figures.md:\n{}", wrong.join("\n"));
}

#[test]
fn numbers_are_compared_as_exactly_as_they_are_written() {
    let is = |one: &str, other: &str| Figure::read(one).expect("a number").is(Figure::read(other).expect("a number"));
    assert!(is("165", "165×") && is("31", "(31×)") && is("3.8 %", "0.038") && is(".051", "0.051"));
    assert!(is("−4.3 %", "-0.043") && is("1,620 ms", "1620") && is(".8 %", "0.008"));
    assert!(!is("165", "164×") && !is("3.8 %", "0.037") && !is("−4.3 %", "0.043") && !is(".051", "0.053"));
    assert_eq!(Figure::read("–"), None);
}

#[test]
fn cells_are_found_by_place_row_and_column() {
    let report = "# R\n\n**one.** Words.\n\n| method | time | error |\n| --- | --- | --- |\n| `a` | 1 | 0.5 |\n\n\
                  **two.** Words.\n\n| method | time | error |\n| --- | --- | --- |\n| `a` | 2 | 0.25 |\n";
    assert_eq!(cell(report, "**two.**", "`a`", "error").as_deref(), Ok("0.25"));
    assert_eq!(cell(report, "**one.**", "a", "time").as_deref(), Ok("1"));
    assert_eq!(cell(report, "**two.**", "a / 2", "error").as_deref(), Ok("0.25"));
    assert!(cell(report, "**two.**", "a / 3", "error").is_err());
    assert!(cell(report, "**three.**", "a", "time").is_err() && cell(report, "**two.**", "b", "time").is_err());
}
