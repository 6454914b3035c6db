//! Tests of tolerance files.

use doublet_core::validate::{Histories, judge};

use super::*;

fn builtin() -> Tolerances {
    Tolerances::builtin().unwrap()
}

#[test]
fn shipped_tolerances_are_those_of_the_rule() {
    let tolerances = builtin();
    assert_eq!(tolerances.edition, "2014-01-01");
    let short_period = tolerances.test("2.c.10").unwrap();
    assert_eq!(short_period.surface, Some(Surface::Elevator));
    let [pitch, acceleration] = short_period.bands().unwrap().requirements.as_slice() else { panic!("two") };
    assert!((pitch[0].absolute - 1.5_f64.to_radians()).abs() < 1e-12);
    assert!((pitch[1].absolute - 2.0_f64.to_radians()).abs() < 1e-12);
    assert!((acceleration[0].absolute - 0.980_665).abs() < 1e-12);
    let roll = &tolerances.test("2.d.2").unwrap().bands().unwrap().requirements[0][0];
    assert!((roll.of_peak - 0.1).abs() < 1e-12 && roll.of_value == 0.0);
    // Small inputs in pitch, roll and yaw: 0.15 deg/s or 20 % of the peak, with 5 s on either side.
    for (id, signal) in [("2.b.4", Signal::PitchRate), ("2.b.5", Signal::RollRate), ("2.b.6", Signal::YawRate)] {
        let test = tolerances.test(id).unwrap();
        let band = test.bands().unwrap().requirements[0][0];
        assert_eq!((band.signal, test.record.before_s, test.record.after_s), (signal, 5.0, 5.0));
        assert!((band.absolute - 0.15_f64.to_radians()).abs() < 1e-12 && (band.of_peak - 0.2).abs() < 1e-12);
    }
    let Judgement::FreeResponse { lag, requirements } = &tolerances.test("2.d.7").unwrap().judgement else {
        panic!("the Dutch roll is judged by period and damping")
    };
    assert_eq!(*lag, Some([Signal::BankAngle, Signal::Sideslip]));
    assert_eq!(requirements[0][0], ValueTolerance { quantity: Quantity::Period, absolute: 0.5, of_value: 0.1 });
    assert_eq!(requirements[1][1].absolute, 0.02);
    // What was read in part says so, and what was read elsewhere.
    let in_part: Vec<_> = tolerances.tests.iter().filter(|test| !test.missing.is_empty()).map(|t| &*t.id).collect();
    assert_eq!(in_part, ["1.b.8", "1.c.1", "2.c.5", "2.c.6", "2.c.7", "2.d.3"]);
    let elsewhere = tolerances.tests.iter().filter(|test| test.certainty != Certainty::Read).map(|test| &*test.id);
    assert_eq!(elsewhere.collect::<Vec<_>>(), ["1.c.1", "2.c.6", "2.c.7", "2.d.3"]);
    // Thrust and rate of climb: 5 %, and 100 ft/min.
    let Judgement::Snapshot(trim) = &tolerances.test("2.c.5").unwrap().judgement else { panic!("a snapshot") };
    let thrust = ValueTolerance { quantity: Quantity::NetThrust, absolute: 0.0, of_value: 0.05 };
    assert_eq!(trim.last().unwrap(), &[thrust]);
    let Judgement::Snapshot(climb) = &tolerances.test("1.c.2").unwrap().judgement else { panic!("a snapshot") };
    assert!((climb[1][0].absolute - 100.0 * 0.3048 / 60.0).abs() < 1e-12 && climb[1][0].of_value == 0.05);
    // Airspeed of climbs and descents: 3 kt, of the emergency descent 5 kt.
    for (id, knots) in [("1.c.1", 3.0), ("1.c.2", 3.0), ("1.d.4", 3.0), ("1.d.5", 5.0)] {
        let Judgement::Snapshot(found) = &tolerances.test(id).unwrap().judgement else { panic!("a snapshot") };
        assert_eq!(found[0][0].quantity, Quantity::Signal(Signal::Airspeed), "{id}");
        assert!((found[0][0].absolute - knots * 1852.0 / 3600.0).abs() < 1e-12, "{id}");
    }
    assert!(tolerances.outside.iter().any(|test| test.id == "2.c.8"));
}

#[test]
fn other_rules_have_the_tests_of_the_one_they_are_based_on_and_say_that_they_were_not_read() {
    let base = builtin();
    for name in ["part60_2016", "cs_fstd_a", "icao_9625"] {
        let rule = Tolerances::parse(builtin::text("tolerances", name).unwrap()).unwrap();
        assert_eq!(rule.tests.len(), base.tests.len(), "{name}");
        assert_eq!(rule.outside, base.outside);
        assert!(
            rule.tests.iter().all(|test| test.certainty == Certainty::Unverified && test.page.is_empty()),
            "{name}"
        );
        assert!(rule.certainty_note.contains("not read") && rule.name != base.name && !rule.edition.is_empty());
        let of = |rules: &Tolerances| rules.test("2.c.10").unwrap().judgement.clone();
        assert_eq!(of(&rule), of(&base));
    }
    let easa = Tolerances::parse(builtin::text("tolerances", "cs_fstd_a").unwrap()).unwrap();
    assert_eq!(easa.test("2.c.10").unwrap().paragraph, "2.c.(10)");
    // A user's file states only what differs.
    let own = "name = \"x\"\nbased_on = \"part60_2014\"\n[[test]]\nid = \"2.d.6\"\nname = \"rudder\"\nsurface = \"rudder\"\n\
               require = [{ any = [{ signal = \"r\", percent = 5.0 }] }]\n";
    let own = Tolerances::parse(own).unwrap();
    assert_eq!(own.tests.len(), base.tests.len());
    assert!(own.test("2.d.6").unwrap().bands().unwrap().requirements[0][0].of_peak == 0.05);
    for (text, part) in [
        ("name = \"x\"\nbased_on = \"none\"\n", "shipped tolerances 'none' not found"),
        ("name = \"x\"\nbased_on = \"cs_fstd_a\"\n", "itself based on"),
        ("name = \"x\"\nbased_on = \"part60_2014\"\ncertainty = \"sure\"\n", "certainty 'sure' must be read"),
        ("name = \"x\"\nbased_on = \"part60_2014\"\n[paragraphs]\n\"9\" = \"9\"\n", "'9' is not a test of the file"),
        ("name = \"x\"\n", "no test: add one"),
    ] {
        let message = Tolerances::parse(text).unwrap_err().to_string();
        assert!(message.contains(part) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn percent_is_of_the_range_of_the_record_or_of_the_sample_as_asked() {
    let text = "name = \"x\"\n[[test]]\nid = \"1\"\nname = \"one\"\nsurface = \"aileron\"\n\
                require = [{ any = [{ signal = \"p\", percent = 10.0 }] }]\n";
    // A rate of 1 rad/s that stops at 0.2 rad/s, simulated 0.05 rad/s too large throughout.
    let time_s: Vec<f64> = (0..10).map(f64::from).collect();
    let mut measured = Histories { time_s, columns: std::array::from_fn(|_| vec![0.0; 10]) };
    measured.columns[Signal::RollRate as usize] = (0..10).map(|k| if k < 5 { 1.0 } else { 0.25 }).collect();
    let mut simulated = measured.clone();
    simulated.columns[Signal::RollRate as usize].iter_mut().for_each(|rate| *rate += 0.0625);
    let passes = |reading: &Reading| {
        let tolerances = Tolerances::parse_by(text, reading).unwrap();
        let result = judge(tolerances.tests[0].bands().unwrap(), &measured, &simulated);
        (result.passed(), result.requirements[0][0].half_width[9])
    };
    assert_eq!(passes(&Reading::default()), (true, 0.1));
    let sample = Reading { percent: PercentRule::Sample, ..Reading::default() };
    assert_eq!(passes(&sample), (false, 0.025));
    let range = |largest| Reading { normal_range: [(Signal::RollRate, largest)].into(), ..Reading::default() };
    assert_eq!(passes(&range(2.0)), (true, 0.2));
    // A difference of exactly the tolerance passes, the next larger number does not.
    assert_eq!(passes(&range(0.625)), (true, 0.0625));
    assert!(!passes(&range(0.625 * (1.0 - f64::EPSILON))).0);
    // 40 per cent of the tolerance for engineering data.
    let tolerances = Tolerances::parse(text).unwrap().scaled(0.4);
    assert!(!judge(tolerances.tests[0].bands().unwrap(), &measured, &simulated).passed());
}

#[test]
fn one_number_passes_up_to_its_tolerance() {
    let tolerance = ValueTolerance { quantity: Quantity::Period, absolute: 0.5, of_value: 0.125 };
    assert!(tolerance.holds(8.0, 9.0) && tolerance.holds(8.0, 7.0) && !tolerance.holds(8.0, 9.000_000_000_000_002));
    assert!(tolerance.holds(2.0, 2.5) && !tolerance.holds(2.0, 2.51) && !tolerance.holds(2.0, f64::NAN));
}

#[test]
fn file_rejects_what_no_test_can_use() {
    let file = |inside: &str| format!("name = \"x\"\n[[test]]\nid = \"1\"\nname = \"one\"\n{inside}\n");
    let rudder = |rest: &str| format!("surface = \"rudder\"\n{rest}");
    let one = "require = [{ any = [{ signal = \"p\", percent = 1.0 }] }]";
    for (inside, part) in [
        (format!("surface = \"flap\"\n{one}"), "'flap'"),
        (one.to_owned(), "surface and kinds are missing"),
        (rudder("require = []"), "no tolerance"),
        (rudder("require = [{ any = [{ signal = \"n\", percent = 1.0 }] }]"), "'n'"),
        (rudder("require = [{ any = [{ signal = \"period\", percent = 1.0 }] }]"), "'period' is not a signal"),
        (rudder("require = [{ any = [{ signal = \"p\", absolute = 1.0 }] }]"), "no unit"),
        (rudder("require = [{ any = [{ signal = \"p\", absolute = 1.0, unit = \"kt\" }] }]"), "kt"),
        (rudder("require = [{ any = [{ signal = \"p\", percent = -1.0 }] }]"), "positive"),
        (rudder(&format!("kind = \"film\"\n{one}")), "'film' is not a kind"),
        (rudder(&format!("kind = \"value\"\n{one}")), "at_s"),
        (rudder(&format!("trend = true\n{one}")), "belong to kind"),
        (rudder(&format!("kind = \"period and damping\"\n{one}")), "needs read"),
        (rudder(&format!("before_s = -1.0\n{one}")), "negative"),
    ] {
        let message = Tolerances::parse(&file(&inside)).unwrap_err().to_string();
        assert!(message.contains("'1'") && message.contains(part) && !message.contains('\n'), "{message}");
    }
}
