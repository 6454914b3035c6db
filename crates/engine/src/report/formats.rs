//! Tables as files: CSV for programs, LaTeX and Markdown for people.

use std::fmt::Write;
use std::path::Path;

use rayon::prelude::*;

use super::table::{Cell, Table};
use super::{ReportError, file_error};

/// A form of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Comma-separated values, full precision, SI units in the names of the columns.
    Csv,
    /// LaTeX `tabular` with the rules of the package booktabs.
    Latex,
    Markdown,
}

impl TableFormat {
    doublet_core::named_variants! {
        /// Name on the command line.
        pub name: Csv "csv", Latex "latex", Markdown "markdown"
    }

    doublet_core::variant_texts! {
        ending: Csv "csv", Latex "tex", Markdown "md"
    }
}

/// Writes each table into a file of its own in `folder`.
pub fn write(tables: &[Table], format: TableFormat, folder: &Path) -> Result<(), ReportError> {
    tables.par_iter().try_for_each(|table| {
        let path = folder.join(format!("{}.{}", table.name, format.ending()));
        let text = match format {
            TableFormat::Csv => csv(table).map_err(file_error(&path))?,
            TableFormat::Latex => latex(table).into_bytes(),
            TableFormat::Markdown => markdown(table).into_bytes(),
        };
        std::fs::write(&path, text).map_err(file_error(&path))
    })
}

/// Comma-separated values; numbers read back to the same number, and are empty where they do not exist.
pub fn csv(table: &Table) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(table.columns.iter().map(|column| &column.key))?;
    for row in &table.rows {
        writer.write_record(row.iter().map(exact))?;
    }
    writer.into_inner().map_err(|error| std::io::Error::other(error.to_string()))
}

/// The shortest text that reads back to the same value.
fn exact(cell: &Cell) -> String {
    match cell {
        Cell::Empty => String::new(),
        Cell::Text(text) | Cell::Symbol(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(value) | Cell::Measured { value, .. } if value.is_finite() => value.to_string(),
        Cell::Number(_) | Cell::Measured { .. } => String::new(),
        Cell::Flag(flag) => flag.to_string(),
    }
}

/// A Markdown table under its caption.
pub fn markdown(table: &Table) -> String {
    let line = |cells: &mut dyn Iterator<Item = String>| format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "));
    let escape = |text: String| text.replace('\\', "\\\\").replace('|', "\\|").replace(['\n', '\r'], " ");
    let mut text = format!("{}\n\n", table.caption);
    text.push_str(&line(&mut table.columns.iter().map(|column| escape(column.title()))));
    text.push_str(&line(&mut alignments(table).map(|right| if right { "---:" } else { "---" }.to_owned())));
    for row in &table.rows {
        let cells = row.iter().zip(&table.columns);
        text.push_str(&line(&mut cells.map(|(cell, column)| escape(cell.readable(column.digits)))));
    }
    text
}

/// Of each column, whether it is set to the right: one that holds quantities and no words.
pub fn alignments(table: &Table) -> impl Iterator<Item = bool> {
    (0..table.columns.len()).map(|index| {
        let mut cells = table.rows.iter().map(|row| &row[index]).filter(|cell| **cell != Cell::Empty).peekable();
        cells.peek().is_some() && cells.all(Cell::is_quantity)
    })
}

/// A LaTeX table with its caption; it needs the package booktabs, and longtable where it has many rows.
pub fn latex(table: &Table) -> String {
    /// Rows that fit on one page.
    const PAGE: usize = 45;
    let align: String = alignments(table).map(|right| if right { 'r' } else { 'l' }).collect();
    let cells = |cells: &mut dyn Iterator<Item = String>| format!("{} \\\\\n", cells.collect::<Vec<_>>().join(" & "));
    let header = cells(&mut table.columns.iter().map(|column| escape_latex(&column.title())));
    let label = format!("\\caption{{{}}}\\label{{tab:{}}}", escape_latex(&table.caption), table.name);
    let mut text = format!("% {}: needs \\usepackage{{booktabs,longtable}}\n", table.name);
    let long = table.rows.len() > PAGE;
    let body = table
        .rows
        .iter()
        .map(|row| cells(&mut row.iter().zip(&table.columns).map(|(cell, column)| latex_cell(cell, column.digits))));
    let body: String = body.collect();
    // Writing to a string cannot fail.
    let _ = if long {
        write!(
            text,
            "\\begin{{longtable}}{{{align}}}\n{label} \\\\\n\\toprule\n{header}\\midrule\n\\endhead\n\\bottomrule\n\\endfoot\n{body}\\end{{longtable}}\n"
        )
    } else {
        write!(
            text,
            "\\begin{{table}}\n\\centering\n{label}\n\\begin{{tabular}}{{{align}}}\n\\toprule\n{header}\\midrule\n{body}\\bottomrule\n\\end{{tabular}}\n\\end{{table}}\n"
        )
    };
    text
}

fn latex_cell(cell: &Cell, digits: usize) -> String {
    match cell {
        Cell::Symbol(name) => latex_symbol(name),
        Cell::Number(value) | Cell::Measured { value, .. } if value.is_finite() => {
            let text = cell.readable(digits).replace('\u{2212}', "-");
            match text.split_once('e') {
                Some((mantissa, exponent)) => format!("${mantissa}\\cdot 10^{{{exponent}}}$"),
                None => format!("${text}$"),
            }
        }
        Cell::Number(_) | Cell::Measured { .. } => "--".to_owned(),
        _ => escape_latex(&cell.readable(digits)),
    }
}

/// `Cm_delta_e` as `$C_{m_{\delta_e}}$`; what follows a `[` is text.
fn latex_symbol(name: &str) -> String {
    let (symbol, suffix) = name.split_once('[').map_or((name, String::new()), |(a, b)| (a.trim(), format!(" [{b}")));
    let (coefficient, variables) = symbol.split_once('_').unwrap_or((symbol, ""));
    let (letter, axis) = coefficient.split_at(coefficient.chars().next().map_or(0, char::len_utf8));
    let mut inner = variables.to_owned();
    for (word, command) in [
        ("alpha_dot", "\\dot{\\alpha}"),
        ("beta_dot", "\\dot{\\beta}"),
        ("delta_a", "\\delta_{a}"),
        ("delta_e", "\\delta_{e}"),
        ("delta_r", "\\delta_{r}"),
        ("mach", "M"),
        ("dpt", "\\Delta p_{t}"),
    ] {
        inner = inner.replace(word, command);
    }
    inner = greek_words(&inner).replace("}_", "}").replace("_\\", "\\");
    inner = inner.replace('2', "^{2}").replace('3', "^{3}");
    let subscript = if inner.is_empty() { axis.to_owned() } else { format!("{axis}_{{{inner}}}") };
    format!("${letter}_{{{subscript}}}${}", escape_latex(&suffix))
}

/// Bare `alpha` and `beta` as commands; those that are commands already stay.
fn greek_words(text: &str) -> String {
    let mut result = text.to_owned();
    for word in ["alpha", "beta"] {
        let command = format!("\\{word}");
        result = result.replace(&command, "\u{1}").replace(word, &format!("{command} ")).replace('\u{1}', &command);
    }
    result
}

/// Characters with a meaning in LaTeX, and those its fonts lack, as commands.
fn escape_latex(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\\' => result.push_str("\\textbackslash{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                result.push('\\');
                result.push(character);
            }
            '~' => result.push_str("\\textasciitilde{}"),
            '^' => result.push_str("\\textasciicircum{}"),
            '²' => result.push_str("$^2$"),
            '³' => result.push_str("$^3$"),
            'σ' => result.push_str("$\\sigma$"),
            '\u{2212}' => result.push_str("$-$"),
            '–' => result.push_str("--"),
            '\n' | '\r' => result.push(' '),
            other => result.push(other),
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    fn sample() -> Table {
        Table {
            name: "sample".into(),
            caption: "100 % of R²".into(),
            columns: vec![Column::new("name", "Name"), Column::number("value_kg", "Value", "kg", 3)],
            rows: vec![
                vec![Cell::text("a & b | c_d"), Cell::Number(-0.1 - 0.2)],
                vec![Cell::Symbol("Cm_delta_e".into()), Cell::Number(1.25e-7)],
                vec![Cell::Symbol("CX_alpha2 [w_1]".into()), Cell::Number(f64::NAN)],
            ],
        }
    }

    #[test]
    fn csv_reads_back_to_the_same_numbers() {
        let text = String::from_utf8(csv(&sample()).unwrap()).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(reader.headers().unwrap(), vec!["name", "value_kg"]);
        let values: Vec<String> = reader.records().map(|row| row.unwrap()[1].to_owned()).collect();
        assert_eq!(values[0].parse::<f64>().unwrap().to_bits(), (-0.1_f64 - 0.2).to_bits());
        assert_eq!(values[2], "");
    }

    #[test]
    fn latex_escapes_words_and_sets_symbols_in_mathematics() {
        let text = latex(&sample());
        for part in [
            "\\begin{tabular}{lr}",
            "a \\& b | c\\_d & $-0.300$ \\\\",
            "$C_{m_{\\delta_{e}}}$ & $1.25\\cdot 10^{-7}$ \\\\",
            "$C_{X_{\\alpha ^{2}}}$ [w\\_1] & -- \\\\",
            "100 \\% of R$^2$",
            "Value [kg]",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        assert_eq!(text.matches("\\begin").count(), text.matches("\\end").count());
    }

    #[test]
    fn markdown_has_as_many_cells_in_every_row() {
        let text = markdown(&sample());
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(rows[1], "| --- | ---: |");
        assert_eq!(rows[2], "| a & b \\| c_d | \u{2212}0.300 |");
        assert_eq!(rows[3], "| Cmδe | 1.25e\u{2212}7 |");
    }
}
