//! Channels against each other as the chosen map reads them: what contradicts, and its fix as one click.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::load::{ManualChannelMap, Plan};
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Statistics, TimeRange};
use doublet_engine::begin::{self, Inspected};
use doublet_engine::confidence::{WeighedRole, weigh};
use doublet_engine::run::{Control, Job};
use doublet_engine::session::ClockSetting;
use doublet_engine::stage::FlightPhysics;
use doublet_engine::verdict::Level;
use eframe::egui::{self, Sense, Spinner, Ui, vec2};

use super::{Choice, Choosing};
use crate::theme;
use crate::widgets::curves::draw_contradiction;
use crate::widgets::level_mark::level_mark;
use crate::widgets::sparkline::Sparkline;

/// Width and points of the shape of a channel.
const SHAPE: f32 = 84.0;
const POINTS: usize = 56;

/// What the channels say of each other by the map as it is, compared in the background.
#[derive(Default)]
pub struct Comparison {
    of: Option<(Choice, ManualChannelMap, Arc<Inspected>)>,
    job: Option<Job<(Recording, FlightPhysics, Vec<ClockSetting>)>>,
    found: FlightPhysics,
    /// Clocks of recorders that are off, with the channels they are fitted to.
    pub(super) clocks: Vec<ClockSetting>,
    weighed: Vec<WeighedRole>,
    shapes: BTreeMap<Role, Shape>,
}

/// What the map reads of one role.
pub(super) struct Shape {
    /// Over the whole recording.
    line: Sparkline,
    /// Smallest, largest and others, SI; none without a finite sample.
    statistics: Option<Statistics>,
}

impl Shape {
    /// Draws it in a cell of a table.
    pub(super) fn show(&self, ui: &mut Ui, role: Role) {
        let (rect, response) = ui.allocate_exact_size(vec2(SHAPE, 18.0), Sense::hover());
        self.line.paint(ui, rect.shrink2(vec2(1.0, 2.0)), theme::palette(ui).series[0]);
        let name = format!("shape of {}", role.name());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &name));
    }

    /// Smallest and largest value in SI.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        self.statistics.map(|found| [found.min, found.max])
    }
}

impl Comparison {
    /// Takes in what was found, and compares again where the map has changed.
    fn follow(
        &mut self,
        (choice, hand, inspected): (Choice, &ManualChannelMap, &Arc<Inspected>),
        plan: Option<&Plan>,
        ctx: &egui::Context,
    ) {
        if let Some(job) = self.job.take_if(|job| job.is_finished()) {
            let (recording, found, clocks) = job.finish().unwrap_or_default();
            self.shapes = shapes(&recording);
            self.weighed = weigh(&inspected.probes, hand, Some(&found));
            (self.found, self.clocks) = (found, clocks);
        }
        let is_same = self
            .of
            .as_ref()
            .is_some_and(|(of, map, looked_at)| *of == choice && map == hand && Arc::ptr_eq(looked_at, inspected));
        // A value being dragged is compared once it is let go.
        if is_same || ctx.input(|input| input.pointer.any_down()) {
            return;
        }
        self.of = Some((choice, hand.clone(), Arc::clone(inspected)));
        self.stop();
        let Some(plan) = plan.filter(|plan| !plan.has_errors() && !plan.roles.is_empty()).cloned() else {
            self.found = FlightPhysics::default();
            self.weighed = weigh(&inspected.probes, hand, None);
            self.shapes.clear();
            return;
        };
        let (wake, inspected) = (ctx.clone(), Arc::clone(inspected));
        let work = move |_: &Control, _: &(dyn Fn(f32) + Sync)| begin::read_and_compare(&inspected, &plan);
        self.job = Job::start("doublet-compare", move || wake.request_repaint(), work).ok();
    }

    /// What the map reads of `role`, once it has been read.
    pub(super) fn shape(&self, role: Role) -> Option<&Shape> {
        self.shapes.get(&role)
    }

    /// What the other channels say of that of `role`: the worst level, and the rows with it.
    pub(super) fn level(&self, role: Role) -> Option<Level> {
        self.found.rows.iter().filter(|row| row.channel == role.name()).map(|row| row.level).max()
    }

    /// Confidence, evidence and runner-up of the row of `role`, once the channels are compared.
    pub(super) fn weighed(&self, role: Role) -> Option<&WeighedRole> {
        self.weighed.iter().find(|row| row.role == role)
    }

    fn stop(&mut self) {
        if let Some(job) = self.job.take() {
            job.abandon();
        }
    }
}

impl Drop for Comparison {
    fn drop(&mut self) {
        self.stop();
    }
}

fn shapes(recording: &Recording) -> BTreeMap<Role, Shape> {
    let whole = TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY };
    let shape = |(role, index): (&Role, &usize)| {
        let series = &recording.channels.get(*index)?.series;
        Some((*role, Shape { line: Sparkline::new(series, POINTS), statistics: series.statistics(whole) }))
    };
    recording.roles.iter().filter_map(shape).collect()
}

impl Comparison {
    /// The worst contradiction.
    pub(super) fn worst(&self) -> Level {
        self.found.contradictions().map(|row| row.level).max().unwrap_or_default()
    }
}

/// Compares the channels in the background where the map has changed, whatever page is on screen.
pub(super) fn follow(choosing: &mut Choosing, ctx: &egui::Context) {
    let mut comparison = std::mem::take(&mut choosing.comparison);
    let map = (choosing.choice, &choosing.hand, &choosing.inspected);
    comparison.follow(map, choosing.plan().ok(), ctx);
    if comparison.job.is_some() {
        ctx.request_repaint_after(std::time::Duration::from_millis(50));
    }
    choosing.comparison = comparison;
}

/// Lists what contradicts; a click applies the fix to the map made by hand.
pub(super) fn show(choosing: &mut Choosing, ui: &mut Ui) {
    let comparison = &choosing.comparison;
    let by_hand = choosing.choice == Choice::ByHand;
    let mut applied = None;
    if comparison.job.is_some() {
        ui.horizontal(|ui| {
            ui.add(Spinner::new().size(12.0));
            ui.weak("Comparing the channels with each other");
        });
    } else if comparison.found.contradictions().next().is_none() {
        let is_compared = !comparison.found.rows.is_empty();
        ui.weak(if is_compared { "All channels are consistent." } else { "No channels could be compared." });
    }
    for (at, row) in comparison.found.contradictions().enumerate() {
        ui.horizontal_top(|ui| {
            level_mark(ui, Some(row.level));
            let fix = row.change.as_ref().filter(|fix| by_hand && fix.is_of_map());
            if let Some(fix) = fix {
                let button = ui.small_button("Apply").on_hover_text(&row.fix_text);
                ui.ctx().accesskit_node_builder(button.id, |node| {
                    node.set_label(format!("apply the fix of {}", row.channel));
                });
                if button.clicked() {
                    applied = Some(fix.clone());
                }
            }
            draw_contradiction(ui, at, row, |_| {});
        });
    }
    if let Some(fix) = applied {
        choosing.hand = begin::apply_fix(&choosing.hand, &fix, &choosing.inspected.probes);
        choosing.plan_again();
    }
}
