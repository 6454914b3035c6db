//! Names that a user gives in a file beside a recording.

use doublet_core::load::{By, LoadError, NAMES_FILE, UserNames, guess, guess_with, inspect};
use doublet_core::quantity::Role;

use super::written;

const HEAD: &str = "format = \"doublet names\"\nversion = 1\n";

fn names(text: &str) -> UserNames {
    UserNames::parse(&format!("{HEAD}{text}")).unwrap()
}

/// Role, channel, unit and sign of every row that is guessed of a table with this head.
fn rows(head: &str, names: &UserNames) -> Vec<(&'static str, String, String, bool)> {
    let columns = head.split(',').count();
    let row = |k: i32| (0..columns as i32).map(|c| format!(",{}", (k * (c + 3)) % 17)).collect::<String>();
    let rows: String = (0..60).map(|k| format!("{}{}\n", 0.02 * f64::from(k), row(k))).collect();
    let (_folder, path) = written("log.csv", format!("time,{head}\n{rows}"));
    let map = guess_with(&[inspect(&path).unwrap()], names);
    let row = |(role, row): &(Role, doublet_core::load::ManualChannel)| {
        let unit = row.unit.map_or("", |unit| unit.symbol).to_owned();
        (role.name(), row.from.channel.clone(), unit, row.turned)
    };
    map.rows.iter().map(row).collect()
}

#[test]
fn names_of_a_user_give_role_unit_and_sign_before_those_of_the_program() {
    let given = names(
        "[[names]]\nrole = \"delta_a\"\nwords = [\"Knüppel quer\"]\nunit = \"deg\"\nsign = -1\n\
         [[names]]\nrole = \"theta\"\nwords = [\"gamma\"]\nunit = \"rad\"\n",
    );
    let found = rows("knueppel_quer,Knüppel_quer,pitch,gamma", &given);
    let own = |role, channel: &str, unit: &str, turned| (role, channel.to_owned(), unit.to_owned(), turned);
    assert_eq!(found, [own("theta", "gamma", "rad", false), own("delta_a", "Knüppel_quer", "deg", true)]);
    let without = rows("knueppel_quer,Knüppel_quer,pitch,gamma", &UserNames::default());
    assert_eq!(without.iter().map(|row| row.1.as_str()).collect::<Vec<_>>(), ["pitch"]);
}

#[test]
fn weight_below_that_of_the_program_gives_only_roles_that_are_left_open() {
    let text = |weight: f64| format!("[[names]]\nrole = \"theta\"\nwords = [\"gamma\"]\nweight = {weight}\n");
    for (weight, head, channel) in [
        (0.5, "pitch,gamma", "pitch"),
        (2.0, "pitch,gamma", "gamma"),
        (0.5, "foo,gamma", "gamma"),
        // A part of a name weighs less than the whole.
        (1.5, "pitch,main_gamma", "pitch"),
    ] {
        let found = rows(head, &names(&text(weight)));
        assert_eq!(found.iter().find(|row| row.0 == "theta").unwrap().1, channel, "{weight} {head}");
    }
}

#[test]
fn tokens_of_a_user_forbid_and_allow() {
    let heads = |given: &UserNames| {
        let found = rows("cmd_roll,q_dps", given);
        found.into_iter().map(|row| row.1).collect::<Vec<_>>()
    };
    assert_eq!(heads(&UserNames::default()), ["q_dps"]);
    assert_eq!(heads(&names("allowed = [\"cmd\"]\n")), ["q_dps", "cmd_roll"]);
    assert_eq!(heads(&names("forbidden = [\"q\"]\n")), Vec::<String>::new());
}

#[test]
fn row_by_the_names_file_says_so_and_keeps_its_sign() {
    let given = names("[[names]]\nrole = \"az\"\nwords = [\"hoch\"]\nunit = \"g\"\nsign = 1\n");
    let rows: String =
        (0..60).map(|k| format!("{},{}\n", 0.02 * f64::from(k), 1.0 + 0.001 * f64::from(k % 7))).collect();
    let (_folder, path) = written("log.csv", format!("time,hoch\n{rows}"));
    let probe = inspect(&path).unwrap();
    let map = guess_with(std::slice::from_ref(&probe), &given);
    let row = map.row(Role::SpecificForceZ).unwrap();
    assert_eq!((row.by, row.turned, row.is_unit_open(std::slice::from_ref(&probe))), (By::File, false, false));
    assert!(guess(&[probe]).rows.is_empty());
}

#[test]
fn faults_of_a_names_file_are_refused_with_their_line() {
    for (text, line, what) in [
        ("[[names]]\nrole = \"thet\"\nwords = [\"a\"]\n", 4, "role 'thet' not found"),
        ("[[names]]\nrole = \"theta\"\nwords = [\"a\"]\nunit = \"kg\"\n", 6, "theta is in rad, not in kg"),
        ("[[names]]\nrole = \"theta\"\nwords = [\"a\"]\nsign = 2\n", 6, "sign 2 must be 1 or -1"),
        ("[[names]]\nrole = \"theta\"\nwords = [\"a\"]\nweight = 0\n", 6, "weight 0 must be above zero"),
        ("[[names]]\nrole = \"theta\"\nwords = [\"--\"]\n", 5, "'--' has neither letters nor digits"),
        ("forbidden = [\"two words\"]\n", 3, "'two words' must be one word"),
        ("colour = \"red\"\n", 3, "unknown field `colour`"),
    ] {
        match UserNames::parse(&format!("{HEAD}{text}")) {
            Err(LoadError::Names { line: found, what: message, .. }) => {
                assert_eq!(found, line, "{text}");
                assert!(message.contains(what), "{message}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    assert!(UserNames::parse("format = \"doublet map\"\nversion = 1\n").is_err());
}

#[test]
fn names_are_read_from_the_folder_of_the_recording() {
    let (folder, path) = written(NAMES_FILE, format!("{HEAD}forbidden = [\"raw\"]\n"));
    let folders = UserNames::folders(&[folder.path().join("log.csv")]);
    let found = UserNames::read(&folders).unwrap();
    assert_eq!(found.files, [path]);
    let none = tempfile::tempdir().unwrap();
    assert_eq!(UserNames::read(&[none.path().to_owned()]).unwrap(), UserNames::default());
}
