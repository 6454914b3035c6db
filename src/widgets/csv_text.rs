//! Tables as text for the clipboard and other programs.

use serde::Serialize;

/// Comma-separated values: a line of column titles, then one line a row. Cells are quoted where they must be; numbers are in full.
pub fn csv_text<Row: Serialize>(titles: &[&str], rows: impl IntoIterator<Item = Row>) -> String {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let written = writer.write_record(titles);
    let written = written.and_then(|()| rows.into_iter().try_for_each(|row| writer.serialize(row)));
    let bytes = written.ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::csv_text;

    #[test]
    fn names_with_quotes_and_commas_stay_one_cell() {
        let rows = [("03 \"rough\", repeated", 0.1, [1e-9, f64::NAN]), ("plain", -2.5, [0.0, 1.0])];
        let text = csv_text(&["manoeuvre", "a", "b", "c"], rows);
        assert_eq!(text, "manoeuvre,a,b,c\n\"03 \"\"rough\"\", repeated\",0.1,1e-9,NaN\nplain,-2.5,0.0,1.0\n");
    }
}
