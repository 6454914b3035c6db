//! What the check of a session says of expressions.

use doublet_core::quantity::Role;
use doublet_engine::session::{self, ExpressionSetting};

use super::{example, expression};

#[test]
fn check_names_what_is_wrong_with_an_expression() {
    let problem = |made: ExpressionSetting| {
        let mut session = example();
        session.flights[0].expressions = vec![made];
        let found = session::check(&session);
        let found: Vec<String> =
            found.iter().map(ToString::to_string).filter(|line| line.starts_with("expression")).collect();
        let [line] = &found[..] else { panic!("{found:?}") };
        assert!(!line.contains('\n'), "{line}");
        line.strip_prefix("expression 'a' of flight 'one': ").unwrap_or(line).to_owned()
    };
    let role = |role| ExpressionSetting { role: Some(role), ..expression("a", "m", "q") };
    for (made, expected) in [
        (expression("a", "", "q"), "its unit is missing"),
        (expression("a", "furlong", "q"), "unknown unit 'furlong'"),
        (expression("a", "m", "qq"), "at character 1: no role is called 'qq': did you mean q"),
        (expression("a", "m", "q + \"expression/a\""), "at character 5: the expression refers to itself"),
        (expression("a", "m", "{expression/b}"), "at character 1: expression 'b' not found above it"),
        (role(Role::PitchRate), "q cannot be in m: give a unit like rad/s"),
        (expression("a/b", "m", "q"), "expression 'a/b' of flight 'one': the name is \"a/b\""),
        (expression("a", "m", &"(".repeat(1 << 20)), "the expression has 1048576 bytes"),
    ] {
        let found = problem(made);
        assert!(found.starts_with(expected), "{found}");
    }
    let mut many = example();
    many.flights[0].expressions = (0..101).map(|k| expression(&format!("n{k}"), "-", "q")).collect();
    assert!(session::check(&many).iter().any(|found| found.text.to_string().contains("101 expressions (limit 100)")));
}
