//! Messages as JSON.

use serde_json::Value;

use super::{LONGEST_ARRAY, MAX_DEPTH, Number};

/// The numbers of a message that is an object.
pub fn decode(data: &[u8]) -> Option<Vec<Number>> {
    let Ok(Value::Object(fields)) = serde_json::from_slice(data) else { return None };
    let mut numbers = Vec::new();
    for (name, value) in &fields {
        flatten(name, value, MAX_DEPTH, &mut numbers);
    }
    Some(numbers)
}

fn flatten(name: &str, value: &Value, depth: usize, numbers: &mut Vec<Number>) {
    match value {
        Value::Number(number) => numbers.extend(number.as_f64().map(|number| (name.into(), number))),
        Value::Bool(value) => numbers.push((name.into(), f64::from(u8::from(*value)))),
        Value::Null => numbers.push((name.into(), f64::NAN)),
        Value::Object(fields) if depth > 0 => {
            for (field, value) in fields {
                flatten(&format!("{name}.{field}"), value, depth - 1, numbers);
            }
        }
        Value::Array(elements) if depth > 0 && elements.len() <= LONGEST_ARRAY && !name.ends_with("covariance") => {
            for (index, value) in elements.iter().enumerate() {
                flatten(&format!("{name}[{index}]"), value, depth - 1, numbers);
            }
        }
        _ => {}
    }
}
