//! Experiments drawn over the session in the plots: dashed, each in its colour, with its name in the legend.

use doublet_core::series::Series;
use doublet_engine::run::{MOST_OVERLAID, OverlaidResults, Slot, WindowResults};
use doublet_engine::session::Session;
use eframe::egui::{Color32, Ui};

use crate::panels::PanelContext;
use crate::theme;
use crate::ui_state::UiState;
use crate::widgets::time_plot::{Trace, TraceStyle};

/// Places of their colours among those of the series: no plot with overlays draws anything else in these.
const COLORS: [usize; MOST_OVERLAID] = [3, 6];

/// An experiment that is drawn over the session.
pub struct Overlaid<'a> {
    pub name: &'a str,
    /// Colour of its curves.
    pub color: Color32,
    pub results: &'a OverlaidResults,
    stale: bool,
}

impl<'a> Overlaid<'a> {
    /// Those that are chosen and computed.
    pub fn all(ctx: &PanelContext<'a>, ui: &Ui) -> Vec<Self> {
        let slots = &ctx.snapshot.inquiries.overlaid.0;
        let chosen = names(ctx.state, ctx.session);
        let one = |(name, slot): &'a (String, Slot<OverlaidResults>)| {
            let place = chosen.iter().position(|other| other == name)?;
            let results = slot.latest()?;
            Some(Self { name, color: color(ui, place), results, stale: slot.is_stale() })
        };
        slots.iter().filter_map(one).collect()
    }

    /// Its results of a manoeuvre.
    pub fn window(&self, name: &str) -> Option<&'a WindowResults> {
        self.results.windows.get(name)
    }

    /// Its curve, in the unit that `scale` leads to.
    pub fn trace(&self, series: &'a Series, scale: f64) -> Trace<'a> {
        let style = TraceStyle::Dashed;
        Trace { scale, stale: self.stale, style, ..Trace::new(self.name, series, self.color) }
    }
}

/// Colour of the curves of the overlaid experiment at a place.
pub fn color(ui: &Ui, place: usize) -> Color32 {
    theme::palette(ui).series[COLORS[place % COLORS.len()]]
}

/// The chosen experiments that the session has.
pub fn names(state: &UiState, session: &Session) -> Vec<String> {
    let chosen = state.overlaid.iter().filter(|name| session.experiment(name).is_some());
    chosen.take(MOST_OVERLAID).cloned().collect()
}

/// Chooses an experiment, or no more; of one more than fit the first is dropped.
pub fn toggle(state: &mut UiState, session: &Session, name: &str) {
    let mut chosen = names(state, session);
    let before = chosen.len();
    chosen.retain(|other| other != name);
    if chosen.len() == before {
        chosen.push(name.to_owned());
    }
    if chosen.len() > MOST_OVERLAID {
        chosen.remove(0);
    }
    state.overlaid = chosen;
}
