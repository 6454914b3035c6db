//! What a recording leaves open: the questions that `inspect`, `map` and `new` ask.

use doublet_core::load::{By, ManualChannel, ManualChannelMap, Probe, Source, find_surface_signal, stated_unit};
use doublet_core::quantity::Role;
use doublet_engine::session::Surface;

/// Sources that a question lists; more are counted.
const LISTED_SOURCES: usize = 4;

/// What a recording leaves open.
pub struct Question {
    /// Sources it is about; none where the text names them.
    sources: Vec<String>,
    /// The question, with what is taken where it has no answer.
    text: String,
    /// Option of the command line that answers it, where its value follows from the question.
    pub option: Option<String>,
    /// Nothing is right before it is answered: there is no time, it is too coarse, or it can be read in several units.
    pub must_be_answered: bool,
    /// Role whose unit is asked for.
    pub role: Option<Role>,
    about: About,
}

impl Question {
    /// One that need not be answered.
    fn new(source: &str, text: String, about: About) -> Self {
        Self { sources: vec![source.to_owned()], text, option: None, must_be_answered: false, role: None, about }
    }

    /// The unit of a deflection, which must be known: nothing in the motion shows it.
    fn of_deflection(source: &str, text: String, role: Role, option: String) -> Self {
        let open = Self::new(source, text, About::Deflection);
        Self { option: Some(option), must_be_answered: true, role: Some(role), ..open }
    }

    /// The question with the option that answers it.
    pub fn line(&self) -> String {
        let text = self.text();
        self.option.as_ref().map_or_else(|| text.clone(), |option| format!("{text}; use {option}"))
    }

    /// The question and the sources it is about.
    pub fn text(&self) -> String {
        let is_of_time = self.about == About::Time;
        let quoted = |name: &String| if is_of_time { format!("'{name}'") } else { name.clone() };
        match &self.sources[..] {
            [] => self.text.clone(),
            [source] if is_of_time => format!("source '{source}': {}", self.text),
            [source] => format!("{source}: {}", self.text),
            [first, others @ ..] => {
                let others = match others {
                    few if few.len() <= LISTED_SOURCES => few.iter().map(quoted).collect::<Vec<_>>().join(", "),
                    many => format!("{} other sources", many.len()),
                };
                format!("{} and {others}: {}", quoted(first), self.text)
            }
        }
    }

    /// Whether a sign is asked for.
    pub fn is_of_sign(&self) -> bool {
        self.about == About::Sign
    }
}

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum About {
    /// The unit of a clock.
    Clock,
    /// A source without time.
    Time,
    /// A deflection that can be two things.
    Deflection,
    /// The unit of a role.
    Unit,
    /// The sign of a role.
    Sign,
    /// A role that no name says.
    Role,
}

/// What the file leaves open: the unit of time or its absence, and units of channels that look made for a role.
pub fn list_questions(probe: &Probe, guessed: &ManualChannelMap) -> Vec<Question> {
    // A time that was said is not asked for.
    let is_open = |source: &&Source| guessed.time.iter().all(|(name, _)| *name != source.name);
    let clocks =
        probe.sources.iter().filter(is_open).flat_map(|source| source.clocks.iter().map(move |clock| (source, clock)));
    let of_clocks = clocks.filter_map(|(source, clock)| {
        let text = format!("time {}", clock.question.as_ref()?);
        let coarse = clock.coarse;
        if coarse.is_some() && !plays_role(source, guessed) {
            return None;
        }
        let option = coarse.map(|coarse| format!("--time {},rate={}", clock.channel, coarse.rate_hz));
        let must_be_answered = clock.is_unit_ambiguous || coarse.is_some();
        Some(Question { option, must_be_answered, ..Question::new(&source.name, text, About::Clock) })
    });
    let without_time = probe
        .sources
        .iter()
        .filter(is_open)
        .filter(|source| plays_role(source, guessed))
        .filter_map(|source| Some((source, source.describe_missing_time()?)));
    let without_time = without_time
        .map(|(source, text)| Question { must_be_answered: true, ..Question::new(&source.name, text, About::Time) });
    let of_deflections: Vec<Question> = Surface::ALL
        .into_iter()
        .map(Surface::role)
        .filter_map(|role| ask_calibration(probe, guessed, role).or_else(|| ask_deflection(probe, guessed, role)))
        .collect();
    let of_units = guessed.rows.iter().filter_map(|(role, row)| {
        let channel = row.from.find(std::slice::from_ref(probe))?;
        let is_open = !row.is_unit_known && stated_unit(channel).is_none();
        let unit = row.unit.filter(|unit| is_open && unit.symbol != "-")?;
        let (name, role_name, unit) = (&channel.name, role.name(), unit.symbol);
        let text = format!("'{name}', guessed as {role_name}, states no unit: its values suggest {unit}");
        Some(Question { role: Some(*role), ..Question::new(&row.from.source, text, About::Unit) })
    });
    // The unit of a deflection that is asked for by itself is not asked for again.
    let is_new = |question: &Question| of_deflections.iter().all(|other| other.role != question.role);
    let of_units: Vec<Question> = of_units.filter(is_new).collect();
    let of_signs = guessed.rows.iter().filter(|(_, row)| row.asks_sign).map(|(role, row)| {
        let (source, name, role) = (&row.from.source, &row.from.channel, role.name());
        let taken = match changes(row) {
            changes if changes.is_empty() => "left as recorded".to_owned(),
            changes => changes.join(", "),
        };
        let text = format!("the sign of '{name}', guessed as {role}, is not documented: {taken}");
        Question::new(source, text, About::Sign)
    });
    let of_roles = guessed.rows.iter().filter(|(_, row)| row.by == By::Physics).map(|(role, row)| {
        let (source, name, role) = (&row.from.source, &row.from.channel, role.name());
        let evidence = row.evidence.as_ref().map_or_else(String::new, |evidence| format!(" ({evidence})"));
        let text = format!(
            "'{name}' can be {role} by comparison with other channels{evidence}, but its name does not confirm it"
        );
        Question::new(source, text, About::Role)
    });
    let of_roles = of_roles.chain(ask_layout(guessed));
    let all = of_clocks.chain(without_time).chain(of_deflections).chain(of_units).chain(of_signs).chain(of_roles);
    let all: Vec<Question> = all.collect();
    if all.is_empty() { ask_roles(guessed).into_iter().collect() } else { all }
}

/// What a row makes of the values recorded beside their unit: sign, scale, offset.
pub fn changes(row: &ManualChannel) -> Vec<String> {
    let sign = row.turned.then(|| "sign reversed".to_owned());
    let scale = (row.scale != 1.0).then(|| format!("scale {}", row.scale));
    let unit = row.unit.map_or_else(String::new, |unit| format!(" {}", unit.symbol));
    let offset = (row.offset != 0.0).then(|| format!("offset {}{unit}", row.offset));
    sign.into_iter().chain(scale).chain(offset).collect()
}

/// The roles of a recording of which no channel plays one, where nothing else is asked.
fn ask_roles(guessed: &ManualChannelMap) -> Option<Question> {
    let has_none = guessed.rows.is_empty() && guessed.attitude.is_none() && guessed.velocity.is_none();
    let text = "no channel is recognised: state the channels of roles";
    let option = Some("--role ROLE=CHANNEL".to_owned());
    let sources = Vec::new();
    has_none.then(|| Question { sources, option, ..Question::new("", text.to_owned(), About::Role) })
}

/// Roles of a table without names, by the order of its columns: one question for all of them.
fn ask_layout(guessed: &ManualChannelMap) -> Option<Question> {
    let rows = || guessed.rows.iter().filter(|(_, row)| row.by == By::Layout);
    let (_, first) = rows().next()?;
    let roles: Vec<String> = rows().map(|(role, row)| format!("'{}' is {}", row.from.channel, role.name())).collect();
    let text = format!(
        "number, order and values of the columns match a table of {} without names: {}; check each role",
        guessed.recorders.join(", "),
        roles.join(", ")
    );
    Some(Question::new(&first.from.source, text, About::Role))
}

/// Whether a source plays a role in the guess; every one does where none does.
fn plays_role(source: &Source, guessed: &ManualChannelMap) -> bool {
    let rows = guessed.rows.iter().map(|(_, row)| &row.from.source);
    let rows = rows.chain(guessed.attitude.iter().map(|attitude| &attitude.source));
    let mut rows = rows.chain(guessed.velocity.iter().flatten().map(|row| &row.from.source)).peekable();
    rows.peek().is_none() || rows.any(|name| *name == source.name)
}

/// Deflections that can be radians or a part of full travel, rad, and from which degrees can be per cent of it, deg. Below, a control rests.
const LEAST_PART: f64 = 0.002;
const LARGEST_PART: f64 = 1.05;
const LEAST_PER_CENT: f64 = 45.0;

/// A deflection without a unit whose values are those of two: nothing in the motion tells them apart, and its derivatives go with it. Of a
/// recorder that gives other angles in radians, radians are not asked for.
fn ask_deflection(probe: &Probe, guessed: &ManualChannelMap, role: Role) -> Option<Question> {
    let probes = std::slice::from_ref(probe);
    let row = guessed.row(role).filter(|row| row.is_unit_open(probes))?;
    let values = row.values(probes)?;
    let largest = values.least.abs().max(values.greatest.abs());
    let angles = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle, Role::AngleOfAttack, Role::Sideslip];
    let mut units = angles.into_iter().filter_map(|role| guessed.row(role)?.unit);
    let (first, second) = match values.unit.symbol {
        "rad" if (LEAST_PART..=LARGEST_PART).contains(&largest) && units.any(|unit| unit.symbol == "deg") => {
            ("radians", "fractions of full travel")
        }
        "deg" if largest > LEAST_PER_CENT && largest <= 100.0 * LARGEST_PART => ("degrees", "per cent of full travel"),
        _ => return None,
    };
    let (name, channel, symbol) = (role.name(), &row.from.channel, values.unit.symbol);
    let text = format!(
        "'{channel}', guessed as {name}, states no unit: {:.3} to {:.3} can be {first} or {second}",
        values.least, values.greatest
    );
    let option = format!("--role {name}={channel},unit={symbol}, or unit=deg,scale=X with X degrees per recorded unit");
    Some(Question::of_deflection(&row.from.source, text, role, option))
}

/// A control surface that was recorded as a signal: no angle without its calibration, and no derivative of the control.
fn ask_calibration(probe: &Probe, guessed: &ManualChannelMap, role: Role) -> Option<Question> {
    let (from, unit) = find_surface_signal(std::slice::from_ref(probe), guessed, role)?;
    let (name, channel) = (role.name(), &from.channel);
    let text = format!("'{channel}', named like {name}, is in {unit}, not an angle");
    let option = format!("--role {name}={channel},unit=deg,scale=X with X degrees per recorded unit");
    Some(Question::of_deflection(&from.source, text, role, option))
}

/// Questions of one reason as one: clocks of the same stamps, sources without time, deflections, units, signs.
pub fn group(all: Vec<Question>) -> Vec<Question> {
    let mut grouped: Vec<Question> = Vec::new();
    for question in all {
        let has_sources = matches!(question.about, About::Clock | About::Time);
        let is_like = |first: &&mut Question| {
            first.about == question.about
                && first.must_be_answered == question.must_be_answered
                && (!has_sources || first.text == question.text)
        };
        match grouped.iter_mut().find(is_like) {
            Some(first) if has_sources => first.sources.extend(question.sources),
            Some(first) => {
                first.role = None;
                first.text = format!("{}; {}", first.text(), question.text());
                first.sources.clear();
                let options: Vec<String> = first.option.take().into_iter().chain(question.option).collect();
                first.option = (!options.is_empty()).then(|| options.join("; "));
            }
            None => grouped.push(question),
        }
    }
    grouped
}
