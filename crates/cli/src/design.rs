//! `doublet design` and `enough`: inputs of the next flight from the identified model, and whether what was flown is enough.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use doublet_dynamics::design::{Basis, Criterion, DesignKind, Designed, Quantity, Request, SURFACE_NAMES, THROTTLE};
use doublet_engine::planning::{
    self, DesignOptions, DesignRow, EnoughOptions, Goal, PathShare, design_basis, design_document, designed_rows,
};
use doublet_engine::report::document::Style;
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::Session;
use doublet_engine::study::{DynamicsRequest, Study};
use doublet_report::{DocumentSet, ReportFormat};

use crate::arguments::{not_negative, positive, report_format};
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{computed, named, rebase};
use crate::text::{self, number};

/// Names of the surfaces, without the throttle.
pub const SURFACES: [&str; THROTTLE] = [SURFACE_NAMES[0], SURFACE_NAMES[1], SURFACE_NAMES[2]];

/// Trim, limits and draws of a design.
#[derive(Debug, Args)]
pub struct BasisArguments {
    /// Session file.
    pub session: PathBuf,
    /// Controls to move.
    #[arg(long, value_name = "SURFACE,...", value_delimiter = ',', default_value = "aileron,elevator,rudder", value_parser = PossibleValuesParser::new(SURFACE_NAMES))]
    surfaces: Vec<String>,
    /// Criterion to minimise: d (determinant), a (sum of squared relative errors), max-relative.
    #[arg(long, default_value = "a", value_parser = PossibleValuesParser::new(Criterion::ALL.map(Criterion::name)))]
    criterion: String,
    /// Largest deflection from trim, deg [default: as in the manoeuvres].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    peak: Option<f64>,
    /// Largest deflection rate, deg/s.
    #[arg(long, value_name = "DEG_S", default_value = "60", value_parser = positive)]
    rate: f64,
    /// Largest change of thrust, N [default: a fifth of the trim's].
    #[arg(long, value_name = "N", value_parser = positive)]
    peak_thrust: Option<f64>,
    /// Limit of alpha, beta, phi (rad), n_z, p (rad/s), V (m/s) or h (m). Repeatable.
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = limit, allow_hyphen_values = true)]
    limit: Vec<(Quantity, f64, f64)>,
    /// Fraction of the margin to the limits for the nominal response.
    #[arg(long, default_value_t = Request::USUAL_USAGE)]
    usage: f64,
    /// Standard deviation of the gusts, m/s [default: from the filter].
    #[arg(long, value_name = "M_S", value_parser = not_negative)]
    gusts: Option<f64>,
    /// True airspeed of the trim, m/s [default: median of identification manoeuvres].
    #[arg(long, value_name = "M_S")]
    airspeed: Option<f64>,
    /// Altitude of the trim, m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    altitude: Option<f64>,
    /// Total fuel on board, kg.
    #[arg(long, value_name = "KG")]
    fuel: Option<f64>,
    /// Random seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Args)]
pub struct DesignArguments {
    /// Options of every design.
    #[command(flatten)]
    basis: BasisArguments,
    /// Total time of the manoeuvres, s.
    #[arg(long, value_name = "S", default_value = "60", value_parser = positive)]
    time: f64,
    /// Kind of input, for example doublet, 3-2-1-1, multisine or linear-sweep.
    #[arg(long, default_value = "multisine", value_parser = kind)]
    kind: DesignKind,
    /// Search rounds over times, levels and spectra; 0 for published shapes.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Random draws of derivatives, gusts and initial states.
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    samples: u32,
    /// Include the manoeuvres flown so far in the errors.
    #[arg(long)]
    with_flown: bool,
    /// Compare all kinds within the same limits and time.
    #[arg(long)]
    compare: bool,
    /// Folder for card, nodes (CSV), scenario, session and autopilot files.
    #[arg(long, value_parser = output_path())]
    out: Option<PathBuf>,
    /// House style of the card; units = "aviation" for knots and feet.
    #[arg(long, value_name = "FILE")]
    style: Option<PathBuf>,
    /// Formats of the card.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "html", value_parser = report_format())]
    format: Vec<String>,
    /// Full travel of the surfaces each way, deg, for the autopilot.
    #[arg(long, value_name = "DEG", default_value = "20", value_parser = positive)]
    travel: f64,
}

#[derive(Debug, Args)]
pub struct EnoughArguments {
    /// Options of every design.
    #[command(flatten)]
    basis: BasisArguments,
    /// Target standard error of a derivative. Repeatable.
    #[arg(long, value_name = "NAME=ERROR", value_parser = goal)]
    goal: Vec<Goal>,
    /// Target relative error of all other derivatives, per cent.
    #[arg(long, value_name = "PERCENT", default_value = "5", value_parser = positive)]
    goal_percent: f64,
    /// Length of the next manoeuvre, s.
    #[arg(long, value_name = "S", default_value = "15", value_parser = positive)]
    time: f64,
}

/// A kind of input by its name, spaces as hyphens.
pub fn kind(text: &str) -> Result<DesignKind, String> {
    let names = || DesignKind::ALL.map(|kind| kind.name().replace(' ', "-")).join(", ");
    DesignKind::from_name(text).ok_or_else(|| format!("'{text}' is not a kind of input: use one of {}", names()))
}

fn limit(text: &str) -> Result<(Quantity, f64, f64), String> {
    let wrong = || {
        let names = Quantity::ALL.map(Quantity::name).join(", ");
        format!("'{text}' is not a limit: write NAME=LOW:HIGH with one of {names}, for example alpha=0.02:0.18")
    };
    let (name, ends) = text.split_once('=').ok_or_else(wrong)?;
    let (low, high) = ends.split_once(':').ok_or_else(wrong)?;
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
    let (low, high) = (number(low)?, number(high)?);
    if low >= high {
        return Err(wrong());
    }
    Ok((Quantity::from_name(name).ok_or_else(wrong)?, low, high))
}

fn goal(text: &str) -> Result<Goal, String> {
    let wrong = || format!("'{text}' is not a goal: write NAME=ERROR, for example Cm_q=0.05");
    let (name, error) = text.split_once('=').ok_or_else(wrong)?;
    let standard_error = positive(error).map_err(|_| wrong())?;
    Ok(Goal { name: name.trim().to_owned(), standard_error })
}

impl BasisArguments {
    /// Runs the session and gathers what a design starts from.
    fn open(&self) -> Result<(Session, Snapshot, Basis), String> {
        if !(0.05..=1.0).contains(&self.usage) {
            return Err(format!("--usage {} must lie between 0.05 and 1", self.usage));
        }
        let trim = DynamicsRequest {
            airspeed_m_s: self.airspeed,
            altitude_m: self.altitude,
            fuel_kg: self.fuel,
            // Modes are not asked for here: the fewest draws.
            samples: 2,
            ..DynamicsRequest::default()
        };
        let (session, snapshot) = computed(&self.session, &[Study::Dynamics(trim)])?;
        let options = DesignOptions {
            peak_rad: self.peak.map(f64::to_radians),
            rate_rad_s: self.rate.to_radians(),
            peak_thrust_n: self.peak_thrust,
            limits: self.limit.clone(),
            gust_m_s: self.gusts,
        };
        let basis = design_basis(&session, &snapshot, &options).map_err(|error| error.to_string())?;
        Ok((session, snapshot, basis))
    }

    fn request(&self, kind: DesignKind, time_s: f64) -> Request {
        let surfaces = places(&self.surfaces);
        let criterion = Criterion::from_name(&self.criterion);
        Request {
            criterion: criterion.unwrap_or(Criterion::A),
            usage: self.usage,
            seed: self.seed,
            ..Request::published(surfaces, kind, time_s)
        }
    }
}

/// Places of surfaces in their order, each once.
pub fn places(names: &[String]) -> Vec<usize> {
    let place = |name: &String| SURFACE_NAMES.iter().position(|known| known == name);
    let mut surfaces: Vec<usize> = names.iter().filter_map(place).collect();
    surfaces.sort_unstable();
    surfaces.dedup();
    surfaces
}

/// Designs an input, prints what it promises, and writes its files.
pub fn design(arguments: &DesignArguments) -> Result<(), String> {
    let (session, snapshot, basis) = arguments.basis.open()?;
    let request = Request {
        rounds: arguments.rounds,
        search_samples: planning::SEARCH_SAMPLES,
        samples: arguments.samples as usize,
        with_flown: arguments.with_flown,
        ..arguments.basis.request(arguments.kind, arguments.time)
    };
    let found = designed_rows(&basis, &request, arguments.compare, &|| Ok(()));
    let (mut row, designed) = found.map_err(|error| error.to_string())?;
    let share = PathShare::measure((&session, &snapshot), &designed, arguments.with_flown, &Control::default());
    share.iter().for_each(|share| row.add_path(share));
    let written =
        arguments.out.as_ref().map(|_| write(arguments, (&session, &snapshot), &row, &designed)).transpose()?;
    text::json(&row)?;
    print(&row);
    written.into_iter().for_each(|line| text::line(&line));
    Ok(())
}

/// Writes the files of a design; a line that says where.
fn write(
    arguments: &DesignArguments,
    (session, snapshot): (&Session, &Snapshot),
    row: &DesignRow,
    designed: &Designed,
) -> Result<String, String> {
    let folder = arguments.out.as_ref().ok_or("folder missing")?;
    let travel = [arguments.travel.to_radians(); 3];
    let aircraft = snapshot.aircraft.ready().map(|loaded| &loaded.aircraft);
    // The session of the design finds the channel maps and instruments of the one it is of.
    let rebased = rebase(session, arguments.basis.session.parent().unwrap_or(Path::new("")), folder)?;
    let beside = planning::design_files(&rebased, aircraft, row, designed, travel)?;
    let formats = named(&ReportFormat::ALL, &arguments.format, |format| format.name());
    let set = DocumentSet { folder, name: "design", formats: &formats, beside: &beside };
    let progress = Progress::new();
    let show = |part| progress.update(part, "writing the card");
    let style = arguments.style.as_deref().map(Style::open).transpose()?.unwrap_or_default();
    let card = design_document(session, row, designed, &style);
    let written = set.write(&card, "designed input", &Control::default(), &show);
    progress.finish();
    written.map(|put| format!("design in {}", put.folder.display()))
}

fn print(row: &DesignRow) {
    text::line(&format!(
        "{} on {}, {} s in {} manoeuvres, at {} m/s and {} m, gusts of {} m/s",
        row.kind,
        row.surfaces.join(", "),
        number(row.time_s, 4),
        row.manoeuvres.len(),
        number(row.trim["airspeed_m_s"], 4),
        number(row.trim["altitude_m"], 4),
        number(row.gust_m_s, 2)
    ));
    text::show_all(&planning::design_tables(row));
    text::line("");
    let degrees = |rad: &f64| number(rad.to_degrees(), 3);
    for own in &row.manoeuvres {
        let moved = own.peak_rad.iter().map(|(name, peak)| {
            let (rate, factor) = (&own.rate_rad_s[name], own.relative_peak_factor[name]);
            format!(
                "{name} to {} deg at {} deg/s, relative peak factor {}",
                degrees(peak),
                degrees(rate),
                number(factor, 3)
            )
        });
        let thrust = own.peak_thrust_n.map(|peak| format!("thrust by {} N", number(peak, 3)));
        let moved = moved.chain(thrust).collect::<Vec<_>>().join("; ");
        text::line(&format!("manoeuvre {}: {}, {} s; {moved}", own.number, own.name, number(own.duration_s, 4)));
    }
    let close = row.correlations.iter().filter(|own| own.correlation.abs() > 0.6);
    for own in close {
        text::line(&format!("{} and {}: correlation {:+.2}", own.first, own.second, own.correlation));
    }
    row.notes.iter().for_each(|note| text::line(note));
}

/// Prints what was flown against goals, window by window, and what to fly next.
pub fn enough(arguments: &EnoughArguments) -> Result<(), String> {
    if arguments.basis.surfaces.iter().any(|name| name == SURFACE_NAMES[THROTTLE]) {
        return Err("enough compares inputs of the surfaces: leave out the throttle".to_owned());
    }
    let (session, _, basis) = arguments.basis.open()?;
    let options = EnoughOptions {
        goals: arguments.goal.clone(),
        relative_percent: arguments.goal_percent,
        next: arguments.basis.request(DesignKind::Multisine, arguments.time),
    };
    let found = planning::enough(&session.windows, &basis, &options, &|| Ok(())).map_err(|error| error.to_string())?;
    text::json(&found)?;
    let word = if found.enough { "enough" } else { "not enough" };
    text::line(&format!("{word}: {} of {} goals are met", found.met, found.of));
    text::show_all(&planning::enough_tables(&found));
    Ok(())
}
