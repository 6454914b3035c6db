//! House style of a report, by a file.

use std::path::Path;

use serde::Deserialize;

use super::{Block, Document, Figure, Mark, Panel, Plot, SectionKind};
use crate::report::table::{Cell, Table};
use crate::toml_file;

/// Value of the `format` key.
const FORMAT: &str = "doublet report style";
/// Version of the form.
const VERSION: u32 = 1;
/// Colour of headings.
const ACCENT: &str = "#0068b4";
/// Largest logo, bytes.
const LARGEST_LOGO: u64 = 4 << 20;
/// Speed of a knot, m/s, and length of a foot, m.
const KNOT_M_S: f64 = 1852.0 / 3600.0;
const FOOT_M: f64 = 0.3048;

/// How a report looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Words at the head of every page; the title of the report where there are none.
    pub header: String,
    /// Words at the foot of every page.
    pub footer: String,
    /// Colour of headings, `#rrggbb`.
    pub accent: String,
    /// Logo on the first page.
    pub logo: Option<Logo>,
    /// Units of airspeeds and altitudes.
    pub units: UnitSystem,
    /// Sections in their order; empty for all.
    pub sections: Vec<SectionKind>,
    /// Who signs; empty for the usual ones.
    pub signatures: Vec<String>,
    /// Smaller print of facts and headings, for forms with an item to a section: one without a number is not parted where a page holds it.
    pub is_compact: bool,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            header: String::new(),
            footer: String::new(),
            accent: ACCENT.to_owned(),
            logo: None,
            units: UnitSystem::Si,
            sections: Vec::new(),
            signatures: Vec::new(),
            is_compact: false,
        }
    }
}

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logo {
    /// Ending of its file, `svg` or `png`.
    pub ending: &'static str,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// Units of airspeeds and altitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UnitSystem {
    /// m/s and m.
    #[default]
    Si,
    /// kt and ft.
    Aviation,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StyleFile {
    format: String,
    version: u32,
    #[serde(default)]
    header: String,
    #[serde(default)]
    footer: String,
    accent: Option<String>,
    logo: Option<String>,
    units: Option<String>,
    #[serde(default)]
    sections: Vec<String>,
    #[serde(default)]
    signatures: Vec<String>,
}

impl Style {
    /// Reads a file; its logo lies beside it.
    pub fn open(path: &Path) -> Result<Self, String> {
        toml_file::open(path, |text| Self::parse(text, path.parent().unwrap_or(Path::new(""))))
    }

    /// Reads the text of a file whose logo lies in `folder`.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let file = toml_file::parse(text, (FORMAT, VERSION), |file: &StyleFile| (&file.format, file.version))?;
        let units = match file.units.as_deref() {
            None | Some("si") => UnitSystem::Si,
            Some("aviation") => UnitSystem::Aviation,
            Some(other) => return Err(format!("units: '{other}' is neither si nor aviation")),
        };
        let accent = file.accent.unwrap_or_else(|| ACCENT.to_owned());
        let digits = accent.strip_prefix('#').unwrap_or_default();
        if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err(format!("accent: '{accent}' is not a colour: give #rrggbb"));
        }
        Ok(Self {
            header: file.header,
            footer: file.footer,
            accent,
            logo: file
                .logo
                .map(|name| Logo::open(&folder.join(name)).map_err(|error| format!("logo: {error}")))
                .transpose()?,
            units,
            sections: file.sections.iter().map(|name| find_section(name)).collect::<Result<_, _>>()?,
            signatures: file.signatures,
            is_compact: false,
        })
    }

    /// The document in this style.
    pub fn apply(&self, document: &mut Document) {
        if !self.signatures.is_empty() {
            document.signatures.clone_from(&self.signatures);
        }
        if self.units == UnitSystem::Aviation {
            let blocks = document.sections.iter_mut().flat_map(|section| &mut section.blocks);
            document.cover.iter_mut().chain(blocks).for_each(in_knots_and_feet);
        }
        document.style = self.clone();
    }
}

fn find_section(name: &str) -> Result<SectionKind, String> {
    let known = || SectionKind::ALL.map(SectionKind::name).join(", ");
    let found = SectionKind::from_name(name);
    found.ok_or_else(|| format!("sections: '{name}' is not one of {}", known()))
}

impl Logo {
    /// Reads a picture.
    pub fn open(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let named = |error: std::io::Error| format!("{name}: {error}");
        let ending = match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => "svg",
            Some("png") => "png",
            _ => return Err(format!("{name}: give an SVG or PNG file")),
        };
        if std::fs::metadata(path).map_err(named)?.len() > LARGEST_LOGO {
            return Err(format!("{name}: larger than 4 MB"));
        }
        let bytes = std::fs::read(path).map_err(named)?;
        let is_png = bytes.starts_with(b"\x89PNG\r\n\x1a\n");
        let is_svg = std::str::from_utf8(&bytes).is_ok_and(|text| text.contains("<svg"));
        if (ending == "png" && !is_png) || (ending == "svg" && !is_svg) {
            return Err(format!("{name}: not the picture its name says"));
        }
        Ok(Self { ending, bytes })
    }
}

fn in_knots_and_feet(block: &mut Block) {
    match block {
        Block::Table(table) => table_in_knots_and_feet(table),
        Block::Figure(figure) => figure_in_knots_and_feet(figure),
        _ => {}
    }
}

/// Unit and factor of an airspeed or altitude.
fn aviation(unit: &str, is_airspeed: bool, is_altitude: bool) -> Option<(&'static str, f64)> {
    match unit {
        "m/s" if is_airspeed => Some(("kt", 1.0 / KNOT_M_S)),
        "m" if is_altitude => Some(("ft", 1.0 / FOOT_M)),
        _ => None,
    }
}

fn table_in_knots_and_feet(table: &mut Table) {
    for (index, column) in table.columns.iter_mut().enumerate() {
        let key = &column.key;
        let is_airspeed = ["airspeed", "calibrated", "wind", "gust"].iter().any(|word| key.contains(word));
        let Some((unit, factor)) = aviation(column.unit, is_airspeed, key.contains("altitude")) else { continue };
        column.unit = unit;
        for row in &mut table.rows {
            if let Some(Cell::Number(value)) = row.get_mut(index) {
                *value *= factor;
            }
        }
    }
}

fn figure_in_knots_and_feet(figure: &mut Figure) {
    for panel in &mut figure.panels {
        let Panel::Plot(Plot { x, y, marks }) = panel else { continue };
        if let Some((unit, factor)) = aviation_unit(&y.label, &y.unit) {
            y.unit = unit.to_owned();
            y.range = y.range.map(|range| range.map(|end| end * factor));
            marks.iter_mut().for_each(|mark| stretch(mark, factor));
        }
        if let Some((unit, factor)) = aviation_unit(&x.label, &x.unit)
            && marks.iter().all(|mark| matches!(mark, Mark::Points { .. }))
        {
            x.unit = unit.to_owned();
            x.range = x.range.map(|range| range.map(|end| end * factor));
            let points = marks.iter_mut().filter_map(|mark| match mark {
                Mark::Points { points, .. } => Some(points),
                _ => None,
            });
            points.flatten().for_each(|[x, ..]| *x *= factor);
        }
    }
}

fn aviation_unit(label: &str, unit: &str) -> Option<(&'static str, f64)> {
    let label = label.to_lowercase();
    let is_airspeed = label == "v" || label.contains("airspeed");
    aviation(unit, is_airspeed, label == "h" || label.contains("altitude"))
}

/// The mark with its vertical values times a factor.
fn stretch(mark: &mut Mark, factor: f64) {
    match mark {
        Mark::Line { scale, .. } | Mark::Band { scale, .. } => *scale *= factor,
        Mark::Points { points, .. } => points.iter_mut().for_each(|[_, y, bar]| {
            *y *= factor;
            *bar *= factor;
        }),
        Mark::Bars { bars, .. } => bars.iter_mut().for_each(|[_, height]| *height *= factor),
        Mark::Level { value, band, .. } => {
            *value *= factor;
            band.iter_mut().for_each(|end| *end *= factor);
        }
        Mark::Span { .. } => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::document::{Axis, LineStyle, points};
    use crate::report::table::Column;

    const HEAD: &str = "format = \"doublet report style\"\nversion = 1\n";

    #[test]
    fn a_style_is_read_and_what_is_wrong_with_it_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("logo.svg"), "<svg xmlns=\"http://www.w3.org/2000/svg\"/>").unwrap();
        std::fs::write(folder.path().join("bad.png"), "no picture").unwrap();
        let text = format!(
            "{HEAD}header = \"House\"\naccent = \"#123abc\"\nunits = \"aviation\"\nlogo = \"logo.svg\"\nsections = [\"dynamics\", \"windows\"]\n"
        );
        let style = Style::parse(&text, folder.path()).unwrap();
        assert_eq!((style.header.as_str(), style.units), ("House", UnitSystem::Aviation));
        assert_eq!(style.sections, [SectionKind::Dynamics, SectionKind::Windows]);
        assert_eq!(style.logo.unwrap().ending, "svg");
        for (line, part) in [
            ("units = \"furlong\"", "neither si nor aviation"),
            ("accent = \"blue\"", "#rrggbb"),
            ("sections = [\"song\"]", "'song' is not one of"),
            ("logo = \"bad.png\"", "not the picture"),
            ("logo = \"logo.bmp\"", "SVG or PNG"),
            ("logo = \"none.svg\"", "none.svg"),
            ("colour = 1", "unknown field"),
        ] {
            let message = Style::parse(&format!("{HEAD}{line}\n"), folder.path()).unwrap_err();
            assert!(message.contains(part) && !message.contains('\n'), "{message}");
        }
        assert!(Style::parse(&HEAD.replace('1', "2"), folder.path()).unwrap_err().contains("version 2"));
    }

    #[test]
    fn airspeeds_and_altitudes_are_in_knots_and_feet_and_nothing_else_changes() {
        let mut table = Table {
            name: "flown".into(),
            caption: String::new(),
            columns: vec![
                Column::number("airspeed_m_s", "Airspeed", "m/s", 3),
                Column::number("altitude_m", "Altitude", "m", 4),
                Column::number("span", "Span", "m", 4),
            ],
            rows: vec![vec![Cell::Number(1852.0 / 36.0), Cell::Number(304.8), Cell::Number(11.6)]],
        };
        table_in_knots_and_feet(&mut table);
        assert_eq!(table.columns.iter().map(|column| column.unit).collect::<Vec<_>>(), ["kt", "ft", "m"]);
        let numbers: Vec<f64> =
            table.rows[0].iter().map(|cell| if let Cell::Number(value) = cell { *value } else { 0.0 }).collect();
        assert!((numbers[0] - 100.0).abs() < 1e-9 && (numbers[1] - 1000.0).abs() < 1e-9 && numbers[2] == 11.6);
        let marks = vec![points("", 0, LineStyle::Dots, [[1852.0 / 36.0, 2.0]])];
        let plot = Plot { x: Axis::new("V", "m/s"), y: Axis::new("CZ", ""), marks };
        let mut figure = Figure::new("", "", (1, 20.0), vec![Panel::Plot(plot)]);
        figure_in_knots_and_feet(&mut figure);
        let Panel::Plot(plot) = &figure.panels[0] else { panic!("a plot") };
        let Mark::Points { points, .. } = &plot.marks[0] else { panic!("points") };
        assert!(plot.x.unit == "kt" && (points[0][0] - 100.0).abs() < 1e-9 && points[0][1] == 2.0);
    }
}
