//! The first page: what was analysed, what came out, and whether to believe it.

use doublet_core::model::{AeroData, is_constant_name};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;

use super::conditions::{altitude_kind, conditions};
use super::{Block, Contents, findings, purpose};
use crate::date;
use crate::notation::{self, plural, significant};
use crate::report::QualityRow;
use crate::report::results::{DerivativeRow, FitRow, WindowRow};
use crate::report::table::{Table, TableOf};
use crate::session::{Level, WindowRole};
use crate::verdict::{self};

/// Steps there is room for.
const STEPS: usize = 4;

/// The derivatives that matter, with what each is.
const PRINCIPAL: [(&str, &str); 19] = [
    ("CD_alpha", "drag with angle of attack"),
    ("CX_alpha", "axial force with angle of attack"),
    ("CL_alpha", "lift with angle of attack"),
    ("CL_delta_e", "lift of the elevator"),
    ("CZ_alpha", "normal force with angle of attack"),
    ("CZ_delta_e", "normal force of the elevator"),
    ("Cm_alpha", "static stability in pitch"),
    ("Cm_q", "pitch damping"),
    ("Cm_delta_e", "elevator effectiveness"),
    ("CY_beta", "side force with sideslip"),
    ("Cl_beta", "dihedral effect"),
    ("Cl_p", "roll damping"),
    ("Cl_r", "roll due to yaw rate"),
    ("Cl_delta_a", "aileron effectiveness"),
    ("Cn_beta", "directional stability"),
    ("Cn_p", "yaw due to roll rate"),
    ("Cn_r", "yaw damping"),
    ("Cn_delta_a", "adverse yaw of the aileron"),
    ("Cn_delta_r", "rudder effectiveness"),
];

/// Facts, the answer, what to do next.
pub fn cover(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    let flights = results.flights.iter().map(|flight| {
        let date = flight.date.as_ref().map_or_else(|| "date not recorded".to_owned(), |date| format!("flown {date}"));
        let crew = if flight.crew.is_empty() { String::new() } else { format!(", crew: {}", flight.crew) };
        format!("{}, {date}{crew}", flight.name)
    });
    let mut facts = vec![("Purpose", purpose::stated(contents).map_or_else(|| scope(contents), str::to_owned))];
    facts.extend(purpose::summary(contents).map(|asked| ("Asked for", asked)));
    facts.extend([
        ("Aircraft", if results.aircraft.is_empty() { "not stated".to_owned() } else { results.aircraft.clone() }),
        ("Flight", flights.collect::<Vec<_>>().join("; ")),
        ("Date of this report", date::today()),
        ("Program", results.app.clone()),
        ("Session SHA-256", results.session_sha256.clone()),
    ]);
    let mut blocks = vec![facts_of(facts)];
    let verdict = contents.snapshot.verdicts.ready();
    blocks.extend(verdict.map(|found| Block::Outcome(found.session.level, format!("Verdict {}", found.headline()))));
    let answer = answer(contents);
    blocks.extend((!answer.rows.is_empty()).then_some(Block::Table(answer)));
    blocks.push(facts_of(levels(contents).into_iter().chain(summary(contents)).collect()));
    let next = next_steps(contents);
    if !next.is_empty() {
        blocks.extend([Block::Heading("Next steps".to_owned()), Block::List(next)]);
    }
    blocks
}

/// What is done in a session that does not state its purpose.
fn scope(contents: &Contents<'_>) -> String {
    let used = contents.session.active_windows().count();
    let flights = contents.session.flights.len();
    let what = match contents.results.pooled.is_empty() {
        true => "Flight paths",
        false => "Aerodynamic and control derivatives",
    };
    format!("{what} from {} of {}", plural(used, "manoeuvre"), plural(flights, "flight"))
}

/// Manoeuvres, filter, proof of match and findings in a line each.
fn summary<'a>(contents: &Contents<'_>) -> Vec<(&'a str, String)> {
    let (session, results) = (contents.session, contents.results);
    let used = |role: WindowRole| session.windows.iter().filter(|window| window.role == role).count();
    let windows = format!(
        "{} for identification, {} for validation, {} ignored",
        used(WindowRole::Identification),
        used(WindowRole::Validation),
        used(WindowRole::Ignored)
    );
    let mut summary = vec![("Manoeuvres", windows)];
    summary.extend(list_ranges(contents).map(|ranges| ("Identified within", ranges)));
    summary.extend(conditions(contents));
    summary.push(("Filter", consistency(&results.windows)));
    if !results.proof_of_match.windows.is_empty() {
        summary.push(("Proof of match", proof(contents)));
    }
    summary.push(("Findings", findings::counted(contents)));
    let failed = contents.snapshot.failures().len() + contents.snapshot.failed_fits().len();
    if failed > 0 {
        summary.push((
            "Not computed",
            format!("{failed} stages or coefficients: see the findings and the quality of the fits"),
        ));
    }
    summary
}

/// Ranges of the motion in the manoeuvres of the identification: the model is not known outside them.
fn list_ranges(contents: &Contents<'_>) -> Option<String> {
    let used = contents.session.windows.iter().filter(|window| window.role == WindowRole::Identification);
    let aero = used.filter_map(|window| contents.snapshot.windows.get(&window.name)?.aero.ready());
    let data: Vec<&AeroData> = aero.map(|aero| &aero.data).collect();
    let degrees = 180.0 / std::f64::consts::PI;
    let control = |role: Role| move |data: &AeroData| data.controls.get(&role).map_or(Vec::new(), |one| one.to_vec());
    let ranges = [
        describe_range(&data, ("V", " m/s", 1.0), &|data| data.airspeed_m_s.to_vec()),
        describe_range(&data, (altitude_kind(contents), " m", 1.0), &|data| {
            data.altitude_m.as_ref().map_or(Vec::new(), |one| one.to_vec())
        }),
        describe_range(&data, ("α", "°", degrees), &|data| data.alpha_rad.to_vec()),
        describe_range(&data, ("β", "°", degrees), &|data| data.beta_rad.to_vec()),
        describe_range(&data, ("δe", "°", degrees), &control(Role::Elevator)),
        describe_range(&data, ("δa", "°", degrees), &control(Role::Aileron)),
        describe_range(&data, ("δr", "°", degrees), &control(Role::Rudder)),
    ];
    let found: Vec<String> = ranges.into_iter().flatten().collect();
    (!found.is_empty()).then(|| found.join(", "))
}

/// A quantity by its symbol with its least and greatest value over some manoeuvres, in a unit of SI times `scale`.
fn describe_range(
    data: &[&AeroData],
    (name, unit, scale): (&str, &str, f64),
    values: &dyn Fn(&AeroData) -> Vec<f64>,
) -> Option<String> {
    let all = data.iter().flat_map(|data| values(data)).filter(|value| value.is_finite());
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let digits = if scale == 1.0 { 4 } else { 2 };
    // What is at rest is recorded with rounding.
    const REST_DEG: f64 = 0.005;
    let is_rest = |value: f64| scale != 1.0 && (scale * value).abs() < REST_DEG;
    let [from, to] = [low, high].map(|value| significant(if is_rest(value) { 0.0 } else { scale * value }, digits));
    let range = if from == to { from } else { format!("{from} to {to}") };
    (low <= high).then(|| format!("{name} {range}{unit}"))
}

/// The derivatives that matter, with their intervals; all of a model that has none of these.
fn answer(contents: &Contents<'_>) -> Table {
    let fits = contents.results.pooled.iter().filter(|fit| fit.error.is_none());
    let all: Vec<&DerivativeRow> = fits.flat_map(|fit| &fit.derivatives).collect();
    let main = PRINCIPAL.iter().filter_map(|(name, _)| all.iter().find(|row| row.name == *name).copied());
    let mut rows: Vec<&DerivativeRow> = main.collect();
    if rows.is_empty() {
        rows = all.into_iter().filter(|row| !is_constant_name(&row.name)).take(PRINCIPAL.len()).collect();
    }
    let words = |name: &str| PRINCIPAL.iter().find(|(known, _)| *known == name).map_or("", |(_, words)| *words);
    let caption = "Principal derivatives per radian, pooled, with 95 % intervals corrected for correlated residuals.";
    TableOf::new("answer", caption, rows)
        .symbol("derivative", "Derivative", |row| &row.name)
        .text("meaning", "Meaning", |row| words(&row.name))
        .number("estimate", "Estimate", "", 4, |row| row.estimate)
        .maybe("low", "95 % from", "", 4, |row| row.interval_95.map(|ends| ends[0]))
        .maybe("high", "to", "", 4, |row| row.interval_95.map(|ends| ends[1]))
        .optional("verdict", "Verdict", |row| row.verdict.as_ref().map(|verdict| verdict.level.name()))
        .done()
}

/// Levels of flying qualities that count, the worst first.
fn levels<'a>(contents: &Contents<'_>) -> Option<(&'a str, String)> {
    let qualities = &contents.results.dynamics.as_ref()?.qualities;
    let share = |row: &QualityRow| row.probabilities.map(|shares| 100.0 * shares[0]);
    let mut rows: Vec<&QualityRow> =
        qualities.criteria.iter().filter(|row| row.counts && share(row).is_some()).collect();
    rows.sort_by(|a, b| share(a).unwrap_or(0.0).total_cmp(&share(b).unwrap_or(0.0)));
    let parts = rows.iter().filter_map(|row| {
        let level: usize = row.level.strip_prefix("Level ")?.parse().ok()?;
        let share = 100.0 * row.probabilities?.get(level.checked_sub(1)?)?;
        Some(format!("{} {} ({} %)", row.criterion.replace('_', " "), row.level, significant(share, 3)))
    });
    let parts: Vec<String> = parts.collect();
    let (class, category) = (qualities.class, qualities.category);
    let overall = overall(contents)?;
    let standard = format!("{}, class {class}, category {category}: {overall}", qualities.standard);
    let of_parts = if parts.is_empty() {
        String::new()
    } else {
        format!(". Criteria, with the probability of their level: {}", parts.join("; "))
    };
    Some(("Flying qualities", format!("{standard}{of_parts}.")))
}

/// The worst level with how many criteria it rests on, and on which doubtful coefficients.
pub(super) fn overall(contents: &Contents<'_>) -> Option<String> {
    let qualities = &contents.results.dynamics.as_ref()?.qualities;
    let (level, extent) = (qualities.level.unwrap_or("not judged"), qualities.extent());
    let criteria = qualities.criteria.iter().filter(|row| row.is_judged() && row.counts);
    let doubtful = doubtful_coefficients(&contents.results.pooled, criteria);
    let doubtful = match doubtful.as_slice() {
        [] => String::new(),
        names => format!("; rests on doubtful coefficients: {}", names.join(", ")),
    };
    let mut used = contents.results.windows.iter().filter_map(|row| Some(row.verdict.as_ref()?.level)).peekable();
    let none_good = used.peek().is_some() && used.all(|level| level > Level::Good);
    let none_good = if none_good { "; no manoeuvre is good" } else { "" };
    let contradicted = contradicted_modes(contents);
    Some(format!("{level}, {extent}{doubtful}{none_good}{contradicted}"))
}

/// Quantities of modes on which responses, free responses and the model that is judged contradict each other.
fn contradicted_modes(contents: &Contents<'_>) -> String {
    let rows = contents.results.studies.mode_comparison.iter().filter(|row| !row.contradictions.is_empty());
    let names: Vec<String> =
        rows.map(|row| format!("{} {} ({}: {})", row.mode, row.quantity, row.surface, row.contradictions)).collect();
    if names.is_empty() { String::new() } else { format!("; 95 % intervals contradict on {}", names.join(", ")) }
}

/// Coefficients of the motion out of the plane of symmetry.
const LATERAL: [&str; 3] = ["CY", "Cl", "Cn"];
/// Beginnings of the keys of their measures.
const LATERAL_MEASURES: [&str; 4] = ["dutch_roll", "roll_", "spiral", "time_to_bank"];

/// Coefficients without a good verdict that criteria rest on, each with its level and the derivatives that are not good.
fn doubtful_coefficients<'r>(fits: &[FitRow], criteria: impl Iterator<Item = &'r QualityRow>) -> Vec<String> {
    let keys: Vec<&str> = criteria.flat_map(|row| row.values.keys().copied()).collect();
    let is_lateral = |key: &&str| LATERAL_MEASURES.iter().any(|begin| key.starts_with(begin));
    let (lateral, longitudinal) = (keys.iter().any(is_lateral), keys.iter().any(|key| !is_lateral(key)));
    let rests = |fit: &&FitRow| if LATERAL.contains(&fit.coefficient) { lateral } else { longitudinal };
    fits.iter().filter(rests).filter_map(describe_doubt).collect()
}

fn describe_doubt(fit: &FitRow) -> Option<String> {
    let level = fit.verdict.as_ref().map(|verdict| verdict.level).filter(|level| *level > Level::Good)?;
    let is_doubtful = |row: &&DerivativeRow| row.verdict.as_ref().is_some_and(|verdict| verdict.level > Level::Good);
    let rows = fit.derivatives.iter().filter(is_doubtful).filter(|row| !is_constant_name(&row.name));
    let names: Vec<String> = rows.map(|row| notation::derivative(&row.name)).collect();
    let names = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
    Some(format!("{} ({}{names})", fit.coefficient, level.name()))
}

/// Fixes of the worst findings.
pub(super) fn next_steps(contents: &Contents<'_>) -> Vec<String> {
    let found = verdict::folded(contents.session, contents.snapshot);
    let mut steps: Vec<String> = Vec::new();
    for line in found.iter().filter(|line| line.level > Level::Good && !line.fix.is_empty()) {
        let fix = with_symbols(contents, &sentence(&line.fix));
        // Fixes that differ in their last choice alone are one step.
        let begin = fix.split(" or ").next().unwrap_or_default();
        if steps.len() < STEPS && !steps.iter().any(|known| known.contains(begin)) {
            steps.push(format!("{}: {fix} ({})", with_symbols(contents, &line.place), line.level.name()));
        }
    }
    if is_not_validated(contents) {
        steps.push("Validation: Keep a manoeuvre of each surface out of the fit, or fly one more.".to_owned());
    }
    steps
}

/// A text with the symbols of the estimated derivatives and of the measurements for their names.
pub(super) fn with_symbols(contents: &Contents<'_>, text: &str) -> String {
    let derivatives = contents.results.pooled.iter().flat_map(|fit| &fit.derivatives).map(|row| row.name.as_str());
    let is_known = |word: &str| derivatives.clone().any(|name| name == word);
    let symbol = |word: &str| match Measurement::from_name(word) {
        Some(measurement) => notation::measurement(measurement).to_owned(),
        None if is_known(word) => notation::derivative(word),
        None => word.to_owned(),
    };
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let convert = |piece: &str| {
        let word = piece.trim_end_matches(|letter| !is_part(letter));
        symbol(word) + &piece[word.len()..]
    };
    text.split_inclusive(|letter| !is_part(letter)).map(convert).collect()
}

/// Whether there is a pooled estimate that no manoeuvre was kept to validate.
pub(super) fn is_not_validated(contents: &Contents<'_>) -> bool {
    !contents.results.pooled.is_empty() && contents.results.validation.is_empty()
}

/// The text with a capital letter at its beginning and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    let first = letters.next().map(|first| first.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn facts_of(facts: Vec<(&str, String)>) -> Block {
    Block::Facts(facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
}

/// Whether the innovations are as large as the filter says.
pub(super) fn consistency(windows: &[WindowRow]) -> String {
    let judged: Vec<&WindowRow> = windows.iter().filter(|window| window.mean_nis.is_finite()).collect();
    if judged.is_empty() {
        return "no manoeuvre was judged".to_owned();
    }
    let mean = |value: &dyn Fn(&WindowRow) -> f64| {
        significant(judged.iter().map(|window| value(window)).sum::<f64>() / judged.len() as f64, 3)
    };
    let inside = judged.iter().filter(|window| {
        let [low, high] = window.nis_band_correlated;
        (low..=high).contains(&window.mean_nis)
    });
    format!(
        "mean normalised innovation squared {}, expected {}; inside its 95 % band in {} of {} manoeuvres",
        mean(&|window| window.mean_nis),
        mean(&|window| window.expected_nis),
        inside.count(),
        judged.len()
    )
}

/// How many tests pass.
pub(super) fn proof(contents: &Contents<'_>) -> String {
    let found = &contents.results.proof_of_match;
    let flown = found.windows.iter().filter(|window| window.error.is_none()).count();
    let tests: Vec<bool> =
        found.windows.iter().flat_map(|window| window.tests.iter().map(|test| test.passed)).collect();
    if tests.is_empty() {
        return format!("no test applies; {flown} of {} validation manoeuvres simulated", found.windows.len());
    }
    let passed = tests.iter().filter(|passed| **passed).count();
    format!(
        "{passed} of {} tests pass over {flown} of {} manoeuvres, {}",
        tests.len(),
        found.windows.len(),
        found.tolerances
    )
}
