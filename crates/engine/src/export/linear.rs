//! Linear models as files: MAT with the fields of state-space models, JSON, CSV; each number as short as it reads back the same.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::ExportError;
use crate::keep::replace;
use crate::report::mat_file::{Node, header, write_variable};
use crate::report::{DynamicsRow, LinearRow};

/// A form of linear models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearFormat {
    /// MAT-file of level 5: a struct per model.
    Mat,
    Json,
    /// One line per entry of a matrix.
    Csv,
}

impl LinearFormat {
    /// The form a file's ending names.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mat" => Some(Self::Mat),
            "json" => Some(Self::Json),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }

    /// A line each that loads the longitudinal model of `file` into python-control, Julia and MATLAB.
    pub fn load_lines(self, file: &str) -> [(&'static str, String); 3] {
        let quoted = Value::from(file).to_string();
        let single = format!("'{}'", file.replace('\'', "''"));
        let model = "longitudinal";
        match self {
            Self::Mat => [
                (
                    "python",
                    format!(
                        "import scipy.io, control; m = scipy.io.loadmat({quoted})[\"{model}\"][0, 0]; sys = control.ss(m[\"A\"], m[\"B\"], m[\"C\"], m[\"D\"])"
                    ),
                ),
                (
                    "julia",
                    format!(
                        "using MAT, ControlSystems; m = matread({quoted})[\"{model}\"]; sys = ss(m[\"A\"], m[\"B\"], m[\"C\"], m[\"D\"])"
                    ),
                ),
                (
                    "matlab",
                    format!(
                        "m = load({single}).{model}; sys = ss(m.A, m.B, m.C, m.D, 'StateName', m.states, 'InputName', m.inputs, 'OutputName', m.outputs)"
                    ),
                ),
            ],
            Self::Json => [
                (
                    "python",
                    format!(
                        "import json, control; m = json.load(open({quoted}))[\"systems\"][\"{model}\"]; sys = control.ss(m[\"A\"], m[\"B\"], m[\"C\"], m[\"D\"])"
                    ),
                ),
                (
                    "julia",
                    format!(
                        "using JSON, ControlSystems; m = JSON.parsefile({quoted})[\"systems\"][\"{model}\"]; M(x) = Float64.(permutedims(reduce(hcat, x))); sys = ss(M(m[\"A\"]), M(m[\"B\"]), M(m[\"C\"]), M(m[\"D\"]))"
                    ),
                ),
                ("matlab", format!("m = jsondecode(fileread({single})).systems.{model}; sys = ss(m.A, m.B, m.C, m.D)")),
            ],
            Self::Csv => [
                (
                    "python",
                    format!(
                        "import pandas, control; t = pandas.read_csv({quoted}); t = t[t.system == \"{model}\"]; M = lambda k: t[t.matrix == k].pivot(index=\"i\", columns=\"j\", values=\"value\").to_numpy(); sys = control.ss(M(\"A\"), M(\"B\"), M(\"C\"), M(\"D\"))"
                    ),
                ),
                (
                    "julia",
                    format!(
                        "using CSV, DataFrames, ControlSystems; t = filter(r -> r.system == \"{model}\", CSV.read({quoted}, DataFrame)); M(k) = (s = filter(r -> r.matrix == k, t); Z = zeros(maximum(s.i), maximum(s.j)); foreach(r -> Z[r.i, r.j] = r.value, eachrow(s)); Z); sys = ss(M(\"A\"), M(\"B\"), M(\"C\"), M(\"D\"))"
                    ),
                ),
                (
                    "matlab",
                    format!(
                        "f = fopen({single}); c = textscan(f, '%s%s%f%f%s%s%s%s%f%f', 'Delimiter', ',', 'HeaderLines', 1); fclose(f); s = strcmp(c{{1}}, '{model}'); M = @(k) accumarray([c{{3}}(s & strcmp(c{{2}}, k)) c{{4}}(s & strcmp(c{{2}}, k))], c{{9}}(s & strcmp(c{{2}}, k))); sys = ss(M('A'), M('B'), M('C'), M('D'))"
                    ),
                ),
            ],
        }
    }
}

/// Writes the linear models of a study to `path`, in the form its ending names; a file that is there is replaced in one step.
pub fn write_linear(row: &DynamicsRow, path: &Path) -> Result<LinearFormat, ExportError> {
    let shown = path.display().to_string();
    let format = LinearFormat::from_path(path).ok_or_else(|| ExportError::Ending { path: shown.clone() })?;
    let failed = |source| ExportError::File { path: shown.clone(), source };
    let bytes = match format {
        LinearFormat::Mat => mat(row).map_err(failed)?,
        LinearFormat::Json => linear_json(row, path).to_string().into_bytes(),
        LinearFormat::Csv => csv(row).into_bytes(),
    };
    replace(path, &bytes).map_err(failed)?;
    Ok(format)
}

/// The models as one JSON document, with the lines that load it from `path`.
pub fn linear_json(row: &DynamicsRow, path: &Path) -> Value {
    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let lines = LinearFormat::Json.load_lines(&file);
    let load: serde_json::Map<String, Value> =
        lines.into_iter().map(|(tool, line)| (tool.to_owned(), line.into())).collect();
    json!({
        "format": "doublet linear models",
        "version": 1,
        "signs": row.signs,
        "trim": row.trim,
        "windows": row.windows,
        "notes": row.notes,
        "load": load,
        "systems": row.systems,
    })
}

/// Entries of a matrix, column by column.
fn columns(rows: &[Vec<f64>]) -> Vec<f64> {
    let width = rows.first().map_or(0, Vec::len);
    (0..width).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
}

/// Numbers of the trim by name, from its row; those of the centre of gravity apart.
fn trim_numbers(row: &DynamicsRow) -> Vec<(String, Vec<f64>)> {
    let Ok(Value::Object(fields)) = serde_json::to_value(&row.trim) else { return Vec::new() };
    let numbers = |value: &Value| match value {
        Value::Array(values) => values.iter().filter_map(Value::as_f64).collect(),
        other => other.as_f64().into_iter().collect(),
    };
    fields.iter().map(|(name, value)| (name.clone(), numbers(value))).collect()
}

fn mat(row: &DynamicsRow) -> std::io::Result<Vec<u8>> {
    let mut bytes = header().to_vec();
    let trim = trim_numbers(row);
    for (name, model) in &row.systems {
        let matrices: Vec<(&str, usize, Vec<f64>)> = matrices(model)
            .into_iter()
            .chain([
                ("A_standard_error", &model.A_standard_error),
                ("B_standard_error", &model.B_standard_error),
                ("covariance", &model.covariance),
            ])
            .map(|(key, rows)| (key, rows.len(), columns(rows)))
            .collect();
        let mut fields = Node::Fields(Vec::new());
        for (key, rows, values) in &matrices {
            fields.insert(key, Node::Matrix(values, *rows));
        }
        for (key, lines) in [
            ("states", &model.states),
            ("state_units", &model.state_units),
            ("inputs", &model.inputs),
            ("input_units", &model.input_units),
            ("outputs", &model.outputs),
            ("output_units", &model.output_units),
        ] {
            fields.insert(key, Node::Lines(lines.iter().map(String::as_str).collect()));
        }
        for (key, values) in &trim {
            fields.insert(&format!("trim/{key}"), Node::Numbers(values));
        }
        fields.insert("signs", Node::Text(row.signs));
        let _ = write_variable(&mut bytes, name, &fields)?;
    }
    Ok(bytes)
}

/// The four matrices by name.
fn matrices(model: &LinearRow) -> Vec<(&'static str, &Vec<Vec<f64>>)> {
    vec![("A", &model.A), ("B", &model.B), ("C", &model.C), ("D", &model.D)]
}

fn csv(row: &DynamicsRow) -> String {
    let mut text = String::from("system,matrix,i,j,row,row_unit,column,column_unit,value,standard_error\n");
    for (system, model) in &row.systems {
        for (matrix, rows) in matrices(model) {
            let (of_rows, row_units) =
                if matrix < "C" { (&model.states, &model.state_units) } else { (&model.outputs, &model.output_units) };
            let by_state = matrix == "A" || matrix == "C";
            let (of_columns, column_units) =
                if by_state { (&model.states, &model.state_units) } else { (&model.inputs, &model.input_units) };
            let errors = match matrix {
                "A" => Some(&model.A_standard_error),
                "B" => Some(&model.B_standard_error),
                _ => None,
            };
            for (i, values) in rows.iter().enumerate() {
                for (j, value) in values.iter().enumerate() {
                    // Of A and B each row is the rate of its state.
                    let per_second = if errors.is_some() { "/s" } else { "" };
                    let error = errors.map(|errors| errors[i][j].to_string()).unwrap_or_default();
                    let _ = writeln!(
                        text,
                        "{system},{matrix},{},{},{},{}{per_second},{},{},{value},{error}",
                        i + 1,
                        j + 1,
                        of_rows[i],
                        row_units[i],
                        of_columns[j],
                        column_units[j],
                    );
                }
            }
        }
    }
    text
}
