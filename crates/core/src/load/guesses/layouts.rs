//! Tables without column names, recognised by the number and order of their columns and by columns that must agree.

use serde::Deserialize;

use crate::load::contents::Probe;
use crate::load::guesses::by_physics::is_empty_name;
use crate::load::guesses::motion::fit_line;

/// Least correlation of two columns that hold the same quantity.
const LEAST_CORRELATION: f64 = 0.98;

/// The columns of a table that a recorder writes without their names.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Layout {
    /// Name of the table in messages.
    pub(crate) name: String,
    /// Names of the columns, in their order.
    columns: Vec<String>,
    /// Pairs of columns that hold the same quantity, or its negative.
    agree: Vec<[String; 2]>,
}

impl Layout {
    /// `probe` with these names, where it is one table of as many nameless columns and the pairs agree.
    pub(crate) fn name_columns(&self, probe: &Probe) -> Option<Probe> {
        let [source] = &probe.sources[..] else { return None };
        let is_nameless = || source.channels.iter().all(|channel| is_empty_name(&channel.name));
        if source.channels.len() != self.columns.len() || !is_nameless() {
            return None;
        }
        let column = |name: &String| source.channels.get(self.columns.iter().position(|other| other == name)?);
        let agrees = |[first, second]: &[String; 2]| {
            let (Some(first), Some(second)) = (column(first), column(second)) else { return false };
            let pairs: Vec<(f64, f64)> = first.values().iter().copied().zip(second.values().iter().copied()).collect();
            fit_line(&pairs).is_some_and(|(_, correlation)| correlation.abs() >= LEAST_CORRELATION)
        };
        if !self.agree.iter().all(agrees) {
            return None;
        }
        let mut named = probe.clone();
        for (channel, name) in named.sources.iter_mut().flat_map(|source| &mut source.channels).zip(&self.columns) {
            channel.name.clone_from(name);
        }
        Some(named)
    }

    /// Where the first column called `name` stands, from 0, and of how many.
    pub(crate) fn index_and_count(&self, name: &str) -> Option<(usize, usize)> {
        Some((self.columns.iter().position(|other| other == name)?, self.columns.len()))
    }
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::maps::by_hand::By;
    use crate::load::probe_of;
    use crate::quantity::Role;

    /// A table of 42 columns as FlightGear writes it; `other` is taken for the altitude of the GPS receiver.
    fn table(other: impl Fn(f64) -> f64) -> String {
        let mut text = String::new();
        for k in 0..200_u32 {
            let t = 0.1 * f64::from(k);
            let (roll, pitch, altitude) = (20.0 * (0.4 * t).sin(), 4.0 + 3.0 * (0.3 * t).sin(), 3000.0 + 30.0 * t);
            let mut cells = vec![0.0; 42];
            cells[0] = 0.2 * (0.4 * t).cos();
            cells[14] = 48.1 + 1e-5 * t;
            cells[15] = 11.5 - 2e-5 * t;
            (cells[16], cells[25], cells[31], cells[33]) = (altitude, altitude + 8.0, altitude, other(altitude));
            (cells[17], cells[28], cells[30]) = (roll, roll, roll);
            (cells[18], cells[27], cells[29]) = (pitch, pitch, pitch);
            (cells[19], cells[36]) = (170.0 + t, 171.0 + t);
            cells[21] = 95.0 + (0.3 * t).cos();
            (cells[23], cells[40]) = (30.0 + (0.2 * t).sin(), 1800.0);
            cells[41] = 2400.0 + t;
            let row: Vec<String> = cells.iter().map(|cell| format!("{cell:.7}")).collect();
            text += &format!("{}\n", row.join(","));
        }
        text
    }

    #[test]
    fn a_table_without_names_is_known_by_the_order_of_its_columns() {
        let probe = probe_of(&table(|altitude| altitude));
        let map = guess(std::slice::from_ref(&probe));
        assert_eq!(map.recorders, ["FlightGear"]);
        for (role, channel, unit, turned) in [
            (Role::BankAngle, "column[17]", "deg", false),
            (Role::PitchAngle, "column[18]", "deg", false),
            (Role::Latitude, "column[14]", "deg", false),
            (Role::CalibratedAirspeed, "column[21]", "kt", false),
            (Role::VelocityDown, "column[23]", "ft/s", true),
        ] {
            let row = map.row(role).unwrap();
            let found = (row.from.channel.as_str(), row.unit.unwrap().symbol, row.turned);
            assert_eq!(found, (channel, unit, turned), "{}", role.name());
            assert_eq!(row.by, By::Layout, "the order of columns alone is asked for");
            assert!(row.evidence.as_deref().is_some_and(|text| text.contains("of 42")));
        }
    }

    #[test]
    fn a_table_of_as_many_columns_that_do_not_agree_is_not_known() {
        let map = guess(&[probe_of(&table(|altitude| (0.01 * altitude).sin()))]);
        assert!(map.recorders.is_empty() && map.rows.is_empty(), "{:?}", map.rows);
    }
}
