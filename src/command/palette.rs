//! The palette: every command by typing part of its name.

use eframe::egui::{self, Align2, Id, Key, Modifiers, TextEdit, vec2};

use super::ui_command::{CommandInfo, UiCommand};

/// Rows shown at most.
const ROWS: usize = 12;

/// The palette's state; closed to begin with.
#[derive(Debug, Default)]
pub struct CommandPalette {
    open: bool,
    just_opened: bool,
    typed: String,
    chosen: usize,
}

/// Rows of `table` whose name holds every word of `typed`, those that begin with it first.
pub fn matching<'a>(table: &'a [CommandInfo], typed: &str) -> Vec<&'a CommandInfo> {
    let typed = typed.trim().to_lowercase();
    let holds = |row: &&CommandInfo| {
        let name = row.name.to_lowercase();
        typed.split_whitespace().all(|word| name.contains(word) || means(&row.name, word))
    };
    let mut found: Vec<_> = table.iter().filter(holds).collect();
    // Names with words that begin so come before those that only mean it, and both before `board` in `keyboard`.
    found.sort_by_key(|row| {
        let name = row.name.to_lowercase();
        let begins = |word: &str| name.split_whitespace().any(|own| own.starts_with(word));
        let is_named = typed.split_whitespace().all(begins);
        let is_meant = typed.split_whitespace().all(|word| begins(word) || means(&row.name, word));
        (!name.starts_with(&typed), !is_named, !is_meant)
    });
    found
}

/// Other words for what a command is about, by its name.
const MEANINGS: [(&str, &str); 34] = [
    ("Summary", "verdict believe trust good bad caution"),
    ("Channels", "sensors units signs roles physics check mapping"),
    ("Flight", "recording time history overview plot"),
    ("Ground track", "map position path gps"),
    ("Cross plot", "xy scatter hysteresis"),
    ("Manoeuvres", "windows doublet 3211 segments cut select"),
    ("Gallery", "thumbnails side by side overlay onset"),
    ("Manoeuvre map", "scatter lasso select candidates speed altitude alpha cg nis r2 excitation"),
    ("Preprocess", "smoothing filter resample clock sync lag steady spectrum"),
    ("Sensors", "calibration slope drum pulley pedal yoke pod probes fit instruments"),
    ("Noise and filter", "kalman ekf iekf ukf covariance tuning q r"),
    ("Reconstruction", "states path smoother attitude velocity wind bias fpr"),
    ("Innovations", "nis residual whiteness consistency"),
    ("Model", "aic bic pse terms structure regressors stepwise polynomial coefficients"),
    ("Derivatives", "compare aic bic pse board stability control estimates intervals table reference"),
    ("Experiments", "compare filters structures configurations keep variants overlay board"),
    ("Fits and residuals", "compare contributions prediction validation information r2"),
    ("Match", "proof part 60 simulator tolerance qtg"),
    ("3-D replay", "attitude play animation compass velocity wind fly film"),
    ("Propulsion", "engine thrust power propeller rpm"),
    ("Correlation", "collinearity condition regressors parameters matrix"),
    ("Studies", "monte carlo compare regression output error checks leave one out altitude airspeed"),
    ("Sensitivity", "tornado partial variation"),
    ("Frequency response", "bode coherence equivalent loes"),
    ("Modes and levels", "short period phugoid dutch roll spiral eigenvalues flying qualities mil"),
    (
        "Airframe",
        "edit aircraft editor groups tanks places sensors drag geometry weighing scales wheels stations side view top view",
    ),
    ("Qualification", "qtg tests part 60 simulator guide tolerance"),
    ("Prior", "datcom earlier estimate bayes posterior conflict"),
    ("Enough", "goals information next manoeuvre standard errors"),
    ("Design", "input multisine optimal 3211 next flight card excursions"),
    ("Loading", "fuel inertia mass cg centre gravity seats luggage envelope weight balance"),
    ("Report", "pdf html print sign document"),
    ("Save aircraft as…", "edited aircraft file"),
    ("Export model…", "jsbsim fmu dave-ml simulator simulink"),
];

/// Whether a command called `name` is about `word`.
fn means(name: &str, word: &str) -> bool {
    let is_meant = |(known, words): &(&str, &str)| *known == name && words.split(' ').any(|one| one.starts_with(word));
    word.len() > 1 && MEANINGS.iter().any(is_meant)
}

impl CommandPalette {
    /// Opens it, empty.
    pub fn open(&mut self) {
        *self = Self { open: true, just_opened: true, ..Self::default() };
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Draws it while it is open; the command that was chosen.
    pub fn show(&mut self, ctx: &egui::Context, table: &[CommandInfo]) -> Option<UiCommand> {
        if !self.open {
            return None;
        }
        let (up, down, enter, escape) = ctx.input_mut(|input| {
            let mut key = |key| input.consume_key(Modifiers::NONE, key);
            (key(Key::ArrowUp), key(Key::ArrowDown), key(Key::Enter), key(Key::Escape))
        });
        let mut picked = None;
        let area = egui::Window::new("Commands")
            .id(Id::unique("command palette"))
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, vec2(0.0, 80.0))
            .fixed_size(vec2(460.0, 0.0))
            .show(ctx, |ui| {
                let hint = "Type part of a command";
                let entry = TextEdit::singleline(&mut self.typed).hint_text(hint).desired_width(f32::INFINITY);
                let entry = ui.add(entry);
                ui.ctx().accesskit_node_builder(entry.id, |node| node.set_label("Command"));
                entry.request_focus();
                if entry.changed() {
                    self.chosen = 0;
                }
                let found = matching(table, &self.typed);
                let last = found.len().min(ROWS).saturating_sub(1);
                self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up)).min(last);
                if found.is_empty() {
                    ui.weak("No command found.");
                }
                for (at, row) in found.into_iter().take(ROWS).enumerate() {
                    let shortcut = row.keys(ui.ctx());
                    let button = egui::Button::selectable(at == self.chosen, &row.name).shortcut_text(shortcut);
                    let response = ui.add_sized([ui.available_width(), 24.0], button);
                    if response.clicked() || (enter && at == self.chosen) {
                        picked = Some(row.command);
                    }
                }
            });
        let elsewhere = !self.just_opened && area.is_some_and(|area| area.response.clicked_elsewhere());
        self.just_opened = false;
        if picked.is_some() || escape || elsewhere {
            self.open = false;
        }
        picked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::ui_command::table;

    #[test]
    fn words_match_in_any_order_and_a_beginning_comes_first() {
        let table = table();
        assert_eq!(matching(&table, "").len(), table.len());
        assert_eq!(matching(&table, "back zoom")[0].name, "Zoom back");
        assert!(matching(&table, "no such thing").is_empty());
        for (typed, first) in [
            ("inertia", "Loading"),
            ("engine", "Propulsion"),
            ("fuel", "Loading"),
            ("compare", "Derivatives"),
            ("kalman", "Noise and filter"),
            ("weighing", "Airframe"),
            ("model", "Model"),
            ("AIC", "Model"),
            ("board", "Derivatives"),
        ] {
            assert_eq!(matching(&table, typed)[0].name, first, "{typed}");
        }
        assert!(MEANINGS.iter().all(|(name, _)| table.iter().any(|row| row.name == *name)), "each is a command");
        assert!(matching(&table, "zoom")[0].name.starts_with("Zoom"));
    }
}
