//! `match` and `export` as a user runs them.

use crate::common::at_root::{doublet, text};

#[test]
fn match_prints_a_verdict_per_test_and_fails_with_a_failed_one() {
    let folder = tempfile::tempdir().unwrap();
    let tolerances = folder.path().join("tolerances.toml");
    // The elevator's band is as wide as that of the rule, the aileron's a thousandth of it.
    let file = "name = \"one wide, one narrow\"\n\
                [[test]]\nid = \"wide\"\nname = \"pitch rate\"\nsurface = \"elevator\"\n\
                require = [{ any = [{ signal = \"q\", absolute = 2.0, unit = \"deg/s\" }] }]\n\
                [[test]]\nid = \"narrow\"\nname = \"roll rate\"\nsurface = \"aileron\"\n\
                require = [{ any = [{ signal = \"p\", absolute = 0.002, unit = \"deg/s\" }] }]\n";
    std::fs::write(&tolerances, file).unwrap();
    let run = doublet(&["match", "sessions/demo.toml", "--tolerances", tolerances.to_str().unwrap()]);
    let (out, error) = (text(&run.stdout), text(&run.stderr));
    assert!(!run.status.success() && error.contains("error: 2 of 4 tests fail"), "{error}");
    let verdicts = |test: &str| -> Vec<&str> {
        let rows = out.lines().filter(|line| line.contains(test));
        rows.filter_map(|line| line.split_whitespace().find(|word| matches!(*word, "pass" | "fail"))).collect()
    };
    assert_eq!((verdicts("pitch rate"), verdicts("roll rate")), (vec!["pass"; 2], vec!["fail"; 2]), "{out}");
    assert!(out.contains("one wide, one narrow") && out.contains("Theil"), "{out}");
}

#[test]
fn export_names_its_formats_before_it_computes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("model");
    let run = doublet(&["export", "sessions/demo.toml", "--format", "jsbsim,simulink", "--out", out.to_str().unwrap()]);
    let error = text(&run.stderr);
    assert!(!run.status.success() && error.contains("'simulink'") && error.contains("jsbsim, daveml"), "{error}");
    assert!(!out.exists());
}
