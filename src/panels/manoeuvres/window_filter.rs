//! Which windows the table shows, and in which order.

use std::cmp::Ordering;

use doublet_engine::session::{Manoeuvre, WindowRole};
use doublet_engine::verdict::Level;
use eframe::egui::{ComboBox, Response, Sense, TextEdit, Ui};

use crate::panels::{PanelContext, windows_by_time};
use crate::widgets::term::column_title_called;

/// What the table is ordered by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Flights as the session has them, manoeuvres of each by their start.
    #[default]
    Time,
    /// Names, by letters.
    Name,
    Start,
    End,
    Use,
    /// The surface moved.
    Surface,
    /// Their verdict, the worst first.
    Verdict,
}

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WindowFilter {
    words: String,
    kind: Option<String>,
    role: Option<WindowRole>,
    level: Option<Level>,
    order: Order,
    reversed: bool,
}

/// The verdict on a window.
pub fn level(ctx: &PanelContext<'_>, window: &Manoeuvre) -> Option<Level> {
    let verdicts = ctx.snapshot.verdicts.latest()?;
    verdicts.windows.get(&window.name).map(|judged| judged.verdict.level)
}

impl WindowFilter {
    /// The windows it lets through, in its order.
    pub fn windows<'a>(&self, ctx: &PanelContext<'a>) -> Vec<&'a Manoeuvre> {
        let words = self.words.to_lowercase();
        let mut windows = windows_by_time(ctx.session);
        windows.retain(|window| self.holds(ctx, &words, window));
        windows.sort_by(|a, b| self.compare(ctx, a, b));
        if self.reversed {
            windows.reverse();
        }
        windows
    }

    /// Whether it lets a manoeuvre through; `words` in lower case.
    fn holds(&self, ctx: &PanelContext<'_>, words: &str, window: &Manoeuvre) -> bool {
        let text = format!("{} {} {} {}", window.name, window.kind, window.note, window.flight).to_lowercase();
        words.split_whitespace().all(|word| text.contains(word))
            && self.kind.as_ref().is_none_or(|kind| *kind == window.kind)
            && self.role.is_none_or(|role| role == window.role)
            && self.level.is_none_or(|wanted| level(ctx, window) == Some(wanted))
    }

    fn compare(&self, ctx: &PanelContext<'_>, a: &Manoeuvre, b: &Manoeuvre) -> Ordering {
        match self.order {
            Order::Time => Ordering::Equal,
            Order::Name => a.name.to_lowercase().cmp(&b.name.to_lowercase()),
            Order::Start => a.flight.cmp(&b.flight).then(a.window.start_s.total_cmp(&b.window.start_s)),
            Order::End => a.flight.cmp(&b.flight).then(a.window.end_s.total_cmp(&b.window.end_s)),
            Order::Use => a.role.name().cmp(b.role.name()),
            Order::Surface => a.surface.map(|surface| surface.name()).cmp(&b.surface.map(|surface| surface.name())),
            Order::Verdict => level(ctx, b).cmp(&level(ctx, a)),
        }
    }

    /// Whether it leaves any out.
    pub fn is_set(&self) -> bool {
        !self.words.trim().is_empty() || self.kind.is_some() || self.role.is_some() || self.level.is_some()
    }

    /// Draws what is asked for, in a row.
    pub fn show(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui) {
        let mut kinds: Vec<&str> = ctx.session.windows.iter().map(|window| window.kind.as_str()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds.retain(|kind| !kind.is_empty());
        let field = ui.add(TextEdit::singleline(&mut self.words).hint_text("Filter").desired_width(96.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("filter manoeuvres"));
        let kinds = kinds.into_iter().map(|kind| (kind.to_owned(), kind.to_owned()));
        choice(ui, ("type", "any type"), &mut self.kind, kinds);
        choice(ui, ("use", "any use"), &mut self.role, WindowRole::ALL.map(|role| (role, role.name().to_owned())));
        let levels = [Level::Bad, Level::Caution, Level::Good].map(|level| (level, level.name().to_owned()));
        choice(ui, ("verdict", "any verdict"), &mut self.level, levels);
        let worst = ui.selectable_label(self.order == Order::Verdict, "worst first");
        if worst.on_hover_text("Sort by verdict").clicked() {
            self.order = if self.order == Order::Verdict { Order::Time } else { Order::Verdict };
            self.reversed = false;
        }
        if self.is_set() && ui.small_button("✖").on_hover_text("Show all manoeuvres").clicked() {
            *self = Self { order: self.order, reversed: self.reversed, ..Self::default() };
        }
    }

    /// The title of a column that orders the windows: a click by it, a second the other way, a third as before.
    pub fn title(&mut self, ui: &mut Ui, title: &str, order: Order) -> Response {
        let mark = match (self.order == order, self.reversed) {
            (true, false) => " ▲",
            (true, true) => " ▼",
            (false, _) => "",
        };
        let label = column_title_called(ui, &format!("{title}{mark}"), title).interact(Sense::click());
        if label.clicked() {
            (self.order, self.reversed) = match (self.order == order, self.reversed) {
                (true, false) => (order, true),
                (true, true) => (Order::Time, false),
                (false, _) => (order, false),
            };
        }
        label
    }
}

/// A list of choices of which none may be taken.
fn choice<T: Clone + PartialEq>(
    ui: &mut Ui,
    (name, any): (&str, &str),
    chosen: &mut Option<T>,
    all: impl IntoIterator<Item = (T, String)>,
) {
    let all: Vec<(T, String)> = all.into_iter().collect();
    let shown = all.iter().find(|(value, _)| Some(value) == chosen.as_ref()).map_or(any, |(_, text)| text);
    let combo = ComboBox::from_id_salt(("filter of manoeuvres", name)).selected_text(shown).width(92.0);
    let combo = combo.show_ui(ui, |ui| {
        ui.selectable_value(chosen, None, any);
        for (value, text) in all.iter().cloned() {
            ui.selectable_value(chosen, Some(value), text);
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("{name} of manoeuvres shown")));
}
