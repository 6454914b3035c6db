//! Every command with its arguments as data, for programs that call them.

use clap::{Arg, ArgAction, Command};
use serde_json::{Value, json};

/// Arguments that every command has, and that are not for a program.
const WITHOUT: [&str; 3] = ["help", "version", "json"];

/// A row for each command: `name[]` (the command and the one below it), `about`, `has_json` and `arguments[]`. An argument has `name`,
/// `long` (none where it has a place), `help`, `takes_value`, `repeats`, `required`, `value`, `choices[]` and `default`. What `--json` excludes
/// is left out.
pub fn command_table() -> Value {
    let mut all = crate::command_line();
    all.build();
    let mut rows = Vec::new();
    all.get_subcommands().for_each(|command| add(command, &[], &mut rows));
    Value::Array(rows)
}

fn add(command: &Command, above: &[&str], rows: &mut Vec<Value>) {
    let name: Vec<&str> = above.iter().copied().chain([command.get_name()]).collect();
    if command.has_subcommands() {
        command.get_subcommands().for_each(|below| add(below, &name, rows));
        return;
    }
    let json = command.get_arguments().find(|argument| argument.get_id() == "json");
    let excluded = |argument: &Arg| {
        let excludes = |one: &Arg, other: &Arg| command.get_arg_conflicts_with(one).contains(&other);
        json.is_some_and(|json| excludes(json, argument) || excludes(argument, json))
    };
    let arguments = command.get_arguments().filter(|one| !WITHOUT.contains(&one.get_id().as_str()) && !excluded(one));
    rows.push(json!({
        "name": name,
        "about": command.get_about().map(ToString::to_string),
        "has_json": json.is_some(),
        "arguments": arguments.map(describe).collect::<Vec<_>>(),
    }));
}

fn describe(argument: &Arg) -> Value {
    let takes_value = argument.get_action().takes_values();
    let choices = argument.get_possible_values();
    let several = argument.get_num_args().is_some_and(|count| count.max_values() > 1);
    let defaults: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    json!({
        "name": argument.get_id().as_str(),
        "long": argument.get_long(),
        "help": argument.get_help().map(ToString::to_string),
        "takes_value": takes_value,
        "repeats": several || matches!(argument.get_action(), ArgAction::Append),
        "required": argument.is_required_set(),
        "value": argument.get_value_names().unwrap_or_default().first().map(|name| name.as_str()),
        "choices": if takes_value { choices.iter().map(clap::builder::PossibleValue::get_name).collect() } else { Vec::new() },
        "default": (takes_value && !defaults.is_empty()).then(|| defaults.join(",")),
    })
}

#[cfg(test)]
mod tests {
    use super::command_table;

    #[test]
    fn every_command_is_a_row_with_its_arguments() {
        let table = command_table();
        let rows = table.as_array().unwrap();
        let names: Vec<String> = rows.iter().map(|row| row["name"].to_string()).collect();
        for name in [r#"["run"]"#, r#"["propose","noise"]"#, r#"["aircraft","list"]"#, r#"["equations"]"#] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
        let diff = rows.iter().find(|row| row["name"][0] == "diff").unwrap();
        let arguments: Vec<_> = diff["arguments"].as_array().unwrap().iter().map(|one| &one["name"]).collect();
        assert_eq!(arguments, ["first", "second", "settings"]);
        assert!(rows.iter().all(|row| row["about"].is_string()));
    }
}
