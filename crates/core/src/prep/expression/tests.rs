use proptest::prelude::*;

use super::*;

/// The value of `text` where every role and channel it names is the next of `values`.
fn value(text: &str, values: &[f64]) -> f64 {
    let expression = Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    expression.value(|index| values[index], &mut Vec::new())
}

fn line(text: &str) -> String {
    Expression::parse(text).unwrap_err().to_string()
}

#[test]
fn numbers_match_the_same_formulas_written_out() {
    let (a, b): (f64, f64) = (0.3, -1.7);
    let cases: [(&str, f64); 20] = [
        ("sqrt(v_north^2 + v_east^2)", (a * a + b * b).sqrt()),
        ("alpha - beta - 1", a - b - 1.0),
        ("alpha / beta / 2", a / b / 2.0),
        ("alpha - beta * 2 + 1", a - b * 2.0 + 1.0),
        ("-alpha^2 + 0*beta", -(a * a)),
        ("(-alpha)^2 + 0*beta", a * a),
        ("2^-alpha * beta", 2.0_f64.powf(-a) * b),
        ("2^3^alpha + beta", 2.0_f64.powf(3.0_f64.powf(a)) + b),
        ("alpha*-beta", a * -b),
        ("- -alpha + +beta", a + b),
        ("sin(alpha) + cos(beta)", a.sin() + b.cos()),
        ("tan(alpha) * exp(beta)", a.tan() * b.exp()),
        ("asin(alpha) - acos(alpha) + 0*beta", a.asin() - a.acos()),
        ("atan(alpha) + ln(abs(beta))", a.atan() + 1.7_f64.ln()),
        ("atan2(alpha, beta)", a.atan2(b)),
        ("min(alpha, beta) / max(alpha, beta)", b / a),
        ("{ bus/a.1 } * 180 / pi + \"b\"*0", a * 180.0 / PI),
        ("alpha * g0 + beta", a * 9.806_65 + b),
        ("1.5e-2 * alpha + .5 * beta + 2E+1", 0.015 * a + 0.5 * b + 20.0),
        ("(((alpha)))+beta", a + b),
    ];
    for (text, expected) in cases {
        let found = value(text, &[a, b]);
        assert!((found - expected).abs() <= 1e-14 * expected.abs(), "{text}: {found} for {expected}");
    }
    let named = Expression::parse("q + {log/q} + q + \"log/q\"").unwrap();
    let operands = [(Operand::Role(Role::PitchRate), 1), (Operand::Channel("log/q".to_owned()), 5)];
    assert_eq!(named.operands(), operands, "each is named once, where it first stands");
}

#[test]
fn what_is_no_number_stays_none() {
    for text in ["min(p, q)", "max(p, q)", "min(q, p)", "max(q, p)", "p + q", "sqrt(-abs(p)) + q", "ln(-q) + p"] {
        assert!(value(text, &[f64::NAN, 1.0]).is_nan(), "{text}");
    }
}

#[test]
fn errors_say_where_and_what_in_one_line() {
    let cases = [
        ("sqrt(v_n^2)", "at character 6: no role is called 'v_n': did you mean v_north"),
        ("alpa + 1", "at character 1: no role is called 'alpa': did you mean alpha"),
        ("1 + sqr(q)", "at character 5: no function is called 'sqr': did you mean sqrt"),
        ("system(q)", "at character 1: no function is called 'system': "),
        ("atan2(q)", "at character 1: atan2 takes 2, not 1"),
        ("sin(q, p)", "at character 1: sin takes 1, not 2"),
        ("q +", "at character 4: the end where a number, a role"),
        ("q q", "at character 3: 'q' where an operator or the end should be"),
        ("(q", "at character 3: the end where an operator or ')' should be"),
        ("q = 1", "at character 3: '=' where an operator or the end should be"),
        ("q; p", "at character 2: ';' where"),
        ("1.2.3 * q", "at character 1: '1.2.3' where a number should be"),
        ("1e999 * q", "at character 1: '1e999' where a number should be"),
        ("\"log/q", "at character 7: the end where a channel and '\"' should be"),
        ("{} + q", "at character 2: '}' where a channel and '}' should be"),
        ("\"a\nb\"", "at character 3: '\\n' where"),
        ("2 * pi", "it names no channel"),
        ("", "at character 1: the end where"),
    ];
    for (text, expected) in cases {
        let found = line(text);
        assert!(found.starts_with(expected) && !found.contains('\n'), "{text}: {found}");
    }
}

#[test]
fn hostile_expressions_are_refused_at_once() {
    assert_eq!(Expression::parse(&"q+".repeat(500_000)).unwrap_err(), ExpressionError::TooLong { bytes: 1_000_000 });
    for piece in ["(", "-", "sin(", "q^", "2^-("] {
        let text = piece.repeat(LONGEST / piece.len());
        assert!(matches!(Expression::parse(&text), Err(ExpressionError::TooDeep { .. })), "{piece}");
    }
    // As wide as it is long: no deeper for it.
    let sum = format!("q{}", "+q".repeat(499));
    assert_eq!(value(&sum, &[1.0]), 500.0);
    let longest = format!("q+{}", "1".repeat(LONGEST - 2));
    assert!(line(&longest).ends_with("where a number should be"), "it is infinite");
}

#[test]
fn between_samples_are_straight_lines_and_nothing_in_gaps() {
    let series = |time: &[f64], values: &[f64]| Series { time_s: time.into(), values: values.into() };
    // Samples every 0.1 s, none from 0.3 to 2.0 s, one that is no number at 2.2 s.
    let time = [0.0, 0.1, 0.2, 0.3, 2.0, 2.1, 2.2, 2.3];
    let signal = series(&time, &[0.0, 1.0, 2.0, 3.0, 20.0, 21.0, f64::NAN, 23.0]);
    let at = [-0.01, 0.0, 0.05, 0.25, 0.3, 0.31, 1.0, 1.99, 2.0, 2.05, 2.2, 2.3, 2.31];
    let nan = f64::NAN;
    let expected = [nan, 0.0, 0.5, 2.5, 3.0, nan, nan, nan, 20.0, 20.5, 22.0, 23.0, nan];
    let found = between_samples(&signal, &at, None, false);
    for ((found, expected), t) in found.iter().zip(expected).zip(at) {
        let same = if expected.is_nan() { found.is_nan() } else { (found - expected).abs() < 1e-12 };
        assert!(same, "{found} for {expected} at {t}");
    }
    // A stated gap decides: 0.15 s does not reach over the sample that is none, 2 s reaches over the pause.
    assert!(between_samples(&signal, &[2.2], Some(0.15), false)[0].is_nan());
    let bridged = between_samples(&signal, &[1.15], Some(2.0), false)[0];
    assert!((bridged - 11.5).abs() < 1e-12, "{bridged}");
    assert!(between_samples(&series(&[], &[]), &[1.0], None, false)[0].is_nan());
    // A heading through north goes the short way.
    let heading = series(&[0.0, 0.1], &[TAU - 0.1, 0.3]);
    let found = between_samples(&heading, &[0.02, 0.05], None, true);
    assert!((found[0] - (TAU - 0.02)).abs() < 1e-12 && (found[1] - 0.1).abs() < 1e-12, "{found:?}");
}

#[test]
fn nearest_names_are_near() {
    let known = ["v_north", "v_east", "airspeed", "alpha", "delta_a"];
    assert_eq!(nearest_names("airsped", known.into_iter()), ["airspeed"]);
    assert_eq!(nearest_names("V_North", known.into_iter())[0], "v_north");
    assert!(nearest_names("zzzzzzzzzz", known.into_iter()).is_empty());
}

proptest! {
    #[test]
    fn parsing_never_panics(text in "\\PC{0,60}") {
        let _ = Expression::parse(&text);
    }

    #[test]
    fn parsing_what_looks_like_an_expression_never_panics_and_its_value_is_found(
        pieces in prop::collection::vec(
            prop::sample::select(vec![
                "(", ")", "+", "-", "*", "/", "^", ",", "q", "alpha", "1.5", "2e", "e3", ".", "sin(", "max(", "\"", "{", "}",
                "{log/q}", "pi", " ", "é", "\n",
            ]),
            0..60,
        )
    ) {
        match Expression::parse(&pieces.concat()) {
            Ok(expression) => {
                let _ = expression.value(|index| index as f64, &mut Vec::new());
            }
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}

#[test]
fn names_take_the_place_of_roles() {
    let names = ["Cm_alpha", "CZ_alpha", "CZ_V-1"];
    let parse = |text: &str| Expression::parse_names(text, "derivative", &names);
    let ratio = parse("-Cm_alpha/CZ_alpha + 0*\"CZ_V-1\"").unwrap();
    let value = ratio.value(|index| [-0.7, -4.9, 1.0][index], &mut Vec::new());
    assert!((value + 0.7 / 4.9).abs() < 1e-15);
    let message = |text: &str| parse(text).unwrap_err().to_string();
    assert_eq!(
        message("2*Cm_alfa"),
        "at character 3: no derivative is called 'Cm_alfa': did you mean Cm_alpha, CZ_alpha?"
    );
    assert!(message("{Cm_q}*2").starts_with("at character 1: no derivative is called 'Cm_q'"));
    // A role is no derivative.
    assert!(message("alpha").starts_with("at character 1: no derivative is called 'alpha'"));
}
