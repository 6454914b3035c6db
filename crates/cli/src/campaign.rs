//! `doublet campaign`: envelope, test points in their order and cards, matched with what was flown.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::airframe::Loading;
use doublet_engine::graph::Context;
use doublet_engine::planning::{
    Campaign, CampaignFlight, FlownPoint, PlannedPoint, campaign_document, campaign_flight, flown_points,
};
use doublet_engine::report::document::Style;
use doublet_engine::run::Control;
use doublet_engine::stage::load_aircraft;
use doublet_report::{DocumentSet, ReportFormat};
use serde_json::json;

use crate::arguments::{REPORTS, report_format};
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{computed, named, rebase};
use crate::text::{self, number};

#[derive(Debug, Args)]
pub struct CampaignArguments {
    /// Campaign file, or one that comes with the program, `builtin:c337f`.
    pub campaign: PathBuf,
    /// Session for the loading and for manoeuvres matched with the cards.
    #[arg(long)]
    session: Option<PathBuf>,
    /// Folder for envelope and cards.
    #[arg(long, value_parser = output_path())]
    out: Option<PathBuf>,
    /// Formats.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = REPORTS, value_parser = report_format())]
    format: Vec<String>,
    /// House style of the cards; units = "aviation" for knots and feet.
    #[arg(long, value_name = "FILE")]
    style: Option<PathBuf>,
}

/// Plans a campaign, matches it with a session and writes its cards.
pub fn campaign(arguments: &CampaignArguments) -> Result<(), String> {
    let campaign = Campaign::open(&arguments.campaign)?;
    let style = arguments.style.as_deref().map(Style::open).transpose()?.unwrap_or_default();
    let folder = arguments.campaign.parent().map(PathBuf::from).unwrap_or_default();
    let context = Context::new(&folder);
    let loaded = load_aircraft(&context, &campaign.aircraft).map_err(|error| error.to_string())?;
    let aircraft = &loaded.aircraft;
    let found = arguments.session.as_ref().map(|path| computed(path, &[])).transpose()?;
    let standard = &aircraft.standard_loading;
    let loading = match found.as_ref().and_then(|(session, _)| session.loading.as_ref()) {
        // A loading without fuel states all but the fuel.
        Some(own) if own.fuel_kg.is_empty() => Loading { fuel_kg: standard.fuel_kg.clone(), ..own.clone() },
        Some(own) => own.clone(),
        None => standard.clone(),
    };
    let pair = found.as_ref().map(|(session, snapshot)| (session, snapshot));
    let planned = campaign.plan(aircraft, &loading, pair);
    let planned = planned.map_err(|error| format!("{}: {error}", arguments.campaign.display()))?;
    let flown: Vec<FlownPoint> = pair.map_or_else(Vec::new, |(session, snapshot)| flown_points(session, snapshot));
    let document = json!({ "title": campaign.title, "aircraft": aircraft.name, "points": planned, "flown": flown });
    let mut written = None;
    let mut left_out = Vec::new();
    if let Some(folder) = &arguments.out {
        let contents = serde_json::to_string_pretty(&document).map_err(|error| error.to_string())?;
        let flight = match (pair, &arguments.session) {
            (Some((session, snapshot)), Some(path)) => {
                let rebased = rebase(session, path.parent().unwrap_or(Path::new("")), folder)?;
                campaign_flight(&planned, aircraft, &rebased, snapshot).map_err(|error| error.to_string())?
            }
            _ => CampaignFlight::default(),
        };
        left_out = flight.left_out;
        let mut beside = vec![("campaign.json".to_owned(), contents.into_bytes())];
        beside.extend(flight.files);
        let formats = named(&ReportFormat::ALL, &arguments.format, |format| format.name());
        let set = DocumentSet { folder, name: "campaign", formats: &formats, beside: &beside };
        let progress = Progress::new();
        let show = |part| progress.update(part, "writing the cards");
        let laid_out = campaign_document(&campaign, aircraft, (&planned, &flown), &style);
        let put = set.write(&laid_out, "campaign", &Control::default(), &show);
        progress.finish();
        written = Some(put?);
    }
    text::json(&document)?;
    print(&planned);
    if let Some(put) = written {
        put.notes().for_each(|note| text::line(&note));
        text::line(&format!("cards in {}", put.folder.display()));
        if !left_out.is_empty() {
            text::line(&format!("the simulator does not fly card {}", left_out.join(", ")));
        }
    }
    Ok(())
}

fn print(planned: &[PlannedPoint]) {
    let cells = planned.iter().map(|point| {
        let surface = if point.surface.is_empty() { "all surfaces" } else { &point.surface };
        let margin = match (&point.nearest_limit, point.nearest_margin) {
            (Some(limit), Some(margin)) => format!("{} m/s from {limit}", number(margin, 2)),
            _ => String::new(),
        };
        vec![
            point.id.clone(),
            format!("{surface} {}", point.kind),
            number(point.airspeed_m_s, 3),
            number(point.altitude_m, 4),
            number(point.start_s / 60.0, 3),
            number(point.fuel_kg, 3),
            number(point.mass_kg, 4),
            number(point.cg_x_m, 4),
            margin,
            format!("{} of {}", point.windows.len(), point.repeats),
            point.status.name().to_owned(),
        ]
    });
    let header =
        ["card", "input", "V, m/s", "h, m", "after, min", "fuel, kg", "mass, kg", "CG, m", "margin", "runs", "flown"];
    text::table(&header, &cells.collect::<Vec<_>>());
    let count_with_status = |name: &str| planned.iter().filter(|point| point.status.name() == name).count();
    text::line(&format!(
        "{} cards flown, {} partly passed, {} to repeat, {} missing",
        count_with_status("flown"),
        count_with_status("partly passed"),
        count_with_status("repeat"),
        count_with_status("missing")
    ));
}
