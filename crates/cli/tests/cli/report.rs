//! Reports and tables from the command line, against the results they are made from.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::common::at_root::{doublet, printed};
use crate::common::root;

/// A report of the session as text, made on the day of that second.
fn dated(session: &str, out: &Path, second: &str) -> Vec<u8> {
    let arguments =
        ["report", session, "--out", out.to_str().unwrap(), "--format", "pdf,html", "--sections", "overview"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
    let output = command.args(arguments).env("SOURCE_DATE_EPOCH", second).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    [std::fs::read(out.join("small <b>&.html")).unwrap(), std::fs::read(out.join("small <b>&.pdf")).unwrap()].concat()
}

#[test]
fn a_report_states_its_date_and_can_be_made_again_to_the_byte() {
    let folder = tempfile::tempdir().unwrap();
    let session = small_session(folder.path());
    let session = session.to_str().unwrap();
    let first = dated(session, &folder.path().join("a"), "1592179200");
    assert!(String::from_utf8_lossy(&first).contains("<dd>2020-06-15</dd>"));
    assert!(first == dated(session, &folder.path().join("b"), "1592265599"), "the same day, other bytes");
    assert!(first != dated(session, &folder.path().join("c"), "1592265600"), "another day, the same bytes");
}

/// The shipped session with two of its windows, one of them kept for validation.
fn small_session(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml")).unwrap();
    let mut session: toml::Table = text.parse().unwrap();
    let windows = session["manoeuvre"].as_array_mut().unwrap();
    let of = |surface: &str| {
        let mut found = windows.iter().filter(|window| window["surface"].as_str() == Some(surface)).cloned();
        [found.next().unwrap(), found.next().unwrap()]
    };
    let mut kept = [of("elevator"), of("aileron"), of("rudder")].concat();
    kept[1]["role"] = "validation".into();
    let mut ignored = windows.last().unwrap().clone();
    ignored["role"] = "ignored".into();
    ignored.as_table_mut().unwrap().insert("note".to_owned(), "gust at 3 s".into());
    kept.push(ignored);
    *windows = kept;
    // The empty aircraft as a weighing sets it.
    let weighed: toml::Table = "\"mass.mass_kg\" = 1381.5\n\"mass.cg_datum_m\" = [3.5669, 0.0, 1.74]".parse().unwrap();
    session.insert("aircraft_changes".to_owned(), weighed.into());
    session["flight"][0].as_table_mut().unwrap().insert("crew".to_owned(), "A. Pilot & B.".into());
    let path = folder.join("small <b>&.toml");
    std::fs::write(&path, toml::to_string(&session).unwrap()).unwrap();
    path
}

/// Every number of a JSON value, by its bits.
fn numbers(value: &Value, found: &mut BTreeSet<u64>) {
    match value {
        Value::Number(number) => {
            found.insert(number.as_f64().unwrap().to_bits());
        }
        Value::Array(values) => values.iter().for_each(|value| numbers(value, found)),
        Value::Object(entries) => entries.values().for_each(|value| numbers(value, found)),
        _ => {}
    }
}

/// Sections of a report of everything, in order.
const SECTIONS: [&str; 24] = [
    "Overview",
    "Aircraft and loading",
    "Instrumentation",
    "Manoeuvres",
    "Filter settings and consistency",
    "Wind and biases",
    "Innovations",
    "Model structure and correlation",
    "Aerodynamic and control derivatives",
    "Fits and residuals",
    "Validation",
    "Proof of match",
    "Independent checks",
    "Sensitivity to stated quantities",
    "Dependence on flight condition",
    "Frequency responses",
    "Linear model, modes and flying qualities",
    "Engines",
    "Conclusions",
    "Recordings",
    "Mass properties",
    "Fits of each manoeuvre",
    "State matrices and paragraphs of the criteria",
    "Findings",
];

#[test]
fn report_and_tables_hold_the_numbers_of_the_results() {
    let folder = tempfile::tempdir().unwrap();
    let session = small_session(folder.path());
    let session = session.to_str().unwrap();
    let out = folder.path().join("results");
    let forms = ["--tables", "csv,latex,markdown", "--histories", "hdf5,mat,parquet", "--recordings"];
    let with = ["--with", "sensitivity,checks,responses,dynamics,manoeuvres"];
    printed(&[&["run", session, "--out", out.to_str().unwrap()][..], &forms, &with].concat());
    let results: Value = serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    let mut known = BTreeSet::new();
    numbers(&results, &mut known);
    tables_agree(&out, &known);
    let named = |name: &str| std::fs::metadata(out.join(name)).unwrap().len();
    assert!(named("histories.h5") > 100_000 && named("histories.mat") > 100_000);

    let reports = folder.path().join("reports");
    printed(&["report", session, "--out", reports.to_str().unwrap()]);
    let html = std::fs::read_to_string(reports.join("small <b>&.html")).unwrap();
    let shown: Vec<f64> =
        html.split("<data value=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    assert!(shown.len() > 500, "{} numbers", shown.len());
    // Angles are shown in degrees.
    let in_degrees: Vec<u64> =
        known.iter().map(|bits| (f64::from_bits(*bits) * (180.0 / std::f64::consts::PI)).to_bits()).collect();
    known.extend(in_degrees);
    // Engine speeds are shown in rev/min: 2778 rev/min are 16668 deg/s.
    let in_revolutions: Vec<u64> =
        known.iter().map(|bits| (f64::from_bits(*bits) * (60.0 / std::f64::consts::TAU)).to_bits()).collect();
    known.extend(in_revolutions);
    // Powers are shown in kilowatts.
    let in_kilowatts: Vec<u64> = known.iter().map(|bits| (f64::from_bits(*bits) * 1e-3).to_bits()).collect();
    known.extend(in_kilowatts);
    engine_speeds_are_in_revolutions(&html, &results);
    accuracies_are_those_of_the_instruments_file(&html);
    // What rounding alone moved is shown as zero.
    let strange: Vec<f64> = shown.into_iter().filter(|v| *v != 0.0 && !known.contains(&v.to_bits())).collect();
    assert!(strange.is_empty(), "not in results.json: {strange:?}");
    let mut last = 0;
    for title in SECTIONS {
        let place = html.find(&format!(" {title}</h2>")).unwrap_or_else(|| panic!("{title} is missing"));
        assert!(place > last, "{title} is out of order");
        last = place;
    }
    for absent in ["was not computed", "Comparison with the earlier estimate"] {
        assert!(!html.contains(absent), "an empty section is in the report: {absent}");
    }
    first_page_has_the_answer(&html, &results);
    levels_name_the_coefficients_they_rest_on(&html, &results);
    let recording = results["recordings"][0]["sha256"].as_str().unwrap();
    assert!(html.contains(recording) && html.contains(results["session_sha256"].as_str().unwrap()));
    assert!(
        !html.contains("http://")
            || html.matches("http://").count() == html.matches("http://www.w3.org/2000/svg").count()
    );
    assert_eq!(html.matches("<svg").count(), html.matches("<figcaption>").count());
    let cover = html.split("</div><nav>").next().unwrap();
    for part in [
        "Purpose",
        "date not recorded, crew: A. Pilot &amp; B.",
        "Date of this report",
        "of 6 manoeuvres",
        "1 for validation",
        "Proof of match",
        " notes",
    ] {
        assert!(cover.contains(part), "{part} is not in {cover}");
    }
    let empty = html.split(">Empty aircraft<").nth(1).unwrap().split("</dl>").next().unwrap_or_default();
    for part in ["1381.50 kg", "x 3.5669 m", "(weighing)"] {
        assert!(empty.contains(part), "{part} is not in {empty}");
    }
    assert!(html.contains("Not used: ") && html.contains(" (gust at 3 s)."));
    // Engines and windows that say the same with other numbers are one line.
    assert_eq!(html.matches("propeller speed").count(), 1);
    let pdf = std::fs::read(reports.join("small <b>&.pdf")).unwrap();
    assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
    assert!((50_000..2_000_000).contains(&pdf.len()), "{} bytes", pdf.len());
}

/// CSV has the numbers of the results to the last bit; LaTeX and Markdown have as many rows and closed environments.
fn tables_agree(out: &Path, known: &BTreeSet<u64>) {
    let mut tables = 0;
    for entry in std::fs::read_dir(out).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "csv") {
            continue;
        }
        tables += 1;
        let mut reader = csv::Reader::from_path(&path).unwrap();
        let columns = reader.headers().unwrap().len();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        for cell in rows.iter().flatten() {
            if let Ok(value) = cell.parse::<f64>() {
                assert!(known.contains(&value.to_bits()), "{}: {cell} is not in results.json", path.display());
            }
        }
        let latex = std::fs::read_to_string(path.with_extension("tex")).unwrap();
        let body = latex.split("\\midrule\n").nth(1).unwrap();
        let lines: Vec<&str> = body.lines().filter(|line| line.ends_with("\\\\")).collect();
        assert_eq!(lines.len(), rows.len(), "{}", path.display());
        for line in lines {
            let cells = line.replace("\\&", "").matches(" & ").count() + 1;
            assert_eq!(cells, columns, "{line}");
            let depth = line.replace("\\{", "").replace("\\}", "");
            assert_eq!(depth.matches('{').count(), depth.matches('}').count(), "{line}");
            assert_eq!(line.replace("\\$", "").matches('$').count() % 2, 0, "{line}");
        }
        for command in ["\\toprule", "\\bottomrule", "\\caption{", "\\label{"] {
            assert_eq!(latex.matches(command).count(), 1, "{}: {command}", path.display());
        }
        assert_eq!(latex.matches("\\begin{").count(), latex.matches("\\end{").count());
        let markdown = std::fs::read_to_string(path.with_extension("md")).unwrap();
        assert_eq!(markdown.lines().filter(|line| line.starts_with("| ")).count(), rows.len() + 2);
    }
    assert!(tables >= 18, "{tables} tables");
}

#[test]
fn sections_and_forms_are_selectable() {
    let folder = tempfile::tempdir().unwrap();
    let session = small_session(folder.path());
    let out = folder.path().join("reports");
    let chosen = ["--format", "html", "--sections", "derivatives,overview"];
    printed(&[&["report", session.to_str().unwrap(), "--out", out.to_str().unwrap()][..], &chosen].concat());
    let html = std::fs::read_to_string(out.join("small <b>&.html")).unwrap();
    assert_eq!(html.matches("<section id=\"appendix-").count(), 2);
    assert_eq!(html.matches("<section").count(), 4);
    // In the order named.
    assert!(html.find(">A Derivatives of each manoeuvre</h2>").unwrap() < html.find(">B Recordings</h2>").unwrap());
    assert!(html.find("1 Aerodynamic and control derivatives</h2>").unwrap() < html.find("2 Overview</h2>").unwrap());
    assert!(!out.join("small <b>&.pdf").exists());
    let short = folder.path().join("short");
    let chosen = ["--format", "html", "--sections", "derivatives,overview,prior,checks", "--no-appendix"];
    printed(&[&["report", session.to_str().unwrap(), "--out", short.to_str().unwrap()][..], &chosen].concat());
    let html = std::fs::read_to_string(short.join("small <b>&.html")).unwrap();
    assert!(!html.contains("appendix-") && !html.contains("id=\"prior\""), "appendix or empty section");
    assert_eq!(html.matches("<section").count(), 3);
    let refused = doublet(&["report", session.to_str().unwrap(), "--sections", "summary"]);
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("derivatives"), "{message}");
}

#[test]
fn purpose_and_derivatives_asked_for_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let path = small_session(folder.path());
    let mut session: toml::Table = std::fs::read_to_string(&path).unwrap().parse().unwrap();
    session.insert("report_purpose".to_owned(), "Identify the rudder of the twin.".into());
    let asked = ["Cm_alpha", "Cn_delta_r", "Cm_delta_f"].map(toml::Value::from);
    session.insert("report_asked".to_owned(), toml::Value::Array(asked.into()));
    std::fs::write(&path, toml::to_string(&session).unwrap()).unwrap();
    let out = folder.path().join("asked");
    let chosen = ["--format", "html", "--sections", "derivatives,purpose", "--no-appendix"];
    printed(&[&["report", path.to_str().unwrap(), "--out", out.to_str().unwrap()][..], &chosen].concat());
    let html = std::fs::read_to_string(out.join("small <b>&.html")).unwrap();
    // On the first page and in its section, which stands where it was asked for.
    assert_eq!(html.matches("Identify the rudder of the twin.").count(), 2);
    assert!(html.contains("3 derivatives: 2 estimated"));
    assert!(html.find("<section id=\"derivatives\">").unwrap() < html.find("<section id=\"purpose\">").unwrap());
    let table = html.split("-asked\">").nth(1).unwrap().split("</table>").next().unwrap();
    let rows: Vec<&str> = table.split("<tr>").skip(2).collect();
    assert_eq!(rows.len(), 3, "{table}");
    let derivatives = html.split("<section id=\"derivatives\">").nth(1).unwrap().split("</section>").next().unwrap();
    for row in &rows[..2] {
        let value = row.split("<data value=\"").nth(1).unwrap().split('"').next().unwrap();
        assert!(derivatives.contains(&format!("<data value=\"{value}\">")), "{row}");
    }
    assert!(rows[2].contains("not in the model") && !rows[2].contains("<data"), "{}", rows[2]);
}

/// Half width of a 95 % interval in standard deviations of a normal distribution.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Largest engine speed of the table of sensors, from the results in rad/s.
fn engine_speeds_are_in_revolutions(html: &str, results: &Value) {
    let channels = results["flights"][0]["channels"].as_array().unwrap();
    let speed = channels.iter().find(|row| row["role"] == "engine_speed_1").unwrap();
    let largest = speed["maximum"].as_f64().unwrap() * 60.0 / std::f64::consts::TAU;
    let row = html.split("engine_speed_1").nth(1).unwrap().split("</tr>").next().unwrap();
    assert!(row.contains("rev/min"), "{row}");
    let shown: Vec<f64> =
        row.split("<data value=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    assert!(shown.iter().any(|value| (value - largest).abs() < 1e-6 * largest), "{largest} is not in {shown:?}");
}

/// The table of sensors has the accuracies that the instruments file states, not only the noise of the filter: 5.61e-3 m/s^2 along y.
fn accuracies_are_those_of_the_instruments_file(html: &str) {
    let table = html.split("-sensors\">").nth(1).unwrap().split("</table>").next().unwrap();
    assert!(table.contains(">Accuracy</th>") && table.contains("<data value=\"0.00561\">"), "{table}");
    // One line for all channels of one source, of two sources.
    assert_eq!(html.matches("Accuracy of ").count(), 2);
    assert!(html.contains("Accuracy of ax, ay, az, p, q, r, "));
    assert!(html.contains("airspeed: thesis Tables 4.15-4.16."));
}

/// On the first page and in the conclusions the level stands with its criteria and with every coefficient whose verdict is not good.
fn levels_name_the_coefficients_they_rest_on(html: &str, results: &Value) {
    let qualities = &results["dynamics"]["qualities"];
    let criteria = qualities["criteria"].as_array().unwrap();
    let judged: Vec<&Value> = criteria.iter().filter(|row| row["needed"].is_null() && row["counts"] == true).collect();
    let extent = format!("{} of {} criteria judged and counted", judged.len(), criteria.len());
    let cover = html.split("</div><nav>").next().unwrap();
    let conclusions = html.split(" Conclusions</h2>").nth(1).unwrap().split("</h2>").next().unwrap();
    // Both motions are judged, so that every coefficient counts.
    let mut doubtful = 0;
    for text in [cover, conclusions] {
        let line = text.split("MIL-F-8785C").nth(1).unwrap().split("</").next().unwrap();
        assert!(line.contains(&extent), "{extent} is not in {line}");
        for fit in results["pooled"].as_array().unwrap() {
            let (name, level) = (fit["coefficient"].as_str().unwrap(), fit["verdict"]["level"].as_str().unwrap());
            assert_eq!(line.contains(&format!("{name} ({level}")), level != "good", "{name} {level}: {line}");
            doubtful += usize::from(level != "good");
        }
    }
    assert!(doubtful > 0, "every coefficient is good: nothing is tested");
}

/// Estimate and interval of every derivative on the first page, computed from the results alone.
fn first_page_has_the_answer(html: &str, results: &Value) {
    let cover = html.split("</div><nav>").next().unwrap();
    let table = cover.split("-answer\">").nth(1).unwrap().split("</table>").next().unwrap();
    let shown: Vec<Vec<f64>> = table
        .split("<tr>")
        .skip(2)
        .map(|row| {
            row.split("<data value=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect()
        })
        .collect();
    assert!(shown.len() >= 10, "{} derivatives on the first page", shown.len());
    let known: Vec<(f64, f64)> = results["pooled"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|fit| fit["derivatives"].as_array().unwrap())
        .filter_map(|row| Some((row["estimate"].as_f64()?, row["corrected_standard_error"].as_f64()?)))
        .collect();
    for row in shown {
        assert_eq!(row.len(), 3, "{row:?}");
        let (estimate, low, high) = (row[0], row[1], row[2]);
        let (_, error) = known.iter().find(|(value, _)| *value == estimate).unwrap();
        assert!((high - low - 2.0 * NORMAL_95 * error).abs() < 1e-9 * error, "{row:?} and {error}");
        assert!((0.5 * (high + low) - estimate).abs() < 1e-9 * error, "{row:?}");
    }
}

/// Pages of a PDF whose page objects are not compressed.
pub(crate) fn pages(pdf: &[u8]) -> usize {
    let mark = b"/Type/Page";
    pdf.windows(mark.len() + 1).filter(|part| part.starts_with(mark) && part[mark.len()] != b's').count()
}

#[test]
fn body_of_the_demonstration_is_short_and_the_answer_is_first() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    printed(&["report", "sessions/demo.toml", "--out", out, "--format", "pdf", "--no-appendix"]);
    let pdf = std::fs::read(folder.path().join("demo.pdf")).unwrap();
    let count = pages(&pdf);
    assert!((8..=18).contains(&count), "{count} pages");
}

/// Logo, words, colour, units and order of the sections by a file, and what is wrong with one.
#[test]
fn house_style_and_order_of_sections_come_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let style = folder.path().join("house.toml");
    let head = "format = \"doublet report style\"\nversion = 1\n";
    let logo =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\"><rect width=\"40\" height=\"20\"/></svg>";
    std::fs::write(folder.path().join("logo.svg"), logo).unwrap();
    let text = format!(
        "{head}header = \"Flight test house\"\nfooter = \"Internal use\"\naccent = \"#884400\"\nlogo = \"logo.svg\"\nunits = \"aviation\"\n\
         sections = [\"path\", \"windows\"]\nsignatures = [\"Test engineer\"]\n"
    );
    std::fs::write(&style, text).unwrap();
    let out = folder.path().join("out");
    let arguments =
        ["report", "sessions/demo.toml", "--out", out.to_str().unwrap(), "--style", style.to_str().unwrap()];
    printed(&arguments);
    let html = std::fs::read_to_string(out.join("demo.html")).unwrap();
    for part in [
        "Flight test house",
        "Internal use",
        "#884400",
        "data:image/svg+xml;base64,PHN2Zy",
        "Airspeed [kt]",
        "Altitude [ft]",
    ] {
        assert!(html.contains(part), "the report does not say '{part}'");
    }
    let place = |name: &str| html.find(&format!("<section id=\"{name}\">")).unwrap();
    assert!(place("path") < place("windows") && place("windows") < place("appendix-path"));
    assert!(!html.contains("<section id=\"derivatives\">"));
    // Every manoeuvre has its channels beside the path and its biases, one in the body.
    assert!(html.matches("measured and reconstructed channels, and biases").count() >= 20);
    assert!(html.contains("measured channels, reconstructed path, and residuals"));
    assert!(std::fs::read(out.join("demo.pdf")).unwrap().starts_with(b"%PDF"));
    // An order on the command line stands before that of the file.
    let own = ["--sections", "windows,path", "--format", "html"];
    printed(&[&arguments[..], &own].concat());
    let html = std::fs::read_to_string(out.join("demo.html")).unwrap();
    let place = |name: &str| html.find(&format!("<section id=\"{name}\">")).unwrap();
    assert!(place("windows") < place("path"));
    std::fs::write(&style, format!("{head}accent = \"blue\"\n")).unwrap();
    let refused = doublet(&arguments);
    let line = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && line.contains("house.toml: accent: 'blue'"), "{line}");
}
