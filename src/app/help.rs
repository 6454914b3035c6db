//! The manual in a window of its own: the page of what the pointer is on, the glossary, and a search over both.

use std::path::Path;

use doublet_cli::{glossary, manual};
use eframe::egui::{self, Label, RichText, ScrollArea, TextEdit, Ui};
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};

use super::Workbench;
use crate::panels::Pane;

/// Size of the window at first.
const SIZE: [f32; 2] = [760.0, 600.0];
/// Lines of a search shown at most.
const MOST_LINES: usize = 80;

/// What is looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Topic {
    /// The contents of the manual.
    Contents,
    /// A page, from this heading on where one is named.
    Page(String, Option<String>),
    /// A panel, with the page that says more.
    Panel(Pane),
    /// A word of the glossary.
    Term(String),
    /// Which doublet this is.
    About,
}

#[derive(Default)]
pub struct Help {
    shown: Option<Shown>,
    before: Vec<Topic>,
    typed: String,
    cache: CommonMarkCache,
}

/// A topic with its text.
struct Shown {
    topic: Topic,
    text: String,
    links: Vec<String>,
}

impl Shown {
    fn new(topic: Topic) -> Self {
        let text = drawable(&topic.text());
        let links = links(&text).map(str::to_owned).collect();
        Self { topic, text, links }
    }
}

impl Topic {
    /// Its text, Markdown.
    fn text(&self) -> String {
        match self {
            Self::Contents => manual::contents().replacen("# Summary", "# Contents", 1),
            Self::About => format!(
                "# doublet\n\nAircraft system identification from flight test.\n\n- Version {}\n- Licence MIT or Apache-2.0, as you choose\n\n\
                 Works offline: no recording leaves this machine.\n",
                doublet_cli::version()
            ),
            Self::Page(topic, heading) => {
                let whole = page(topic);
                let from = heading.as_deref().and_then(|heading| section(&whole, heading));
                from.map(str::to_owned).unwrap_or(whole)
            }
            Self::Panel(pane) => {
                let panels = page("panels");
                let about = section(&panels, &slug(pane.title())).unwrap_or_default();
                let about = about.split("\n## ").next().unwrap_or_default();
                format!("{about}\n\n---\n\n{}", page(pane.manual_page()))
            }
            Self::Term(word) => match glossary::find(word) {
                Some(entry) => {
                    let facts: String = entry.facts().map(|(name, text)| format!("- **{name}**: `{text}`\n")).collect();
                    let also = if entry.also.is_empty() {
                        String::new()
                    } else {
                        format!("Also: {}.\n\n", entry.also.join(", "))
                    };
                    format!("# {}\n\n{also}{}\n\n{facts}\n[The whole glossary](glossary.md)\n", entry.word, entry.what)
                }
                None => format!("'{word}' is not in the glossary. [The whole glossary](glossary.md)\n"),
            },
        }
    }
}

/// The page called `topic`, empty where there is none.
fn page(topic: &str) -> String {
    manual::pages().into_iter().find(|page| page.topic == topic).map(|page| page.text.to_owned()).unwrap_or_default()
}

/// What a link calls a heading: small letters, a hyphen for a space, nothing else.
fn slug(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '-' | '_')).collect()
}

/// `whole` from the heading that a link calls `anchor`.
fn section<'a>(whole: &'a str, anchor: &str) -> Option<&'a str> {
    let mut at = 0;
    for line in whole.split_inclusive('\n') {
        if line.starts_with('#') && slug(line.trim_start_matches('#').trim()) == anchor {
            return Some(&whole[at..]);
        }
        at += line.len();
    }
    None
}

/// The text as the window can draw it: without pictures.
fn drawable(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("!["));
    lines.collect::<Vec<_>>().join("\n")
}

/// Where the links of `text` lead inside the manual.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let to = text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(to, _)| to));
    to.filter(|to| !to.contains("://"))
}

/// The topic a link leads to, where it stays inside the manual.
fn destination(link: &str) -> Option<Topic> {
    let (file, heading) = link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading.to_owned())));
    let topic = Path::new(file).file_stem()?.to_str()?;
    manual::pages().iter().any(|page| page.topic == topic).then(|| Topic::Page(topic.to_owned(), heading))
}

impl Help {
    /// Shows a topic; the one before is kept to go back to.
    pub fn open(&mut self, topic: Topic) {
        self.typed.clear();
        if let Some(shown) = self.shown.replace(Shown::new(topic)) {
            self.before.push(shown.topic);
        }
    }

    /// What is shown.
    pub fn topic(&self) -> Option<&Topic> {
        self.shown.as_ref().map(|shown| &shown.topic)
    }

    /// Closes the window; whether it was open.
    pub fn close(&mut self) -> bool {
        self.before.clear();
        self.shown.take().is_some()
    }

    /// Draws it while it is open.
    fn show(&mut self, ctx: &egui::Context) {
        if self.shown.is_none() {
            return;
        }
        let (mut open, mut next) = (true, None);
        let middle = ctx.content_rect().center() - 0.5 * egui::Vec2::from(SIZE);
        egui::Window::new("Help")
            .open(&mut open)
            .default_pos(middle)
            .default_size(SIZE)
            .min_size([420.0, 260.0])
            .collapsible(false)
            .show(ctx, |ui| {
                self.head(ui, &mut next);
                ui.separator();
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    if self.typed.trim().is_empty() {
                        self.body(ui, &mut next);
                    } else {
                        found(self.typed.trim(), ui, &mut next);
                    }
                });
            });
        if !open {
            self.close();
        } else if let Some(topic) = next {
            self.open(topic);
        }
    }

    /// Ways around, and the field of the search.
    fn head(&mut self, ui: &mut Ui, next: &mut Option<Topic>) {
        ui.horizontal(|ui| {
            if ui.add_enabled(!self.before.is_empty(), egui::Button::new("◀")).on_hover_text("Back").clicked()
                && let Some(before) = self.before.pop()
            {
                self.shown = Some(Shown::new(before));
                self.typed.clear();
            }
            if ui.button("Contents").clicked() {
                *next = Some(Topic::Contents);
            }
            if ui.button("Glossary").clicked() {
                *next = Some(Topic::Page("glossary".to_owned(), None));
            }
            let field = TextEdit::singleline(&mut self.typed).hint_text("Search the manual");
            let field = ui.add(field.desired_width(f32::INFINITY));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("search the manual"));
        });
    }

    fn body(&mut self, ui: &mut Ui, next: &mut Option<Topic>) {
        let Some(shown) = &self.shown else { return };
        for link in &shown.links {
            self.cache.add_link_hook(link);
        }
        CommonMarkViewer::new().show(ui, &mut self.cache, &shown.text);
        let followed = shown.links.iter().find(|link| self.cache.get_link_hook(link) == Some(true));
        if let Some(topic) = followed.and_then(|link| destination(link)) {
            *next = Some(topic);
        }
    }
}

/// Words of the glossary and lines of the manual that hold `sought`.
fn found(sought: &str, ui: &mut Ui, next: &mut Option<Topic>) {
    let lowered = sought.to_lowercase();
    let holds = |form: &str| form.to_lowercase().contains(&lowered);
    let by_letters = glossary::entries().iter().filter(|entry| entry.forms().any(holds));
    let mut words = glossary::look_up(sought);
    for entry in by_letters {
        if !words.contains(&entry) {
            words.push(entry);
        }
    }
    words.truncate(MOST_LINES);
    let mut count = 0;
    for entry in words {
        count += 1;
        ui.horizontal(|ui| {
            if ui.link(&entry.word).clicked() {
                *next = Some(Topic::Term(entry.word.clone()));
            }
            ui.add(Label::new(RichText::new(&entry.what).weak()).truncate());
        });
    }
    let lines = manual::find_lines(sought);
    for line in lines.iter().take(MOST_LINES) {
        count += 1;
        ui.horizontal(|ui| {
            if ui.link(line.topic).clicked() {
                *next = Some(Topic::Page(line.topic.to_owned(), line.heading.map(slug)));
            }
            ui.add(Label::new(RichText::new(line.text).weak()).truncate());
        });
    }
    if count == 0 {
        ui.weak("Not found in the manual: try one word.");
    }
}

impl Workbench {
    /// Opens the manual at what is under the pointer: the word, else the panel, else its contents.
    pub fn help_here(&mut self, ctx: &egui::Context) {
        let term = crate::widgets::term::hovered(ctx).map(|word| Topic::Term(word.to_owned()));
        let topic = term.or(self.pointed.map(Topic::Panel)).unwrap_or(Topic::Contents);
        self.help.open(topic);
    }

    /// Draws the manual while it is open.
    pub(super) fn show_help(&mut self, ctx: &egui::Context) {
        self.help.show(ctx);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_its_section_and_a_page_that_says_more() {
        for &pane in Pane::ALL {
            let text = Topic::Panel(pane).text();
            assert!(text.starts_with(&format!("## {}\n", pane.title())), "{}: {text:.80}", pane.title());
            let more = text.split_once("\n---\n").map(|(_, more)| more.trim()).unwrap_or_default();
            assert!(more.starts_with("# ") && more.len() > 400, "{}", pane.title());
        }
    }

    #[test]
    fn links_of_the_contents_lead_to_pages_and_those_to_a_heading_to_its_section() {
        let contents = Topic::Contents.text();
        let all: Vec<&str> = links(&contents).collect();
        assert!(all.len() > 25, "{all:?}");
        for link in all {
            let topic = destination(link).unwrap_or_else(|| panic!("{link}"));
            assert!(topic.text().starts_with('#'), "{link}");
        }
        let verdict = destination("results.md#verdict").expect("it is a page");
        assert!(verdict.text().to_lowercase().starts_with("## verdict\n"), "{:.60}", verdict.text());
    }
}
