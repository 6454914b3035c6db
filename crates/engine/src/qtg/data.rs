//! The copy of the validation data that goes with a page.

use doublet_core::validate::Signal;

use super::DataCopy;
use crate::keep::hash_bytes;
use crate::session::Surface;
use crate::stage::{WindowAero, WindowReplay, deflection};

/// Flight, model and deflections at every sample, SI.
pub fn copy(id: &str, replay: &WindowReplay, aero: &WindowAero) -> DataCopy {
    let mut names = vec!["time_s".to_owned()];
    let mut columns: Vec<&[f64]> = vec![&replay.measured.time_s];
    for signal in Signal::ALL {
        names.extend([format!("{}_flight", signal.name()), format!("{}_model", signal.name())]);
        columns.extend([replay.measured.get(signal), replay.simulated.get(signal)]);
    }
    for surface in Surface::ALL {
        let Some(values) = deflection(surface, aero) else { continue };
        names.push(surface.name().to_owned());
        columns.push(values);
    }
    let mut text = names.join(",");
    text.push('\n');
    for sample in 0..replay.measured.time_s.len() {
        let row: Vec<String> =
            columns.iter().map(|column| column.get(sample).map(f64::to_string).unwrap_or_default()).collect();
        text.push_str(&row.join(","));
        text.push('\n');
    }
    DataCopy { name: format!("qtg_{id}.csv"), sha256: hash_bytes(text.as_bytes()), text }
}
