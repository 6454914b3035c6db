//! Messages in the Common Data Representation, laid out by the ROS 2 description of their type.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::{LONGEST_ARRAY, MAX_DEPTH, MOST_FIELDS, Number};
use crate::load::formats::stored_number::StoredNumber;

/// Bytes before the data that say how they are laid out.
const ENCAPSULATION: usize = 4;
/// What begins the description of a further type, after a line of `=`.
const FURTHER_TYPE: &str = "MSG:";

/// Units of fields by the type they stand in: REP 103 of ROS, SI with degrees for places on Earth and Celsius for temperatures.
const UNITS: &[(&str, &str, &str)] = &[
    ("Imu", "angular_velocity", "rad/s"),
    ("Imu", "linear_acceleration", "m/s^2"),
    ("Twist", "linear", "m/s"),
    ("Twist", "angular", "rad/s"),
    ("Accel", "linear", "m/s^2"),
    ("Accel", "angular", "rad/s^2"),
    ("Pose", "position", "m"),
    ("Transform", "translation", "m"),
    ("NavSatFix", "latitude", "deg"),
    ("NavSatFix", "longitude", "deg"),
    ("NavSatFix", "altitude", "m"),
    ("FluidPressure", "fluid_pressure", "Pa"),
    ("Temperature", "temperature", "degC"),
    ("Range", "range", "m"),
    ("Wrench", "force", "N"),
    ("Wrench", "torque", "N m"),
];

/// The type of number a description names.
fn stored_number(name: &str) -> Option<StoredNumber> {
    Some(match name {
        "bool" | "byte" | "char" | "uint8" => StoredNumber::U8,
        "int8" => StoredNumber::I8,
        "int16" => StoredNumber::I16,
        "uint16" => StoredNumber::U16,
        "int32" => StoredNumber::I32,
        "uint32" => StoredNumber::U32,
        "int64" => StoredNumber::I64,
        "uint64" => StoredNumber::U64,
        "float32" => StoredNumber::F32,
        "float64" => StoredNumber::F64,
        _ => return None,
    })
}

/// What comes next in a message.
enum Step {
    /// A number, a channel of the name given.
    Number(StoredNumber, Option<Rc<str>>),
    Text,
    /// A list whose length stands before it: none of it is a channel.
    Sequence(Vec<Step>),
}

/// How many elements a field has.
enum Count {
    One,
    Fixed(usize),
    Sequence,
}

struct Field<'a> {
    kind: &'a str,
    count: Count,
    name: &'a str,
}

/// How messages of a type lie in their bytes.
pub struct Layout {
    steps: Vec<Step>,
    units: BTreeMap<Rc<str>, &'static str>,
}

type Types<'a> = BTreeMap<&'a str, Vec<Field<'a>>>;

impl Layout {
    /// The layout of messages of type `name` (`package/msg/Name`) by their description, which appends the types it uses after lines of
    /// `=` and `MSG: package/Name`.
    pub fn new(name: &str, description: &str) -> Result<Self, String> {
        let mut types = Types::new();
        let (mut kind, mut fields) = (last_part(name), Vec::new());
        for line in description.lines().map(str::trim) {
            if let Some(further) = line.strip_prefix(FURTHER_TYPE) {
                types.insert(kind, std::mem::take(&mut fields));
                kind = last_part(further);
            } else {
                fields.extend(field(line)?);
            }
        }
        types.insert(kind, fields);
        let mut builder = Builder { types: &types, units: BTreeMap::new(), steps: 0 };
        let steps = builder.steps(last_part(name), Some(""), None, 0)?;
        Ok(Self { steps, units: builder.units })
    }

    /// Unit of a channel by the type it stands in.
    pub fn unit(&self, name: &str) -> Option<&'static str> {
        self.units.get(name).copied()
    }

    /// The numbers of a message; `None` where it is shorter than its description or encoded otherwise.
    pub fn decode(&self, message: &[u8]) -> Option<Vec<Number>> {
        let (head, data) = message.split_at_checked(ENCAPSULATION)?;
        let is_big = match head[1] {
            0 => true,
            1 => false,
            _ => return None,
        };
        let mut numbers = Vec::new();
        Reader { data, at: 0, is_big }.read(&self.steps, &mut numbers)?;
        Some(numbers)
    }
}

/// Puts the steps of a type together.
struct Builder<'a> {
    types: &'a Types<'a>,
    units: BTreeMap<Rc<str>, &'static str>,
    steps: usize,
}

impl Builder<'_> {
    /// Steps of type `kind`, whose fields have the names `prefix` + own; without one they are passed over. `unit` is that of the field
    /// it is the type of.
    fn steps(
        &mut self,
        kind: &str,
        prefix: Option<&str>,
        unit: Option<&'static str>,
        depth: usize,
    ) -> Result<Vec<Step>, String> {
        if depth > MAX_DEPTH {
            return Err(format!("type '{kind}' is nested more than {MAX_DEPTH} deep"));
        }
        let types = self.types;
        let fields = types.get(kind).ok_or_else(|| format!("type '{kind}' is not described"))?;
        let mut steps = Vec::new();
        for field in fields {
            let own = UNITS.iter().find(|(of, name, _)| *of == kind && *name == field.name).map(|(.., unit)| *unit);
            let unit = own.or(unit);
            let name = prefix.map(|prefix| format!("{prefix}{}", field.name));
            match field.count {
                Count::One => self.element(field.kind, name, unit, depth, &mut steps)?,
                Count::Fixed(count) => {
                    let name = name.filter(|_| count <= LONGEST_ARRAY && !field.name.ends_with("covariance"));
                    for index in 0..count {
                        let name = name.as_ref().map(|name| format!("{name}[{index}]"));
                        self.element(field.kind, name, unit, depth, &mut steps)?;
                    }
                }
                Count::Sequence => {
                    let mut elements = Vec::new();
                    self.element(field.kind, None, None, depth, &mut elements)?;
                    steps.push(Step::Sequence(elements));
                }
            }
        }
        Ok(steps)
    }

    /// Adds the steps of one element of a field.
    fn element(
        &mut self,
        kind: &str,
        name: Option<String>,
        unit: Option<&'static str>,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), String> {
        self.steps += 1;
        if self.steps > MOST_FIELDS {
            return Err(format!("more than {MOST_FIELDS} fields"));
        }
        if kind.split("<=").next() == Some("string") {
            steps.push(Step::Text);
        } else if let Some(number) = stored_number(kind) {
            let name = name.map(Rc::<str>::from);
            if let (Some(name), Some(unit)) = (&name, unit) {
                self.units.insert(Rc::clone(name), unit);
            }
            steps.push(Step::Number(number, name));
        } else {
            let prefix = name.map(|name| format!("{name}."));
            steps.extend(self.steps(last_part(kind), prefix.as_deref(), unit, depth + 1)?);
        }
        Ok(())
    }
}

/// Name of a type without its package.
fn last_part(kind: &str) -> &str {
    kind.trim().rsplit('/').next().unwrap_or_default()
}

/// The field that a line describes: `float64[9] name`; none for a constant, a comment and a blank line.
fn field(line: &str) -> Result<Option<Field<'_>>, String> {
    let line = line.split('#').next().unwrap_or_default();
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else { return Ok(None) };
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return Ok(None);
    }
    let (kind, count) = match kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) {
        None => (kind, Count::One),
        Some((kind, count)) if count.is_empty() || count.starts_with("<=") => (kind, Count::Sequence),
        Some((kind, count)) => {
            (kind, Count::Fixed(count.parse().map_err(|_| format!("the length in '{line}' is not a number"))?))
        }
    };
    Ok(Some(Field { kind, count, name }))
}

/// Reads from data whose numbers are aligned to their size.
struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    is_big: bool,
}

impl Reader<'_> {
    fn number(&mut self, kind: StoredNumber) -> Option<f64> {
        let size = kind.size();
        let start = self.at.next_multiple_of(size);
        let mut bytes = [0; 8];
        let stored = &mut bytes[..size];
        stored.copy_from_slice(self.data.get(start..)?.get(..size)?);
        self.at = start + size;
        if self.is_big {
            stored.reverse();
        }
        kind.read(stored)
    }

    /// Number of elements or bytes that follow; not more than there are bytes.
    fn length(&mut self) -> Option<usize> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it was stored as a u32")]
        let length = self.number(StoredNumber::U32)? as usize;
        (length <= self.data.len()).then_some(length)
    }

    fn read(&mut self, steps: &[Step], numbers: &mut Vec<Number>) -> Option<()> {
        for step in steps {
            match step {
                Step::Number(kind, name) => {
                    let value = self.number(*kind)?;
                    numbers.extend(name.as_ref().map(|name| (Rc::clone(name), value)));
                }
                Step::Text => {
                    self.at = self.length()?.checked_add(self.at)?;
                }
                Step::Sequence(elements) => {
                    for _ in 0..self.length()? {
                        self.read(elements, numbers)?;
                    }
                }
            }
        }
        (self.at <= self.data.len()).then_some(())
    }
}
