//! A tour over the shipped flight: one card per step, with the real controls beside it.

use eframe::egui::{self, Align2, Key, Label, RichText, vec2};

use super::Workbench;
use crate::command::{UiCommand, ViewCommand};
use crate::notation;
use crate::panels::Pane;
use crate::step::Step;

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
        title: "Can I trust the results?",
        text: "The flight is computed. Summary shows which results you can trust: a dot is good, a triangle needs a check, a square must not be used. The lamp at the lower left shows the whole session.",
        todo: "Click the triangle below CX: the reasons appear, each with a fix.",
    },
    Stop {
        step: Step::Recording,
        pane: Pane::Flight,
        title: "The recording",
        text: "Plot any channel, in any number of plots. The strip at the top is the whole flight; its brush selects the part shown.",
        todo: "Wheel: zoom time. Drag: move. Double click: show all. Drag with the right button: zoom to a box.",
    },
    Stop {
        step: Step::Channels,
        pane: Pane::Channels,
        title: "Meaning of the channels",
        text: "Each role with its range and curve. Kinematics and air data are compared: a wrong sign or unit shows here before it biases a derivative.",
        todo: "Check columns Smallest and Largest: degrees instead of radians are obvious.",
    },
    Stop {
        step: Step::Aircraft,
        pane: Pane::Loading,
        title: "What flew",
        text: "Mass, centre of gravity and inertia follow the fuel as it is burnt. They convert accelerations to coefficients.",
        todo: "Drag a passenger to zero and watch the centre of gravity move. Ctrl+Z undoes it.",
    },
    Stop {
        step: Step::Manoeuvres,
        pane: Pane::Manoeuvres,
        title: "The manoeuvres",
        text: "Only these manoeuvres are analysed: blue for identification, amber for validation.",
        todo: "Click a manoeuvre in the strip at the top, Shift+click another and press V: all between become validation. Ctrl+Z undoes it.",
    },
    Stop {
        step: Step::Filter,
        pane: Pane::Innovations,
        title: "The flight path",
        text: "A Kalman filter combines all sensors into one flight path. Innovations inside their bands show that the noise settings are right.",
        todo: "Drag a number under 'used' in Process noise: innovations and derivatives update at once.",
    },
    Stop {
        step: Step::Model,
        pane: Pane::Fits,
        title: "The model",
        text: "Tick the terms of each coefficient. The plots compare measured and fitted coefficient; the residual is the part not modelled.",
        todo: "Untick q for Cm and watch the residual and the derivatives; tick it again.",
    },
    Stop {
        step: Step::Results,
        pane: Pane::Derivatives,
        title: "The derivatives",
        text: "Estimates with intervals, per manoeuvre and pooled, beside wind-tunnel or handbook values.",
        todo: "Choose Intervals to see which manoeuvres agree on a derivative.",
    },
    Stop {
        step: Step::Report,
        pane: Pane::Report,
        title: "The report",
        text: "Tick sections on the left for a PDF and HTML report with the verdict in front and a signature block.",
        todo: "Write report… ends the tour. New session from recording… (Ctrl+N) starts your own.",
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
        // Escape in a field belongs to the field.
        let ends = !self.typing && ctx.input(|input| input.key_pressed(Key::Escape));
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
            let todo = format!("▸ {}", stop.todo);
            ui.add(Label::new(notation::typeset_in(&todo, 12.5, ui.visuals().strong_text_color())).wrap());
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                if ui.add_enabled(at > 0, egui::Button::new("Back")).clicked() {
                    to = at.checked_sub(1);
                }
                let last = at + 1 == STOPS.len();
                if !last && ui.button("Next stop").clicked() {
                    to = Some(at + 1);
                }
                if ui.button("End the tour").clicked() || ends {
                    to = Some(STOPS.len());
                }
            });
        });
        if let Some(to) = to {
            self.go_to_stop(to);
        }
    }
}
