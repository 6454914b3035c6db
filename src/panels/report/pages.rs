//! The report as the pages that are printed: typeset in the background, each drawn while it is on screen.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use doublet_engine::graph::StageError;
use doublet_engine::report::document::SectionKind;
use doublet_engine::run::{Control, Job};
use doublet_report::{Order, Page};
use eframe::egui::{
    self, Color32, ColorImage, CornerRadius, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, TextureHandle,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};

use crate::panels::{PanelContext, dim_if, trouble};
use crate::ui_state::HouseStyle;
use crate::widgets::figure::page_picture;

/// Widest page on screen, and the room between pages, points.
const WIDEST: f32 = 860.0;
const BETWEEN: f32 = 14.0;
/// Least width of a page that may stand beside another.
const LEAST: f32 = 560.0;
/// Pages beside those on screen whose pictures are kept.
const KEPT: usize = 4;

/// What pages were typeset from.
#[derive(Clone, PartialEq)]
struct Source {
    generation: u64,
    steps: usize,
    left_out: BTreeSet<SectionKind>,
    house: HouseStyle,
}

/// Pages, and the names of the sections that are on them.
type Typeset = (Vec<Page>, BTreeSet<String>);

/// The pages of the report on screen.
#[derive(Default)]
pub struct Pages {
    typesetting: Option<(Source, Job<Typeset>)>,
    source: Option<Source>,
    pages: Arc<[Page]>,
    sections: BTreeSet<String>,
    error: Option<String>,
    /// The page being drawn, with its width in pixels.
    drawing: Option<(usize, u32, Job<ColorImage>)>,
    /// Pictures by page, each with its width in pixels.
    pictures: BTreeMap<usize, (u32, TextureHandle)>,
}

impl Drop for Pages {
    fn drop(&mut self) {
        // Typesetting leaves nothing behind, and takes longer than a window may take to close.
        if let Some((_, job)) = self.typesetting.take() {
            job.abandon();
        }
        if let Some((.., job)) = self.drawing.take() {
            job.abandon();
        }
    }
}

impl Pages {
    pub fn show(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui) {
        self.take(ui.ctx());
        self.follow(ctx, ui.ctx());
        trouble(ui, self.error.as_deref());
        if self.pages.is_empty() {
            if self.typesetting.is_some() || ctx.snapshot.busy {
                ui.spinner();
            }
            return;
        }
        dim_if(ui, self.typesetting.is_some() || ctx.snapshot.busy);
        let mut wanted = None;
        let mut shown = BTreeSet::new();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let room = ui.available_width() - 8.0;
            let across = if room >= 2.0 * LEAST + BETWEEN { 2 } else { 1 };
            let width = ((room - BETWEEN * (across - 1) as f32) / across as f32).min(WIDEST);
            for (row, pages) in self.pages.chunks(across).enumerate() {
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = BETWEEN;
                    ui.add_space((0.5 * (room - width * across as f32 - BETWEEN * (across - 1) as f32)).max(0.0));
                    for (column, page) in pages.iter().enumerate() {
                        let at = row * across + column;
                        if let Some(pixels) = self.page(ui, (at, page), width) {
                            shown.insert(at);
                            if self.pictures.get(&at).is_none_or(|(drawn, _)| *drawn != pixels) {
                                wanted = wanted.or(Some((at, pixels)));
                            }
                        }
                    }
                });
                ui.add_space(BETWEEN);
            }
        });
        let is_near = |at: &usize| shown.iter().any(|shown| at.abs_diff(*shown) <= KEPT);
        self.pictures.retain(|at, _| is_near(at));
        if let Some((at, pixels)) = wanted.filter(|_| self.drawing.is_none()) {
            self.draw(ui.ctx(), at, pixels);
        }
    }

    /// One page; its width in pixels where it is on screen.
    fn page(&self, ui: &mut Ui, (at, page): (usize, &Page), width: f32) -> Option<u32> {
        let [own_width, own_height] = page.size_pt;
        let size = vec2(width, width * own_height / own_width.max(1.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let name = format!("page {} of {}", at + 1, self.pages.len());
        response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &name));
        if !ui.is_rect_visible(rect) {
            return None;
        }
        let painter = ui.painter();
        painter.rect_filled(rect, CornerRadius::ZERO, Color32::WHITE);
        if let Some((_, picture)) = self.pictures.get(&at) {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(picture.id(), rect, whole, Color32::WHITE);
        }
        let edge = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
        painter.rect_stroke(rect, CornerRadius::ZERO, edge, StrokeKind::Outside);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a width on screen")]
        let pixels = (width * ui.pixels_per_point()).round() as u32;
        Some(pixels)
    }

    /// Takes what was typeset and drawn.
    fn take(&mut self, ctx: &egui::Context) {
        if let Some((source, job)) = self.typesetting.take_if(|(_, job)| job.is_finished()) {
            match job.finish() {
                Ok((pages, sections)) => {
                    (self.pages, self.sections) = (pages.into(), sections);
                    self.pictures.clear();
                    self.error = None;
                }
                Err(error) => self.error = Some(error.to_string()),
            }
            self.source = Some(source);
        }
        if let Some((at, width, job)) = self.drawing.take_if(|(.., job)| job.is_finished()) {
            match job.finish() {
                Ok(picture) => {
                    let picture = ctx.load_texture(format!("page {at}"), picture, TextureOptions::LINEAR);
                    self.pictures.insert(at, (width, picture));
                }
                Err(error) => self.error = Some(error.to_string()),
            }
        }
    }

    /// Typesets the pages anew where results or sections have changed.
    fn follow(&mut self, ctx: &PanelContext<'_>, egui: &egui::Context) {
        let (generation, steps) = (ctx.snapshot.generation, ctx.snapshot.log.len());
        let left_out = ctx.state.report.left_out.clone();
        let source = Source { generation, steps, left_out, house: ctx.state.house.clone() };
        if ctx.snapshot.busy || self.typesetting.is_some() || self.source.as_ref() == Some(&source) {
            return;
        }
        let (session, snapshot) = (ctx.session.clone(), ctx.snapshot.clone());
        let kinds = source.house.sections().into_iter().filter(|kind| !source.left_out.contains(kind));
        let style = match source.house.style() {
            Ok(style) => style,
            Err(error) => {
                (self.error, self.source) = (Some(error), Some(source));
                return;
            }
        };
        let order = Order { sections: kinds.collect(), style, ..Order::default() };
        let wake = egui.clone();
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            let document = doublet_report::assemble(&session, &snapshot, &order);
            let sections = document.sections.iter().map(|section| section.name.clone()).collect();
            Ok((doublet_report::pages(&document, control, progress)?, sections))
        };
        match Job::start::<String>("typesetting", move || wake.request_repaint(), work) {
            Ok(job) => self.typesetting = Some((source, job)),
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    fn draw(&mut self, egui: &egui::Context, at: usize, width: u32) {
        let (pages, wake) = (Arc::clone(&self.pages), egui.clone());
        let work = move |_: &Control, _: &(dyn Fn(f32) + Sync)| {
            let svg = pages.get(at).map(|page| page.svg.as_str()).unwrap_or_default();
            page_picture(svg, width).map_err(StageError::from)
        };
        match Job::start("page of the report", move || wake.request_repaint(), work) {
            Ok(job) => self.drawing = Some((at, width, job)),
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// Whether a section was asked for and has no contents.
    pub fn is_empty(&self, kind: SectionKind) -> bool {
        let is_of_kind = |name: &String| name == kind.name() || name.strip_prefix("appendix-") == Some(kind.name());
        let is_asked = self.source.as_ref().is_some_and(|source| !source.left_out.contains(&kind));
        is_asked && !self.pages.is_empty() && !self.sections.iter().any(is_of_kind)
    }

    /// How many pages there are, and what is being done about them.
    pub fn status(&self, ui: &mut Ui) {
        let text = match (self.typesetting.is_some(), self.pages.len()) {
            (true, 0) => "typesetting…".to_owned(),
            (true, _) => "out of date, typesetting…".to_owned(),
            (false, 0) => return,
            (false, 1) => "1 page".to_owned(),
            (false, count) => format!("{count} pages"),
        };
        ui.label(RichText::new(text).size(11.0).weak());
    }
}
