//! Help where the pointer is: words of the glossary, pages of panels, the search over both.

use doublet::app::help::Topic;
use doublet::panels::Pane;
use doublet::ui_state::Scope;
use doublet_cli::glossary;
use egui::accesskit::Role;
use egui::{Key, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::click;
use crate::picture;
use crate::workbench::Bench;

/// Titles of columns on screen, with whether a pause over them explains them.
fn titles(bench: &Bench<'_>) -> Vec<(String, bool)> {
    let nodes = bench.harness.query_all_by_role(Role::ColumnHeader).collect::<Vec<_>>();
    let of = |node: &egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        let title = node.value().or_else(|| node.label()).unwrap_or_default();
        (title, node.description().is_some_and(|text| text.len() > 10))
    };
    nodes.iter().map(of).collect()
}

/// Titles on screen that nothing explains.
pub fn unexplained(bench: &Bench<'_>) -> Vec<String> {
    titles(bench).into_iter().filter(|(_, explained)| !explained).map(|(title, _)| title).collect()
}

#[test]
fn formulas_of_a_page_are_shown_in_letters() {
    let mut bench = Bench::open();
    bench.harness.state_mut().help.open(Topic::Page("method_path".to_owned(), None));
    bench.harness.run_steps(4);
    picture(&mut bench.harness, "help_formulas");
    let shown = bench.harness.query_all_by_label_contains("= a_x \u{2212} b_ax \u{2212} g sin θ").count();
    assert!(shown > 0, "the first equation of motion is there");
    assert_eq!(bench.harness.query_all_by_label_contains("\\").count(), 0, "no TeX is left");
}

#[test]
fn every_title_of_a_column_has_its_entry_in_the_glossary() {
    let mut bench = Bench::shipped();
    let (mut seen, mut without) = (0, Vec::new());
    let mut look = |bench: &Bench<'_>, place: &str| {
        for (title, explained) in titles(bench) {
            seen += 1;
            if !explained {
                without.push(format!("{place}: '{title}'"));
            }
        }
    };
    for &pane in Pane::ALL.iter().filter(|pane| !matches!(pane, Pane::Live | Pane::Studies)) {
        bench.show(pane);
        look(&bench, pane.title());
    }
    bench.show(Pane::Derivatives);
    for scope in [Scope::Chosen, Scope::Over] {
        bench.harness.state_mut().state.selection.scope = scope;
        bench.settle();
        look(&bench, "Derivatives");
    }
    without.sort_unstable();
    without.dedup();
    assert!(without.is_empty(), "no entry for {without:#?}");
    assert!(seen > 80, "titles were seen: {seen}");
}

#[test]
fn f1_on_a_title_opens_its_word_on_a_panel_its_page_and_escape_closes_the_manual() {
    let mut bench = Bench::open();
    bench.show(Pane::Derivatives);
    let title = |bench: &Bench<'_>| {
        let nodes = bench.harness.get_all_by_role(Role::ColumnHeader).collect::<Vec<_>>();
        let of_corrected = nodes.iter().find(|node| {
            let node = node.accesskit_node();
            node.value().or_else(|| node.label()).as_deref() == Some("Corrected")
        });
        of_corrected.expect("the table has that column").rect()
    };
    let at = title(&bench).center();
    let press_f1 = |bench: &mut Bench<'_>, at| {
        bench.harness.hover_at(at);
        bench.harness.run_steps(3);
        bench.harness.key_press(Key::F1);
        bench.harness.run_steps(4);
    };
    press_f1(&mut bench, at);
    assert_eq!(bench.harness.state().help.topic(), Some(&Topic::Term("Corrected".to_owned())));
    assert!(bench.harness.query_by_label_contains("(Morelli and Klein 1997)").is_some());
    picture(&mut bench.harness, "help_term");
    bench.harness.state_mut().state.time.markers_s = [Some(7.0), None];
    bench.harness.key_press(Key::Escape);
    bench.harness.run_steps(3);
    assert_eq!(bench.harness.state().help.topic(), None);
    assert_eq!(bench.harness.state().state.time.markers_s[0], Some(7.0), "Escape closed the manual alone");
    press_f1(&mut bench, at + vec2(0.0, 60.0));
    assert_eq!(bench.harness.state().help.topic(), Some(&Topic::Panel(Pane::Derivatives)));
    assert!(bench.harness.query_by_label_contains("Derivatives with their uncertainty").is_some());
    picture(&mut bench.harness, "help_panel");
}

#[test]
fn search_finds_words_and_lines_without_a_net_and_a_link_leads_on() {
    let mut bench = Bench::open();
    bench.harness.state_mut().help.open(Topic::Contents);
    bench.harness.run_steps(3);
    click(&mut bench.harness, "search the manual", 2);
    bench.harness.get_by_label("search the manual").type_text("variance inflation");
    bench.harness.run_steps(3);
    picture(&mut bench.harness, "help_search");
    click(&mut bench.harness, "VIF", 3);
    assert_eq!(bench.harness.state().help.topic(), Some(&Topic::Term("VIF".to_owned())));
    let formula = glossary::find("VIF").and_then(|entry| entry.formula.clone()).expect("it has one");
    assert!(bench.harness.query_by_label_contains(&formula).is_some(), "{formula}");
}
