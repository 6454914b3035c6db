//! Tall tables of text: a row for every value, with its time, the name of its channel and perhaps its unit.

use std::collections::HashMap;
use std::path::Path;

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::clocks::stamp::Stamp;
use crate::load::clocks::time_names::is_time_name;
use crate::load::contents::{ChannelInfo, Source};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::formats::text_layout::{Separator, TextLayout, number};
use crate::load::names::words::plain_letters;

const NAMES: [&str; 14] = [
    "name", "parameter", "parametername", "param", "signal", "signalname", "channel", "channelname", "variable",
    "mnemonic", "measurement", "sensor", "tag", "field",
];
const VALUES: [&str; 5] = ["value", "val", "values", "engineeringvalue", "euvalue"];
const UNITS: [&str; 3] = ["unit", "units", "engineeringunit"];
/// Most columns of such a table.
const MOST_COLUMNS: usize = 8;

/// Which columns of a table are what.
pub(crate) struct Tall {
    time: usize,
    name: usize,
    value: usize,
    unit: Option<usize>,
    separator: u8,
}

/// A channel being filled.
#[derive(Default)]
struct Column {
    name: String,
    unit: Option<String>,
    time: Vec<f64>,
    values: Vec<f64>,
}

impl Tall {
    /// The columns of a table that is laid out so.
    pub(crate) fn find(layout: &TextLayout) -> Option<Self> {
        let Separator::Byte(separator) = layout.separator else { return None };
        let called =
            |names: &[&str]| layout.names.iter().position(|name| names.contains(&plain_letters(name).as_str()));
        let time = layout.names.iter().position(|name| is_time_name(name))?;
        let (name, value, unit) = (called(&NAMES)?, called(&VALUES)?, called(&UNITS));
        (layout.columns <= MOST_COLUMNS).then_some(Self { time, name, value, unit, separator })
    }

    /// A source for every clock in the rows `lines`; channels of the same stamps share one.
    pub(crate) fn read(
        &self,
        (path, budget): (&Path, &Budget<'_>),
        layout: &TextLayout,
        lines: &[u8],
    ) -> Result<Vec<Source>, LoadError> {
        let mut columns: Vec<Column> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        let mut is_stamp = false;
        for (row, line) in lines.split(|&letter| letter == b'\n').enumerate() {
            let cells: Vec<&[u8]> = line.split(|&letter| letter == self.separator).map(plain).collect();
            let at = |index: usize| cells.get(index).copied().unwrap_or_default();
            let Some(time) = number(at(self.time), layout.decimal_comma) else { continue };
            is_stamp |= Stamp::parse(at(self.time)).is_some();
            let name = String::from_utf8_lossy(at(self.name)).into_owned();
            let index = *known.entry(name.clone()).or_insert_with(|| {
                let unit = self.unit.map(|unit| String::from_utf8_lossy(at(unit)).into_owned());
                columns.push(Column { name, unit: unit.filter(|unit| !unit.is_empty()), ..Column::default() });
                columns.len() - 1
            });
            budget.take(2 * NUMBER_BYTES, || format!("its table has over {row} rows"))?;
            columns[index].time.push(time);
            columns[index].values.push(number(at(self.value), layout.decimal_comma).unwrap_or(f64::NAN));
        }
        Ok(self.group(path, layout, columns, is_stamp))
    }

    /// Sources of the columns, those of the same stamps in one.
    fn group(&self, path: &Path, layout: &TextLayout, columns: Vec<Column>, is_stamp: bool) -> Vec<Source> {
        let mut sources: Vec<(Vec<f64>, Source)> = Vec::new();
        for Column { name, unit, time, values } in columns {
            let index = sources.iter().position(|(other, _)| *other == time).unwrap_or_else(|| {
                let number = sources.len() + 1;
                let mut source = Source::new(if number == 1 { stem(path) } else { format!("{} {number}", stem(path)) });
                let unit = layout.units[self.time].clone().or(is_stamp.then(|| "s".to_owned()));
                let clock = ChannelInfo::new(layout.names[self.time].clone(), unit, time.clone());
                source.channels.push(ChannelInfo { is_time_of_day: is_stamp, ..clock });
                sources.push((time, source));
                number - 1
            });
            sources[index].1.channels.push(ChannelInfo::new(name, unit, values));
        }
        sources.into_iter().map(|(_, source)| source).collect()
    }
}

/// A cell without blanks and quotes about it.
fn plain(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\"")).unwrap_or(cell)
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    #[test]
    fn a_row_for_every_value_makes_channels_with_their_clocks() {
        let mut text = "timestamp,parameter,value,unit\n".to_owned();
        for k in 0..200_u32 {
            let t = 0.02 * f64::from(k);
            text += &format!("{t:.2},Roll,{:.3},deg\n{t:.2},Roll rate,{:.3},deg/s\n", t.sin(), t.cos());
            if k % 10 == 0 {
                text += &format!("{t:.2},\"Altitude\",{:.1},ft\n", 1000.0 + t);
            }
        }
        let probe = probe_of(&text);
        assert_eq!(probe.sources.len(), 2);
        let rates: Vec<f64> = probe.sources.iter().map(|source| source.clocks[0].rate_hz.round()).collect();
        assert_eq!(rates, [50.0, 5.0]);
        let map = guess(std::slice::from_ref(&probe));
        let read = |role: Role| map.row(role).map(|row| (row.from.channel.as_str(), row.unit.unwrap().symbol));
        assert_eq!(read(Role::BankAngle), Some(("Roll", "deg")));
        assert_eq!(read(Role::RollRate), Some(("Roll rate", "deg/s")));
        assert_eq!(read(Role::Altitude), Some(("Altitude", "ft")));
        let rate = map.row(Role::RollRate).unwrap().from.find(std::slice::from_ref(&probe)).unwrap();
        assert!(rate.samples == 200 && (rate.values()[100] - 2.0_f64.cos()).abs() < 1e-3);
    }
}
