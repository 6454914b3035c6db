//! A tour over the shipped flight: one card per step, with the real controls beside it.

use eframe::egui::{self, Align2, Key, Label, RichText, vec2};

use super::Workbench;
use crate::command::{UiCommand, ViewCommand};
use crate::layouts::Step;
use crate::panels::Pane;

/// Where the tour stops.
struct Stop {
    step: Step,
    pane: Pane,
    title: &'static str,
    text: &'static str,
    todo: &'static str,
}

const STOPS: [Stop; 9] = [
    Stop {
        step: Step::Results,
        pane: Pane::Summary,
        title: "Can I believe this?",
        text: "Every number of this flight has been computed by now. The summary says which of them may be used: a dot is good, a \
               triangle wants a look, a square must not be used. The lamp at the lower left says the same of the whole session.",
        todo: "Click the triangle below CX: the reasons stand beside it, each with what cures it.",
    },
    Stop {
        step: Step::Recording,
        pane: Pane::Flight,
        title: "The recording",
        text: "Any channel, in as many plots as you like. The strip at the top is the whole flight; its brush is what the plots show.",
        todo: "Turn the wheel over a plot to zoom time, drag to move along, double click to see all again. Drag with the right \
               button for a box.",
    },
    Stop {
        step: Step::Channels,
        pane: Pane::Channels,
        title: "What the channels mean",
        text: "Each role with its range and its curve. Kinematics and air data are held against each other: a wrong sign or unit \
               shows here before it spoils a derivative.",
        todo: "Look at the column of ranges: degrees that should be radians are seen at once.",
    },
    Stop {
        step: Step::Aircraft,
        pane: Pane::Loading,
        title: "What flew",
        text: "Mass, centre of gravity and inertia follow the fuel as it is burnt. They turn accelerations into coefficients.",
        todo: "Drag the seat of a passenger to zero and watch the centre of gravity move. Ctrl+Z takes it back.",
    },
    Stop {
        step: Step::Manoeuvres,
        pane: Pane::Manoeuvres,
        title: "The manoeuvres",
        text: "Only these windows enter the analysis: blue ones identify, amber ones are kept to check the model against.",
        todo: "Click a window in the strip at the top; Shift+click another and press V: all between them turn into validation. \
               Ctrl+Z takes it back in one step.",
    },
    Stop {
        step: Step::Filter,
        pane: Pane::Innovations,
        title: "The flight path",
        text: "A Kalman filter makes one consistent path of all sensors. Innovations inside their bands mean that the noise it was told \
               is the noise there is.",
        todo: "Drag a number in the column of Q: innovations and derivatives follow within a blink.",
    },
    Stop {
        step: Step::Model,
        pane: Pane::Fits,
        title: "The model",
        text: "Ticks choose the terms of each coefficient. Measured and fitted coefficient are drawn over their residual: what is left \
               there is what the model does not know.",
        todo: "Untick q for Cm and watch the residual and the derivatives; tick it again.",
    },
    Stop {
        step: Step::Results,
        pane: Pane::Derivatives,
        title: "The derivatives",
        text: "Estimates with their intervals, window by window and together, beside what the wind tunnel or the handbook says.",
        todo: "Choose Intervals to see which windows agree on a derivative.",
    },
    Stop {
        step: Step::Report,
        pane: Pane::Report,
        title: "The report",
        text: "What you tick on the left becomes a PDF and a page for the browser, with the verdict in front and a block to sign.",
        todo: "Write report… ends the tour where a real analysis ends. New session from recording… (Ctrl+N) begins yours.",
    },
];

impl Workbench {
    /// Begins the tour at its first stop.
    pub(super) fn begin_tour(&mut self) {
        self.go_to_stop(0);
    }

    fn go_to_stop(&mut self, at: usize) {
        let Some(stop) = STOPS.get(at) else {
            self.tour = None;
            return;
        };
        self.tour = Some(at);
        self.commands.push(UiCommand::View(ViewCommand::Step(stop.step)));
        self.commands.push(UiCommand::View(ViewCommand::Show(stop.pane)));
    }

    /// Whether the tour is on, and at which stop.
    pub fn tour_stop(&self) -> Option<usize> {
        self.tour
    }

    /// Draws the card of the present stop.
    pub(super) fn show_tour(&mut self, ctx: &egui::Context) {
        let Some((at, stop)) = self.tour.and_then(|at| Some((at, STOPS.get(at)?))) else { return };
        let mut to = None;
        let window = egui::Window::new("Tour")
            .id(egui::Id::unique("tour"))
            .title_bar(false)
            .resizable(false)
            .default_size(vec2(360.0, 0.0))
            .max_width(360.0)
            .anchor(Align2::RIGHT_BOTTOM, vec2(-18.0, -44.0));
        window.show(ctx, |ui| {
            ui.set_width(340.0);
            ui.label(RichText::new(format!("{} of {}", at + 1, STOPS.len())).size(11.0).weak());
            ui.heading(stop.title);
            ui.add(Label::new(stop.text).wrap());
            ui.add_space(4.0);
            ui.add(Label::new(RichText::new(format!("▸ {}", stop.todo)).strong()).wrap());
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                if ui.add_enabled(at > 0, egui::Button::new("Back")).clicked() {
                    to = at.checked_sub(1);
                }
                let last = at + 1 == STOPS.len();
                if !last && ui.button("Next stop").clicked() {
                    to = Some(at + 1);
                }
                if ui.button("End the tour").clicked() || ui.input(|input| input.key_pressed(Key::Escape)) {
                    to = Some(STOPS.len());
                }
            });
        });
        if let Some(to) = to {
            self.go_to_stop(to);
        }
    }
}
