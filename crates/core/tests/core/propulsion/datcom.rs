//! Digital DATCOM: the listing and decks of the shared reference, thesis Table E.1, and damaged listings.

use std::path::{Path, PathBuf};

use doublet_core::load::aircraft;
use doublet_core::load::datcom::{
    AileronMeasure, DatcomAxes, DatcomDeck, DatcomListing, DatcomSection, DeckCondition, DeckReference, ListingError,
    PredictedDerivative, PredictionOptions, beside,
};
use proptest::prelude::*;

use super::support::{number, numbers, reference};
use crate::shared::shared;

/// Angles converted to radians and back, relative.
const ROUND_OFF: f64 = 1e-12;
/// Angle of attack of Table E.1, deg.
const TABLE_E1_ALPHA_DEG: f64 = 6.0;
/// Half the last digit of Table E.1, and for the elevator that of the listing's increments over 10 deg.
const TABLE_E1: f64 = 5.5e-4;

fn text() -> Option<String> {
    Some(std::fs::read_to_string(shared("reference/datcom_output.txt")?).unwrap())
}

fn listing() -> Option<DatcomListing> {
    Some(DatcomListing::parse(&text()?).unwrap())
}

fn named(derivatives: &[PredictedDerivative], name: &str) -> f64 {
    derivatives.iter().find(|derivative| derivative.name == name).map(|derivative| derivative.value).unwrap()
}

/// As listed: stability axes, rates against 2 V.
const AS_LISTED: PredictionOptions = PredictionOptions {
    axes: DatcomAxes::Stability,
    pitch_rate_chords: 0.5,
    lateral_rate_spans: 0.5,
    aileron: AileronMeasure::DownGoing,
};

/// Holds a column against the reference, which is in deg or 1/deg where `factor` is not 1.
fn assert_column(name: &str, found: &[f64], expected: &toml::Value, factor: f64) {
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len(), "{name}");
    for (found, expected) in found.iter().zip(expected) {
        let expected = expected * factor;
        assert!((found - expected).abs() <= ROUND_OFF * expected.abs(), "{name}: {found} is not {expected}");
    }
}

#[test]
fn listing_matches_every_number_of_the_reference() {
    let (Some(listing), Some(reference)) = (listing(), reference("datcom.toml")) else { return };
    let rad = 1.0_f64.to_radians();
    let sweep = &reference["alpha_sweep"];
    let s = &listing.statics;
    assert_column("alpha", &listing.alpha_rad, &sweep["alpha_deg"], rad);
    for (name, column) in [
        ("CD", &s.cd),
        ("CL", &s.cl),
        ("CM", &s.cm),
        ("CN", &s.cn),
        ("CA", &s.ca),
        ("CLA", &s.cl_alpha),
        ("CMA", &s.cm_alpha),
        ("CLB", &s.cl_beta),
    ] {
        assert_column(name, column, &sweep[name], 1.0);
    }
    // Printed once, for all angles.
    assert_eq!(s.cy_beta, vec![number(&sweep["CYB"]); 16]);
    assert_eq!(s.cn_beta, vec![number(&sweep["CNB"]); 16]);

    let downwash = listing.downwash.as_ref().unwrap();
    assert_column("q/q", &downwash.pressure_ratio, &reference["downwash"]["q_qinf"], 1.0);
    assert_column("downwash", &downwash.downwash_rad, &reference["downwash"]["epsilon_deg"], rad);
    assert_column("gradient", &downwash.gradient, &reference["downwash"]["depsilon_dalpha"], 1.0);

    let dynamic = listing.dynamic.as_ref().unwrap();
    assert_eq!(dynamic.cl_q, vec![number(&reference["dynamic"]["CLQ"]); 16]);
    assert_eq!(dynamic.cm_q, vec![number(&reference["dynamic"]["CMQ"]); 16]);
    assert_column("CLAD", &dynamic.cl_alpha_dot, &reference["dynamic"]["CLAD"], 1.0);
    assert_column("CMAD", &dynamic.cm_alpha_dot, &reference["dynamic"]["CMAD"], 1.0);
    assert!(dynamic.cl_p.iter().all(|v| v.is_nan()), "NDM: the program has no method");

    let elevator = listing.elevator.as_ref().unwrap();
    assert_column("elevator", &elevator.deflection_rad, &reference["elevator"]["delta_deg"], rad);
    assert_column("D(CL)", &elevator.cl, &reference["elevator"]["dCL"], 1.0);
    assert_column("D(CM)", &elevator.cm, &reference["elevator"]["dCM"], 1.0);
    assert_column("D(CD MIN)", &elevator.cd_min, &reference["elevator"]["dCDmin"], 1.0);
    let induced = reference["elevator"]["induced_drag"]["dCDI"].as_array().unwrap();
    assert_eq!(elevator.cd_induced.len(), induced.len());
    for (found, expected) in elevator.cd_induced.iter().zip(induced) {
        assert_column("D(CDI)", found, expected, 1.0);
    }

    let aileron = listing.aileron.as_ref().unwrap();
    assert_column("left", &aileron.left_rad, &reference["aileron"]["delta_left_deg"], rad);
    assert_column("right", &aileron.right_rad, &reference["aileron"]["delta_right_deg"], rad);
    assert_column("roll", &aileron.roll, &reference["aileron"]["Cl_roll"], 1.0);
    let yaw = reference["aileron"]["yaw"]["Cn"].as_array().unwrap();
    assert_eq!(aileron.yaw.len(), yaw.len());
    for (found, expected) in aileron.yaw.iter().zip(yaw) {
        assert_column("yaw", found, expected, 1.0);
    }
}

#[test]
fn listing_conditions_match_the_reference_and_name_the_faults_of_the_program() {
    let (Some(listing), Some(reference)) = (listing(), reference("datcom.toml")) else { return };
    let expected = &reference["conditions"];
    let c = listing.conditions;
    for (found, key) in [
        (c.mach, "mach"),
        (c.altitude_m, "altitude_m"),
        (c.airspeed_m_s, "velocity_m_s"),
        (c.pressure_pa, "pressure_Pa"),
        (c.temperature_k, "temperature_K"),
        (c.reynolds_per_m, "reynolds_per_m"),
        (c.area_m2, "S_m2"),
        (c.chord_m, "c_m"),
        (c.span_m, "b_m"),
        (c.reference_x_m, "x_cg_m"),
        (c.reference_z_m, "z_cg_m"),
    ] {
        assert_eq!(found, number(&expected[key]), "{key}");
    }
    assert_eq!(listing.title, "Cessna Skymaster: Body, Wing, Htail, Twin Vpanel, elevator");
    // 20012 N at 46.02 m/s: 0.9207, which the program prints as 4.09551, newtons taken for pounds.
    let level = listing.level_flight_cl.unwrap();
    assert!((level - number(&expected["CL_level"])).abs() < 1e-3, "{level}");
    assert_eq!(listing.warnings.len(), 3, "{:#?}", listing.warnings);
    assert!(listing.warnings[0].starts_with("line 49: level-flight lift coefficient 4.09551 is 4.4"));
    for (warning, line) in listing.warnings[1..].iter().zip(["line 58:", "line 243:"]) {
        assert!(warning.starts_with(line) && warning.contains("disagree with the first page"), "{warning}");
    }
}

#[test]
fn derivatives_as_listed_match_thesis_table_e_1() {
    let (Some(listing), Some(reference)) = (listing(), reference("datcom.toml")) else { return };
    let table = &reference["table_E1"];
    let found = listing.derivatives(TABLE_E1_ALPHA_DEG.to_radians(), &AS_LISTED).unwrap();
    for (name, key) in [
        ("CL_alpha", "CL_alpha"),
        ("Cm_alpha", "Cm_alpha"),
        ("CY_beta", "CY_beta"),
        // The printed table interchanges these two; the listing has roll -0.106 and yaw +0.119.
        ("Cl_beta", "Cl_beta"),
        ("Cn_beta", "Cn_beta"),
        ("CL_q", "CL_q_2V"),
        ("Cm_q", "Cm_q_2V"),
        ("CL_alpha_dot", "CL_alphadot_2V"),
        ("Cm_alpha_dot", "Cm_alphadot_2V"),
        ("CL_delta_e", "CL_de"),
        ("Cm_delta_e", "Cm_de"),
        // The printed -0.690 takes the increment of 4 deg for that of 1 deg.
        ("Cl_delta_a", "Cl_da"),
    ] {
        let (found, expected) = (named(&found, name), number(&table[key]));
        assert!((found - expected).abs() < TABLE_E1, "{name}: {found} is not {expected}");
    }
    let printed = number(&table["Cl_da_printed"]);
    assert!((named(&found, "Cl_delta_a") * 4.0 - printed).abs() < 1e-3, "{printed}");
}

#[test]
fn derivatives_against_q_c_over_v_are_half_those_listed() {
    let (Some(listing), Some(reference)) = (listing(), reference("datcom.toml")) else { return };
    let options = PredictionOptions { axes: DatcomAxes::Stability, ..PredictionOptions::default() };
    let found = listing.derivatives(TABLE_E1_ALPHA_DEG.to_radians(), &options).unwrap();
    for (name, key) in
        [("CL_q", "CL_q_V"), ("Cm_q", "Cm_q_V"), ("CL_alpha_dot", "CL_alphadot_V"), ("Cm_alpha_dot", "Cm_alphadot_V")]
    {
        let (found, expected) = (named(&found, name), number(&reference["table_E1"][key]));
        assert!((found - expected).abs() < TABLE_E1, "{name}: {found} is not {expected}");
    }
}

/// The body-axis slopes, found another way: from the listing's own CN and CA columns, which are body axes.
#[test]
fn body_axis_slopes_match_differences_of_the_normal_and_axial_force_columns() {
    let Some(listing) = listing() else { return };
    // CN and CA are rounded to 0.0005, over 2 deg that is 0.03 per rad; listed slopes are not chords: 0.05 more.
    let tolerance = 0.08;
    for k in 1..8 {
        let found = listing.derivatives(listing.alpha_rad[k], &PredictionOptions::default()).unwrap();
        let chord =
            |column: &[f64]| -(column[k + 1] - column[k - 1]) / (listing.alpha_rad[k + 1] - listing.alpha_rad[k - 1]);
        let (cz, cx) = (chord(&listing.statics.cn), chord(&listing.statics.ca));
        assert!((named(&found, "CZ_alpha") - cz).abs() < tolerance, "{k}: {} {cz}", named(&found, "CZ_alpha"));
        assert!((named(&found, "CX_alpha") - cx).abs() < tolerance, "{k}: {} {cx}", named(&found, "CX_alpha"));
    }
}

#[test]
fn body_axis_moments_and_controls_turn_with_the_angle_of_attack() {
    let Some(listing) = listing() else { return };
    let alpha = TABLE_E1_ALPHA_DEG.to_radians();
    let stability = listing.derivatives(alpha, &AS_LISTED).unwrap();
    let body = listing.derivatives(alpha, &PredictionOptions::default()).unwrap();
    let (sin, cos) = alpha.sin_cos();
    let close = |a: f64, b: f64| assert!((a - b).abs() < ROUND_OFF, "{a} is not {b}");
    close(named(&body, "Cl_beta"), -0.1058 * cos - 0.1188 * sin);
    close(named(&body, "Cn_beta"), -0.1058 * sin + 0.1188 * cos);
    close(named(&body, "CZ_q"), -0.5 * 5.480 * cos);
    close(named(&body, "CX_q"), 0.5 * 5.480 * sin);
    let (cl, cd) = (named(&stability, "CL_delta_e"), named(&stability, "CD_delta_e"));
    close(named(&body, "CZ_delta_e"), -cl * cos - cd * sin);
    // Induced drag falls as the elevator takes load off the tail: 6.32e-5 - 6.39e-4 over 10 deg.
    close(cd, (6.32e-5 - 6.39e-4) / 10.0_f64.to_radians());
    // Left down 4 deg, right up 5.8: rolls right, yaws left.
    close(named(&stability, "Cn_delta_a"), 2.0 * 1.941e-3 / 8.0_f64.to_radians());
    let half = PredictionOptions { aileron: AileronMeasure::HalfDifference, ..AS_LISTED };
    let found = listing.derivatives(alpha, &half).unwrap();
    close(named(&found, "Cl_delta_a"), -2.0 * 1.2035e-2 / 9.8_f64.to_radians());
    let outside = listing.derivatives(0.5, &AS_LISTED).unwrap_err().to_string();
    assert!(outside.starts_with("angle of attack is 0.5 rad, the listing covers -0.0349"), "{outside}");
}

/// The sign of every derivative the two methods share, and their size, beside flight results of thesis Tables 6.4-6.9.
#[test]
fn predictions_stand_beside_the_identified_derivatives() {
    let (Some(listing), Some(reference)) = (listing(), reference("derivatives.toml")) else { return };
    let names = ["CX_alpha", "CZ_alpha", "CZ_q", "Cm_alpha", "Cm_q", "CY_beta", "Cl_beta", "Cn_beta"];
    let identified: Vec<(&str, f64)> =
        names.into_iter().map(|name| (name, number(&reference["final"][&name[..2]][name]["mean"]))).collect();
    let predicted = listing.derivatives(0.1, &PredictionOptions::default()).unwrap();
    let rows = beside(&predicted, &identified);
    assert_eq!(rows.len(), names.len());
    // With Cl_beta and Cn_beta in their places every sign agrees.
    assert!(rows.iter().all(|row| row.same_sign()), "{rows:#?}");
    let ratio = |name: &str| rows.iter().find(|row| row.name == name).unwrap().ratio();
    for name in ["CZ_alpha", "Cm_alpha", "CY_beta"] {
        assert!((0.5..2.0).contains(&ratio(name)), "{name} {}", ratio(name));
    }
}

#[test]
fn damaged_listings_are_refused_in_one_line() {
    let Some(text) = text() else { return };
    let refuse = |text: &str| DatcomListing::parse(text).unwrap_err().to_string();
    assert_eq!(refuse(""), "no flight conditions in the listing: is it the output of Digital DATCOM?");
    let cut: String = text.lines().take(100).map(|line| format!("{line}\n")).collect();
    assert_eq!(refuse(&cut), "line 100 is the last and no END OF JOB came: the listing is cut off");
    let replaced = |from: &str, to: &str| refuse(&text.replacen(from, to, 1));
    assert_eq!(replaced("0.197 ", "0.1x7 "), "line 14: static characteristics: '0.1x7' is not a number");
    assert_eq!(replaced(" 0.197 ", "       "), "line 14: static characteristics: column 3 is blank");
    assert_eq!(replaced("   8.8469E+04", "   *********"), "line 10: flight conditions: '*********' is not a number");
    assert_eq!(
        replaced("-2.28E-06", "         "),
        "line 78: induced drag of the control: 9 values, but the heading states 10"
    );
    assert_eq!(
        replaced("              M        M/SEC", "              CM       CM/SEC"),
        "line 9: lengths are in 'CM', only M and FT are read: run the deck with DIM M"
    );
    assert_eq!(
        DatcomListing::parse(&text.replacen("(PER RADIAN)", "", 1)),
        Err(ListingError::AngleUnit { line: 12, table: "static characteristics" })
    );
    let hostile = replaced("-2.0    0.022", &format!("-2.0    {}", "\u{7}9".repeat(5000)));
    assert!(hostile.len() < 120 && !hostile.chars().any(char::is_control), "{hostile}");
}

#[test]
fn derivatives_per_degree_come_out_per_radian() {
    let Some(text) = text() else { return };
    let per_degree = DatcomListing::parse(&text.replace("(PER RADIAN)", "(PER DEGREE)")).unwrap();
    let factor = 180.0 / std::f64::consts::PI;
    assert!((per_degree.statics.cl_alpha[8] - 6.224 * factor).abs() < 1e-9);
    assert!((per_degree.dynamic.unwrap().cm_q[0] + 7.229 * factor).abs() < 1e-9);
}

proptest! {
    /// Any damage: a listing, or one line that says what is wrong.
    #[test]
    fn any_damage_ends_in_one_line(cuts in prop::collection::vec((0.0..1.0_f64, ".{0,12}"), 1..6), end in 0.0..1.0_f64) {
        let Some(mut text) = text() else { return Ok(()) };
        for (at, insert) in cuts {
            let mut index = (at * text.len() as f64) as usize;
            while !text.is_char_boundary(index) {
                index -= 1;
            }
            let to = (index + insert.len()).min(text.len());
            if text.is_char_boundary(to) {
                text.replace_range(index..to, &insert);
            }
        }
        let mut index = text.len() - (end * end * end * text.len() as f64) as usize;
        while !text.is_char_boundary(index) {
            index -= 1;
        }
        match DatcomListing::parse(&text[..index]) {
            Ok(listing) => { let _ = listing.derivatives(0.1, &PredictionOptions::default()); }
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
        }
    }
}

/// The shipped C337F.
fn aircraft_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/aircraft/c337f.toml")
}

/// The deck of the published run: the aircraft file, at the published weight and centre of gravity.
fn deck() -> DatcomDeck {
    let aircraft = aircraft::read(&aircraft_file()).unwrap();
    let properties = aircraft.standard_loading.mass_properties(&aircraft);
    let reference = DeckReference {
        cg_from_datum_m: [3.53, 0.0, 1.68],
        weight_n: 20_012.0,
        ..DeckReference::from_aircraft(&aircraft, &properties)
    };
    DatcomDeck {
        reference,
        condition: DeckCondition { mach: 0.137, altitude_m: 1130.0, alpha_deg: (-2..=13).map(f64::from).collect() },
        section: DatcomSection::read(&aircraft_file()).unwrap().unwrap(),
    }
}

#[test]
fn deck_takes_weight_and_centre_of_gravity_from_the_loading() {
    let aircraft = aircraft::read(&aircraft_file()).unwrap();
    let properties = aircraft.standard_loading.mass_properties(&aircraft);
    let reference = DeckReference::from_aircraft(&aircraft, &properties);
    assert_eq!((reference.area_m2, reference.chord_m, reference.span_m), (18.7, 1.68, 11.68));
    assert_eq!(reference.cg_from_datum_m, properties.cg_from_datum_m);
    assert_eq!(reference.weight_n, properties.mass_kg * 9.806_65);
}

/// One card: its namelist or text, variable and numbers; continuation cards joined.
fn cards(text: &str) -> Vec<(String, String, Vec<f64>)> {
    let mut cards: Vec<(String, String, Vec<f64>)> = Vec::new();
    let mut namelist = String::new();
    for line in text.lines() {
        let trimmed = line.trim();
        let values = |text: &str| -> Vec<f64> {
            text.trim_end_matches('$').split(',').filter(|v| !v.is_empty()).map(|v| v.trim().parse().unwrap()).collect()
        };
        if let Some(name) = trimmed.strip_prefix('$') {
            namelist = name.to_owned();
            cards.push((namelist.clone(), String::new(), Vec::new()));
        } else if let Some((name, text)) = trimmed.split_once('=') {
            cards.push((namelist.clone(), name.to_owned(), values(text)));
        } else if line.starts_with(' ') {
            cards.last_mut().unwrap().2.extend(values(trimmed));
        } else {
            cards.push((String::new(), trimmed.to_owned(), Vec::new()));
        }
    }
    cards
}

#[test]
fn written_deck_matches_the_deck_of_the_published_listing_card_by_card() {
    let text = deck().to_text().unwrap();
    assert!(text.lines().all(|line| line.len() <= 80), "{text}");
    let (Some(as_run), Some(printed)) =
        (shared("reference/datcom_input_as_run.txt"), shared("reference/datcom_input.txt"))
    else {
        return;
    };
    let expected = cards(&std::fs::read_to_string(as_run).unwrap());
    assert_eq!(cards(&text), expected);
    assert_eq!(text.lines().count(), 96);
    // The printed deck has 2 deg of incidence, which does not give the printed listing.
    let mut other = deck();
    other.section.wing.incidence_deg = 2.0;
    assert_eq!(cards(&other.to_text().unwrap()), cards(&std::fs::read_to_string(printed).unwrap()));
}

#[test]
fn deck_refuses_what_the_program_would_not_read() {
    let refuse = |change: fn(&mut DatcomDeck)| {
        let mut deck = deck();
        change(&mut deck);
        deck.to_text().unwrap_err().to_string()
    };
    assert_eq!(
        refuse(|d| d.section.body.area_m2.truncate(3)),
        "datcom.body.area_m2 has 3 values where its stations have 13"
    );
    assert_eq!(
        refuse(|d| d.condition.alpha_deg.clear()),
        "datcom.condition.alpha_deg has 0 values, allowed are 1 to 20"
    );
    assert_eq!(refuse(|d| d.condition.mach = f64::NAN), "datcom: MACH(1) is NaN, allowed is a finite number");
    assert!(refuse(|d| d.section.title = "a $ sign".to_owned()).contains("does not fit on a card"));
}

#[test]
fn long_lists_continue_on_the_next_card() {
    let mut deck = deck();
    deck.condition.alpha_deg = (0..20).map(|k| -1.0 + f64::from(k) / 3.0).collect();
    let text = deck.to_text().unwrap();
    assert!(text.lines().all(|line| line.len() <= 80));
    let written = cards(&text).into_iter().find(|card| card.1 == "ALSCHD").unwrap().2;
    assert_eq!(written, deck.condition.alpha_deg);
}
