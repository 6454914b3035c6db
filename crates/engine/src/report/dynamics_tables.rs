//! Tables of how the identified aircraft flies: state matrices, modes, levels of flying qualities.

use super::dynamics::{LinearRow, MeasuredRow, ModeRow, QualitiesRow, QualityRow};
use super::table::{Cell, Column, Table, TableOf};
use crate::notation::{self, significant};

/// A and B of a part of the motion, one row per state, and their standard errors.
pub fn matrix_tables(key: &str, name: &str, model: &LinearRow) -> [Table; 2] {
    let caption = format!("{name}: A and B in m, s, rad, N; more digits and standard errors in the results.");
    let errors = format!("{name}: standard errors of A and B.");
    [
        matrices((format!("matrices_{key}"), caption), model, ([&model.A, &model.B], 4)),
        matrices((format!("errors_{key}"), errors), model, ([&model.A_standard_error, &model.B_standard_error], 2)),
    ]
}

fn matrices(
    (name, caption): (String, String),
    model: &LinearRow,
    ([a, b], digits): ([&[Vec<f64>]; 2], usize),
) -> Table {
    let heads = model.states.iter().chain(&model.inputs);
    let numbers = heads.map(|head| Column::number(head, notation::role_symbol(head), "", digits));
    let rows = model.states.iter().enumerate().map(|(index, state)| {
        let values = a[index].iter().chain(&b[index]).map(|value| Cell::Number(*value));
        std::iter::once(Cell::text(format!("{}'", notation::role_symbol(state)))).chain(values).collect()
    });
    Table {
        name,
        caption,
        columns: std::iter::once(Column::new("row", "")).chain(numbers).collect(),
        rows: rows.collect(),
    }
}

/// Natural modes with their standard errors and the 95 % intervals of the frequency, of the real part where aperiodic.
pub fn mode_table(modes: &[ModeRow]) -> Table {
    let error = |mode: &ModeRow, key: &str| Some(mode.intervals.get(key)?.delta?.standard_error);
    let shown = |mode: &ModeRow| {
        mode.intervals.get(if mode.period_s.is_some() { "frequency_rad_s" } else { "real_1_s" }).copied()
    };
    let by_slopes = |mode: &ModeRow| shown(mode)?.delta;
    let sampled = |mode: &ModeRow| shown(mode)?.sampled;
    let name = |mode: &ModeRow| match mode.not_judged {
        Some(_) => format!("{} (not judged)", mode.name),
        None => mode.name.to_owned(),
    };
    let oscillating = |mode: &ModeRow, value: Option<f64>| mode.period_s.and(value);
    let caption = "Natural modes with standard errors; the sampled 95 % interval is that of the frequency, or of the real part of aperiodic modes, which have neither frequency nor damping.";
    TableOf::new("modes", caption, modes)
        .column(Column::new("mode", "Mode"), |mode| Cell::text(name(mode)))
        .number("real", "Real", "1/s", 3, |mode| mode.real_1_s)
        .maybe("real_error", "±", "1/s", 2, |mode| error(mode, "real_1_s"))
        .maybe("imaginary", "Imaginary", "rad/s", 4, |mode| oscillating(mode, Some(mode.imaginary_rad_s)))
        .maybe("imaginary_error", "±", "rad/s", 2, |mode| oscillating(mode, error(mode, "imaginary_rad_s")))
        .maybe("frequency", "Frequency", "rad/s", 4, |mode| oscillating(mode, Some(mode.frequency_rad_s)))
        .maybe("frequency_error", "±", "rad/s", 2, |mode| oscillating(mode, error(mode, "frequency_rad_s")))
        .maybe("damping", "Damping", "", 3, |mode| oscillating(mode, Some(mode.damping)))
        .maybe("damping_error", "±", "", 2, |mode| oscillating(mode, error(mode, "damping")))
        .maybe("period", "Period", "s", 3, |mode| mode.period_s)
        .maybe("half", "Time to half", "s", 3, |mode| mode.time_to_half_s)
        .maybe("double", "Time to double", "s", 3, |mode| mode.time_to_double_s)
        .maybe("slopes_low", "By slopes from", "", 4, |mode| Some(by_slopes(mode)?.low))
        .maybe("slopes_high", "to", "", 4, |mode| Some(by_slopes(mode)?.high))
        .maybe("low", "95 % from", "", 4, |mode| Some(sampled(mode)?.low))
        .maybe("high", "to", "", 4, |mode| Some(sampled(mode)?.high))
        .done()
}

/// Columns of the modes that people read.
const MODES: [&str; 12] = [
    "mode", "real", "real_error", "frequency", "frequency_error", "damping", "damping_error", "period", "half",
    "double", "low", "high",
];

/// Natural modes as people read them.
pub fn shown_mode_table(modes: &[ModeRow]) -> Table {
    mode_table(modes).select(&MODES)
}

/// Modes measured in the free responses.
pub fn measured_table(rows: &[MeasuredRow]) -> Table {
    let caption = "Modes measured in the free response at the end of each manoeuvre, without the model.";
    TableOf::new("measured_modes", caption, rows)
        .text("window", "Manoeuvre", |row| &row.window)
        .number("start_s", "Start", "s", 6, |row| row.start_s)
        .number("end_s", "End", "s", 6, |row| row.end_s)
        .optional("mode", "Near", |row| row.name)
        .maybe("real", "Real", "1/s", 4, |row| row.real_1_s)
        .maybe("real_error", "±", "1/s", 2, |row| row.real_standard_error)
        .maybe("imaginary", "Imaginary", "rad/s", 4, |row| row.imaginary_rad_s)
        .maybe("imaginary_error", "±", "rad/s", 2, |row| row.imaginary_standard_error)
        .maybe("frequency", "Frequency", "rad/s", 4, |row| row.frequency_rad_s)
        .maybe("damping", "Damping", "", 4, |row| row.damping)
        .optional("error", "", |row| row.error.as_deref())
        .done()
}

/// Level of every criterion that is judged.
pub fn level_table(found: &QualitiesRow) -> Table {
    let percent =
        |share: Option<f64>| share.map_or_else(String::new, |share| format!("{} %", significant(100.0 * share, 3)));
    let caption = "Levels of flying qualities with 95 % intervals and probabilities; levels in brackets do not count.";
    TableOf::new("levels", caption, found.criteria.iter().filter(|row| row.is_judged()))
        .text("criterion", "Criterion", |row| &row.criterion)
        .column(Column::new("values", "Values [95 % interval]"), |row| values(row))
        .column(Column::new("level", "Level"), |row| Cell::text(row.level_text()))
        .column(Column::new("probability", "Probability"), |row| Cell::text(percent(row.probability())))
        .column(Column::new("reasons", "Not Level 1 because"), |row| {
            Cell::text(notation::raise_powers(&row.reasons.join("; ")))
        })
        .done()
}

/// Standard and paragraph of every criterion, and what is needed to judge those that are not judged.
pub fn criterion_table(found: &QualitiesRow) -> Table {
    let caption = "Paragraphs of the flying-quality criteria, and the data needed for those not judged.";
    TableOf::new("levels_sources", caption, &found.criteria)
        .text("criterion", "Criterion", |row| &row.criterion)
        .column(Column::new("paragraph", "Standard and paragraph"), |row| {
            Cell::text(format!("{}, {}", row.standard, row.source))
        })
        .text("needed", "Needed", |row| row.needed.as_deref().unwrap_or("judged"))
        .done()
}

fn values(row: &QualityRow) -> Cell {
    Cell::text(notation::raise_powers(&row.value_texts(|value| significant(value, 3)).join("; ")))
}
