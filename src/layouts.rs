//! Where the panels are: one layout per step of the analysis, one with everything at once, and those the user keeps by name.

use eframe::egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use serde::{Deserialize, Serialize};

use crate::pane::Pane;
use crate::step::Step;

/// Width the shares of a new layout are meant for, points.
pub const REFERENCE_WIDTH: f32 = 1366.0;
/// Below this width settings lie in the drawer below the plots instead of a column beside them.
pub const LEAST_WIDTH: f32 = 1240.0;
/// Width of the column of settings, and of one that holds a wide table, points.
const COLUMN: f32 = 380.0;
const WIDE_COLUMN: f32 = 640.0;
/// Part of the height that the plots have above a drawer, and above one with the settings.
const ABOVE_DRAWER: f32 = 0.6;
const ABOVE_SETTINGS: f32 = 0.5;

impl Step {
    /// Panels of its layout: the plots, the settings beside them, the drawer below.
    fn panes(self) -> Arrangement {
        let column = Beside::Column;
        match self {
            Self::Recording => {
                Arrangement::new(&[Pane::Flight, Pane::GroundTrack, Pane::CrossPlot, Pane::Replay], column, &[], &[])
            }
            Self::Channels => Arrangement::new(&[Pane::Channels], Beside::Half, &[Pane::Flight], &[]),
            Self::Aircraft => {
                Arrangement::new(&[Pane::Loading], Beside::Half, &[Pane::Airframe, Pane::Propulsion], &[])
            }
            Self::Signals => Arrangement::new(
                &[Pane::Flight, Pane::CrossPlot],
                Beside::Wide,
                &[Pane::Preprocess, Pane::Sensors],
                &[],
            ),
            Self::Manoeuvres => Arrangement::new(
                &[Pane::Flight, Pane::ManoeuvreMap, Pane::Gallery, Pane::GroundTrack],
                Beside::Wide,
                &[Pane::Manoeuvres],
                &[],
            ),
            Self::Filter => Arrangement::new(
                &[Pane::Innovations, Pane::Reconstruction, Pane::Replay],
                Beside::Wide,
                &[Pane::Noise],
                &[Pane::Summary, Pane::Manoeuvres],
            ),
            Self::Model => Arrangement::new(
                &[Pane::Fits, Pane::Experiments, Pane::Match, Pane::Reconstruction],
                Beside::Wide,
                &[Pane::Model],
                &[Pane::Derivatives, Pane::Correlation, Pane::Summary],
            ),
            Self::Results => Arrangement::new(
                &[
                    Pane::Summary,
                    Pane::Derivatives,
                    Pane::Correlation,
                    Pane::Studies,
                    Pane::Sensitivity,
                    Pane::Responses,
                    Pane::Dynamics,
                    Pane::Prior,
                ],
                Beside::Half,
                &[Pane::Fits, Pane::Match, Pane::Reconstruction, Pane::Innovations],
                &[],
            ),
            Self::Report => Arrangement::new(
                &[Pane::Report, Pane::Qualification, Pane::Enough, Pane::Design, Pane::Log],
                column,
                &[],
                &[],
            ),
        }
    }

    /// The step in whose layout `pane` is at home: the one whose plots or settings it heads, the results, otherwise the first that has it.
    pub fn of_pane(pane: Pane) -> Option<Self> {
        let heads = |step: &Self| {
            let panes = step.panes();
            [panes.plots.first(), panes.settings.first()].into_iter().flatten().any(|first| *first == pane)
        };
        let holds = |step: &Self| step.panes().all().any(|held| held == pane);
        let results = Some(Self::Results).filter(|step| step.panes().plots.contains(&pane));
        Self::ALL.into_iter().find(heads).or(results).or_else(|| Self::ALL.into_iter().find(holds))
    }
}

/// How wide the settings are.
#[derive(Clone, Copy, PartialEq)]
enum Beside {
    Column,
    Wide,
    Half,
}

/// Panels of a layout by their place.
struct Arrangement {
    plots: &'static [Pane],
    beside: Beside,
    settings: &'static [Pane],
    drawer: &'static [Pane],
}

impl Arrangement {
    fn new(plots: &'static [Pane], beside: Beside, settings: &'static [Pane], drawer: &'static [Pane]) -> Self {
        Self { plots, beside, settings, drawer }
    }

    fn all(&self) -> impl Iterator<Item = Pane> {
        [self.plots, self.settings, self.drawer].into_iter().flatten().copied()
    }

    /// The tree for a window of at least [`LEAST_WIDTH`], or for a narrower one.
    fn tree(&self, id: Id, narrow: bool) -> Tree<Pane> {
        let mut tiles = Tiles::default();
        let mut tabs = |panes: &mut dyn Iterator<Item = &Pane>| {
            let children: Vec<TileId> = panes.map(|&pane| tiles.insert_pane(pane)).collect();
            (!children.is_empty()).then(|| tiles.insert_tab_tile(children))
        };
        let narrow_settings = narrow && self.beside != Beside::Half;
        let (beside, below): (&[Pane], Vec<Pane>) = if narrow_settings {
            (&[], self.settings.iter().chain(self.drawer).copied().collect())
        } else {
            (self.settings, self.drawer.to_vec())
        };
        let plots = tabs(&mut self.plots.iter());
        let below = tabs(&mut below.iter());
        let beside = tabs(&mut beside.iter());
        let join =
            |tiles: &mut Tiles<Pane>, dir, first: Option<TileId>, second: Option<TileId>, part| match (first, second) {
                (Some(first), Some(second)) => {
                    let linear = Linear::new_binary(dir, [first, second], part);
                    Some(tiles.insert_container(linear))
                }
                (one, other) => one.or(other),
            };
        let above = if narrow_settings { ABOVE_SETTINGS } else { ABOVE_DRAWER };
        let left = join(&mut tiles, LinearDir::Vertical, plots, below, above);
        let part = match self.beside {
            Beside::Column => 1.0 - COLUMN / REFERENCE_WIDTH,
            Beside::Wide => 1.0 - WIDE_COLUMN / REFERENCE_WIDTH,
            Beside::Half => 0.5,
        };
        match join(&mut tiles, LinearDir::Horizontal, left, beside, part) {
            Some(root) => Tree::new(id, root, tiles),
            None => Tree::empty(id),
        }
    }
}

/// Which layout is on screen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LayoutKey {
    Step(Step),
    /// Flight, plots, settings and results at once.
    Overview,
    /// One that was kept under a name.
    Named(String),
}

impl LayoutKey {
    /// The layout as it is at first.
    pub fn tree(&self, narrow: bool) -> Tree<Pane> {
        match self {
            Self::Step(step) => step.panes().tree(Id::unique(("layout", *step as usize)), narrow),
            Self::Overview | Self::Named(_) => overview(),
        }
    }
}

/// A layout with the width its shares are meant for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arranged {
    pub key: LayoutKey,
    /// The panels.
    pub tree: Tree<Pane>,
    /// Width it was drawn in last, points.
    pub width: f32,
    /// Whether it is that of a window narrower than [`LEAST_WIDTH`].
    pub narrow: bool,
    /// Whether the user has moved a panel or an edge.
    pub touched: bool,
}

impl Arranged {
    /// The layout as it is at first.
    pub fn new(key: LayoutKey) -> Self {
        let tree = key.tree(false);
        Self { key, tree, width: REFERENCE_WIDTH, narrow: false, touched: false }
    }

    /// Fits it to a window of `width`: the column at the right keeps its width, and what nobody has touched turns into the layout of a
    /// narrow window and back.
    pub fn fit(&mut self, width: f32) {
        let narrow = width < LEAST_WIDTH;
        if narrow != self.narrow && !self.touched {
            self.tree = self.key.tree(narrow);
            self.width = REFERENCE_WIDTH;
        }
        self.narrow = narrow;
        if (width - self.width).abs() < 0.5 {
            return;
        }
        let is_column = match &self.key {
            LayoutKey::Step(step) => step.panes().beside != Beside::Half,
            LayoutKey::Overview | LayoutKey::Named(_) => false,
        };
        let before = std::mem::replace(&mut self.width, width);
        let root = self.tree.root().filter(|_| is_column);
        let Some(Tile::Container(Container::Linear(linear))) = root.and_then(|root| self.tree.tiles.get_mut(root))
        else {
            return;
        };
        let [first, last] = *linear.children.as_slice() else { return };
        if linear.dir != LinearDir::Horizontal {
            return;
        }
        let (left, right) = (linear.shares[first], linear.shares[last]);
        let column = before * right / (left + right);
        let part = (column / width).clamp(0.2, 0.6);
        linear.shares.set_share(first, 2.0 * (1.0 - part));
        linear.shares.set_share(last, 2.0 * part);
    }

    /// Makes `pane` visible, among the plots where the layout does not have it.
    pub fn bring_to_front(&mut self, pane: Pane) {
        if self.tree.tiles.find_pane(&pane).is_none() {
            let new = self.tree.tiles.insert_pane(pane);
            let mut plots: Option<TileId> = self.tree.root();
            while let Some(Tile::Container(container)) = plots.and_then(|tile| self.tree.tiles.get(tile)) {
                if matches!(container, Container::Tabs(_)) {
                    break;
                }
                plots = container.children().next().copied();
            }
            match plots.and_then(|tile| self.tree.tiles.get_mut(tile)) {
                Some(Tile::Container(container)) => container.add_child(new),
                _ => self.tree = self.key.tree(self.narrow),
            }
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(held) if *held == pane));
    }

    /// Whether it has `pane`.
    pub fn holds(&self, pane: Pane) -> bool {
        self.tree.tiles.find_pane(&pane).is_some()
    }
}

/// Everything at once: the flight and what became of its windows on the left, settings and results on the right.
fn overview() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let children = panes.iter().map(|&pane| tiles.insert_pane(pane)).collect();
        tiles.insert_tab_tile(children)
    };
    let flight = tabs(&[Pane::Flight, Pane::GroundTrack, Pane::CrossPlot]);
    let plots = tabs(&[
        Pane::Reconstruction,
        Pane::Innovations,
        Pane::Fits,
        Pane::Match,
        Pane::Replay,
        Pane::Propulsion,
        Pane::Dynamics,
    ]);
    let settings = tabs(&[Pane::Manoeuvres, Pane::Preprocess, Pane::Noise, Pane::Model, Pane::Loading]);
    let results = tabs(&[
        Pane::Summary,
        Pane::Derivatives,
        Pane::Correlation,
        Pane::Sensitivity,
        Pane::Report,
        Pane::Log,
        Pane::Shortcuts,
    ]);
    let left = Linear::new_binary(LinearDir::Vertical, [flight, plots], 0.5);
    let left = tiles.insert_container(left);
    let right = Linear::new_binary(LinearDir::Vertical, [settings, results], 0.48);
    let right = tiles.insert_container(right);
    let all = Linear::new_binary(LinearDir::Horizontal, [left, right], 0.58);
    let root = tiles.insert_container(all);
    Tree::new(Id::unique("workbench"), root, tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part of the width that the column at the right has.
    fn column(arranged: &Arranged) -> f32 {
        let root = arranged.tree.root().and_then(|root| arranged.tree.tiles.get(root));
        let Some(Tile::Container(Container::Linear(linear))) = root else { return 0.0 };
        let [first, last] = linear.children[..] else { return 0.0 };
        if linear.dir != LinearDir::Horizontal {
            return 0.0;
        }
        linear.shares[last] / (linear.shares[first] + linear.shares[last])
    }

    #[test]
    fn column_of_settings_keeps_its_width_from_the_narrowest_window_to_the_widest() {
        let mut arranged = Arranged::new(LayoutKey::Step(Step::Filter));
        for width in [1280.0, 1366.0, 1920.0, 2560.0] {
            arranged.fit(width);
            assert!((column(&arranged) * width - WIDE_COLUMN).abs() < 0.5, "{} at {width}", column(&arranged) * width);
        }
    }

    #[test]
    fn narrow_window_has_the_settings_in_the_drawer_and_a_wide_one_beside_the_plots() {
        let mut arranged = Arranged::new(LayoutKey::Step(Step::Filter));
        let first = arranged.tree.clone();
        arranged.fit(1000.0);
        assert_eq!(column(&arranged), 0.0);
        assert!(arranged.holds(Pane::Noise));
        arranged.fit(REFERENCE_WIDTH);
        assert_eq!(arranged.tree, first);
        arranged.touched = true;
        arranged.fit(1000.0);
        assert!(column(&arranged) > 0.0, "what was arranged by hand stays");
    }

    #[test]
    fn every_step_shows_panels_and_every_panel_of_a_finding_has_its_step() {
        for step in Step::ALL {
            assert!(step.panes().all().next().is_some(), "{}", step.title());
        }
        for (pane, step) in [
            (Pane::Noise, Step::Filter),
            (Pane::Innovations, Step::Filter),
            (Pane::Model, Step::Model),
            (Pane::Fits, Step::Model),
            (Pane::Manoeuvres, Step::Manoeuvres),
            (Pane::Loading, Step::Aircraft),
            (Pane::Propulsion, Step::Aircraft),
            (Pane::Preprocess, Step::Signals),
            (Pane::Flight, Step::Recording),
            (Pane::Channels, Step::Channels),
            (Pane::Derivatives, Step::Results),
            (Pane::Summary, Step::Results),
            (Pane::Report, Step::Report),
        ] {
            assert_eq!(Step::of_pane(pane), Some(step), "{}", pane.title());
        }
    }

    #[test]
    fn closed_panel_comes_back_to_the_front_among_the_plots() {
        let mut arranged = Arranged::new(LayoutKey::Step(Step::Model));
        let closed = arranged.tree.tiles.find_pane(&Pane::Correlation);
        closed.into_iter().for_each(|tile| drop(arranged.tree.remove_recursively(tile)));
        assert!(!arranged.holds(Pane::Correlation));
        arranged.bring_to_front(Pane::Correlation);
        let shown = arranged.tree.tiles.find_pane(&Pane::Correlation).expect("it is back");
        assert!(arranged.tree.is_visible_in_layout(shown));
        let fits = arranged.tree.tiles.find_pane(&Pane::Fits).expect("it is there");
        assert_eq!(arranged.tree.tiles.parent_of(shown), arranged.tree.tiles.parent_of(fits));
    }
}
