//! `doublet datcom`: a listing's derivatives beside identified ones, and the input deck.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use doublet_core::load::datcom::{
    DatcomAxes, DatcomDeck, DatcomListing, DatcomSection, DeckCondition, DeckReference, PredictedDerivative,
    PredictionOptions, beside,
};
use doublet_engine::graph::Context;
use doublet_engine::report::Reference;
use doublet_engine::stage::{self, AircraftData};
use doublet_engine::{builtin, report};

use crate::output_path::output_path;
use crate::{new, text};

#[derive(Debug, Args)]
pub struct DatcomArguments {
    /// Output listing of Digital DATCOM.
    #[arg(required_unless_present = "deck", conflicts_with = "deck")]
    pub listing: Option<PathBuf>,
    /// Aircraft for the rate normalisation [default: q c/V, p b/2V, r b/2V].
    #[arg(long, conflicts_with = "deck")]
    pub aircraft: Option<String>,
    /// Results to compare with: results.json of a run.
    #[arg(long, value_name = "RESULTS.JSON", conflicts_with = "deck")]
    pub results: Option<PathBuf>,
    /// Angles of attack, deg [default: level flight; deck: -2 to 13].
    #[arg(long, value_name = "DEG,DEG", value_delimiter = ',', allow_negative_numbers = true)]
    pub alpha_deg: Vec<f64>,
    /// Aircraft (file or name) to write an input deck for.
    #[arg(long, value_name = "AIRCRAFT", requires = "output")]
    pub deck: Option<String>,
    /// Deck file to write.
    #[arg(short, long, requires = "deck", value_parser = output_path())]
    pub output: Option<PathBuf>,
    /// Mach number of the deck.
    #[arg(long, default_value_t = 0.137)]
    pub mach: f64,
    /// Altitude of the deck, m.
    #[arg(long, value_name = "M", default_value_t = 1130.0, allow_negative_numbers = true)]
    pub altitude_m: f64,
}

/// Prints the derivatives of a listing or writes a deck.
///
/// # Errors
/// One line: what cannot be read, does not fit or cannot be written; no file is left then.
pub fn datcom(arguments: &DatcomArguments) -> Result<(), String> {
    match (&arguments.listing, &arguments.deck, &arguments.output) {
        (Some(path), ..) => print_listing(path, arguments),
        (None, Some(aircraft), Some(output)) => write_deck(aircraft, output, arguments),
        _ => Err("give a listing, or an aircraft and a file: `doublet datcom --deck c337f -o FILE`".to_owned()),
    }
}

fn print_listing(path: &Path, arguments: &DatcomArguments) -> Result<(), String> {
    let listing = DatcomListing::read(path).map_err(|error| error.to_string())?;
    let aircraft = arguments.aircraft.as_deref().map(aircraft_data).transpose()?;
    let identified = arguments.results.as_deref().map(report::reference).transpose()?;
    let alphas: Vec<f64> =
        if arguments.alpha_deg.is_empty() {
            vec![listing.level_flight_alpha_rad().ok_or_else(|| {
                format!("{}: angle of attack in level flight unknown: give --alpha-deg", path.display())
            })?]
        } else {
            arguments.alpha_deg.iter().map(|alpha| alpha.to_radians()).collect()
        };
    let tables = alphas
        .into_iter()
        .map(|alpha| predicted(&listing, alpha, aircraft.as_ref()).map(|found| (alpha, found)))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| format!("{}: {error}", path.display()))?;
    print_head(&listing, aircraft.as_ref());
    for (alpha, predicted) in tables {
        text::line("");
        text::line(&format!("angle of attack {} deg", text::number(alpha.to_degrees(), 4)));
        print_table(&predicted, identified.as_ref());
    }
    Ok(())
}

pub fn aircraft_data(name: &str) -> Result<AircraftData, String> {
    let loaded = stage::load_aircraft(&Context::new(Path::new(".")), &new::aircraft_reference(name)?)?;
    Ok(stage::aircraft_data(Arc::clone(loaded.shared()), None))
}

/// Derivatives of the listing with the aircraft's normalisation of rates: body axes, with lift and drag beside.
pub fn predicted(
    listing: &DatcomListing,
    alpha_rad: f64,
    aircraft: Option<&AircraftData>,
) -> Result<Vec<PredictedDerivative>, String> {
    let own = aircraft.map(|aircraft| aircraft.loaded.aircraft.reference);
    let options = own.map_or_else(PredictionOptions::default, |own| PredictionOptions {
        pitch_rate_chords: own.pitch_rate_length_m / own.chord_m,
        lateral_rate_spans: own.lateral_rate_length_m / own.lateral_moment_length_m,
        ..PredictionOptions::default()
    });
    let derivatives_in = |axes| {
        listing.derivatives(alpha_rad, &PredictionOptions { axes, ..options }).map_err(|error| error.to_string())
    };
    let mut found = derivatives_in(DatcomAxes::Body)?;
    let lift_and_drag = |derivative: &PredictedDerivative| matches!(derivative.name.get(..2), Some("CL" | "CD"));
    found.extend(derivatives_in(DatcomAxes::Stability)?.into_iter().filter(lift_and_drag));
    Ok(found)
}

/// Relative difference of reference lengths and areas, and part of the chord, above which the two are said to differ.
const SAME_REFERENCE: f64 = 0.005;

fn print_head(listing: &DatcomListing, aircraft: Option<&AircraftData>) {
    let c = listing.conditions;
    text::line(&listing.title);
    text::line(&format!("Mach {}, altitude {} m", text::number(c.mach, 4), text::number(c.altitude_m, 5)));
    text::line(&format!(
        "area {} m2, chord {} m, span {} m, moments about x = {} m, z = {} m of the deck",
        text::number(c.area_m2, 5),
        text::number(c.chord_m, 4),
        text::number(c.span_m, 5),
        text::number(c.reference_x_m, 4),
        text::number(c.reference_z_m, 4)
    ));
    listing.warnings.iter().for_each(|warning| text::line(&format!("warning: {warning}")));
    let Some(aircraft) = aircraft else { return };
    let reference = aircraft.loaded.aircraft.reference;
    let lengths = [
        ("area", c.area_m2, reference.area_m2),
        ("chord", c.chord_m, reference.chord_m),
        ("span", c.span_m, reference.span_m),
    ];
    for (name, listed, own) in lengths {
        if (listed - own).abs() > SAME_REFERENCE * own {
            text::line(&format!("warning: the listing's {name} is {listed}, the aircraft's {own}: not converted"));
        }
    }
    let cg_x_m = aircraft.mass.cg_from_datum_m[0];
    if (c.reference_x_m - cg_x_m).abs() > SAME_REFERENCE * reference.chord_m {
        text::line(&format!(
            "warning: the listing's moments are about x = {} m, the centre of gravity is at {} m: not moved",
            text::number(c.reference_x_m, 4),
            text::number(cg_x_m, 4)
        ));
    }
}

fn print_table(predicted: &[PredictedDerivative], identified: Option<&Reference>) {
    let Some(identified) = identified else {
        let rows = predicted.iter().map(|row| vec![row.name.to_owned(), text::number(row.value, 4)]);
        text::table(&["derivative", "DATCOM"], &rows.collect::<Vec<_>>());
        return;
    };
    let pairs: Vec<_> = identified.values.iter().map(|(name, value, _)| (name.as_str(), *value)).collect();
    let both = beside(predicted, &pairs);
    let rows = predicted.iter().map(|row| {
        let mut cells = vec![row.name.to_owned(), text::number(row.value, 4)];
        if let Some(pair) = both.iter().find(|pair| pair.name == row.name) {
            let error = identified.get(row.name).and_then(|(_, error)| error);
            cells.push(text::number(pair.identified, 4));
            cells.push(text::number(error.unwrap_or(f64::NAN), 2));
            cells.push(text::number(pair.ratio(), 3));
            cells.push(if pair.same_sign() { "" } else { "signs differ" }.to_owned());
        }
        cells
    });
    let header = ["derivative", "DATCOM", "identified", "corrected error", "DATCOM/identified", ""];
    text::table(&header, &rows.collect::<Vec<_>>());
}

fn write_deck(aircraft: &str, output: &Path, arguments: &DatcomArguments) -> Result<(), String> {
    if output.exists() {
        return Err(format!("{} exists: choose another name for the deck", output.display()));
    }
    let data = aircraft_data(aircraft)?;
    let file = aircraft_file(aircraft)?;
    let section = DatcomSection::read(&file).map_err(|error| error.to_string())?;
    let section =
        section.ok_or_else(|| format!("{aircraft}: it has no [datcom] section with the shape of the deck"))?;
    let airframe = &data.loaded.aircraft;
    let alpha_deg =
        if arguments.alpha_deg.is_empty() { (-2..=13).map(f64::from).collect() } else { arguments.alpha_deg.clone() };
    if alpha_deg.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err("--alpha-deg: the angles must increase".to_owned());
    }
    let deck = DatcomDeck {
        reference: DeckReference::from_aircraft(airframe, &data.loading.mass_properties(airframe)),
        condition: DeckCondition { mach: arguments.mach, altitude_m: arguments.altitude_m, alpha_deg },
        section,
    };
    let content = deck.to_text().map_err(|error| format!("{aircraft}: {error}"))?;
    write_whole(output, &content).map_err(|error| format!("{}: {error}", output.display()))?;
    text::line(&format!("{}: {} cards", output.display(), content.lines().count()));
    Ok(())
}

fn aircraft_file(name: &str) -> Result<PathBuf, String> {
    if builtin::text("aircraft", name).is_some() {
        return builtin::on_disk(&format!("aircraft/{name}.toml"));
    }
    Ok(PathBuf::from(name))
}

/// Writes the file, which appears complete or not at all and never replaces another.
fn write_whole(path: &Path, content: &str) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(content.as_bytes())?;
    file.persist_noclobber(path)?;
    Ok(())
}
