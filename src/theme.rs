//! Colours, fonts, text styles and spacing of the workbench.

use std::sync::Arc;

use doublet_engine::builtin;
use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Margin, Stroke, TextStyle, Theme, Vec2,
};

/// Colours that carry meaning, one set per theme. Series colours stay apart for the common colour-vision deficiencies.
#[derive(Debug)]
pub struct Palette {
    /// Colours of measured and computed traces, in order of use.
    pub series: [Color32; 8],
    /// Manoeuvres that enter the estimate.
    pub identification: Color32,
    /// Manoeuvres kept for validation.
    pub validation: Color32,
    /// Manoeuvres left out.
    pub ignored: Color32,
    /// Parts of time used for noise statistics.
    pub steady: Color32,
    /// Something is right.
    pub good: Color32,
    /// Something wants attention.
    pub warning: Color32,
    /// Something failed or lies outside its range.
    pub error: Color32,
    /// The linked cursor.
    pub cursor: Color32,
    /// Markers A and B.
    pub markers: [Color32; 2],
    /// The application's accent.
    pub accent: Color32,
    /// Ends of the diverging scale, -1 and +1; zero is the plot background.
    pub diverging: [Color32; 2],
    /// Background of plots and of zero in heat maps.
    pub plot_background: Color32,
    /// Grid lines of plots.
    pub grid: Color32,
}

/// A colour from its hexadecimal form.
const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// Colours on dark grounds.
pub static DARK: Palette = Palette {
    series: [
        rgb(0x5CB3FF),
        rgb(0xFFA64D),
        rgb(0x38C9A0),
        rgb(0xE88BC4),
        rgb(0xF2DB5E),
        rgb(0xF4775B),
        rgb(0xA99CFF),
        rgb(0xB9C1CC),
    ],
    identification: rgb(0x4C9BE8),
    validation: rgb(0xE5A23D),
    ignored: rgb(0x7C8794),
    steady: rgb(0x3FBF9B),
    good: rgb(0x4CC38A),
    warning: rgb(0xF0A93B),
    error: rgb(0xFF6B5E),
    cursor: rgb(0xD7DEE8),
    markers: [rgb(0xF2DB5E), rgb(0xE88BC4)],
    accent: rgb(0x4C9BE8),
    diverging: [rgb(0x4C9BE8), rgb(0xF4775B)],
    plot_background: rgb(0x14181D),
    grid: rgb(0x2C3540),
};

/// Colours on light grounds.
pub static LIGHT: Palette = Palette {
    series: [
        rgb(0x0068B4),
        rgb(0xD55E00),
        rgb(0x00876C),
        rgb(0xB5478F),
        rgb(0xA87B00),
        rgb(0x8C2D19),
        rgb(0x5A4FCF),
        rgb(0x56606B),
    ],
    identification: rgb(0x2F7FD1),
    validation: rgb(0xD18A1D),
    ignored: rgb(0x8A94A0),
    steady: rgb(0x1E9C7A),
    good: rgb(0x1E8A5A),
    warning: rgb(0xB86E00),
    error: rgb(0xC6321F),
    cursor: rgb(0x2A323C),
    markers: [rgb(0xA87B00), rgb(0xB5478F)],
    accent: rgb(0x1F6FC2),
    diverging: [rgb(0x2166AC), rgb(0xB2442C)],
    plot_background: rgb(0xFFFFFF),
    grid: rgb(0xDFE5EC),
};

impl Palette {
    /// Colour of a level; a shape always goes with it.
    pub fn of_level(&self, level: Level) -> Color32 {
        match level {
            Level::Good => self.good,
            Level::Caution => self.warning,
            Level::Bad => self.error,
        }
    }
}

/// The palette that fits what `ui` is drawn with.
pub fn palette(ui: &egui::Ui) -> &'static Palette {
    palette_of(ui.visuals().dark_mode)
}

/// The palette of the dark or the light theme.
pub fn palette_of(dark: bool) -> &'static Palette {
    if dark { &DARK } else { &LIGHT }
}

/// Style of figures in tables and read-outs: digits of one width.
pub fn figures(ui: &egui::Ui) -> FontId {
    TextStyle::Monospace.resolve(ui.style())
}

/// Installs fonts, both themes, text styles and spacing.
pub fn install(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            style.text_styles = [
                (TextStyle::Small, FontId::proportional(10.5)),
                (TextStyle::Body, FontId::proportional(12.5)),
                (TextStyle::Button, FontId::proportional(12.5)),
                (TextStyle::Heading, FontId::proportional(15.5)),
                (TextStyle::Monospace, FontId::monospace(12.0)),
            ]
            .into();
            let spacing = &mut style.spacing;
            spacing.item_spacing = Vec2::new(8.0, 5.0);
            spacing.button_padding = Vec2::new(8.0, 3.0);
            spacing.interact_size = Vec2::new(36.0, 22.0);
            spacing.menu_margin = Margin::same(6);
            // Seen without the pointer over it: what is beyond the edge is there.
            spacing.scroll.dormant_handle_opacity = 0.35;
            spacing.scroll.floating_width = 3.0;
            spacing.window_margin = Margin::same(12);
            style.interaction.selectable_labels = false;
            style.animation_time = 0.08;
            style.visuals = visuals(theme);
        });
    }
}

/// DejaVu Sans, the text of window and figures.
pub fn font() -> &'static [u8] {
    builtin::font("DejaVuSans.ttf")
}

/// The colour that stands on white for a colour of the dark theme; other colours stay.
pub fn printed(color: Color32) -> Color32 {
    let pairs = DARK.series.into_iter().zip(LIGHT.series);
    let roles = [
        (DARK.identification, LIGHT.identification),
        (DARK.validation, LIGHT.validation),
        (DARK.ignored, LIGHT.ignored),
        (DARK.steady, LIGHT.steady),
        (DARK.good, LIGHT.good),
        (DARK.warning, LIGHT.warning),
        (DARK.error, LIGHT.error),
        (DARK.accent, LIGHT.accent),
    ];
    pairs.chain(roles).find(|(dark, _)| *dark == color).map_or(color, |(_, light)| light)
}

/// DejaVu Sans before egui's own fonts: it has the combining dots and subscripts of flight mechanics.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let name = "DejaVu Sans";
    let data = FontData::from_static(font());
    fonts.font_data.insert(name.to_owned(), Arc::new(data));
    fonts.families.entry(FontFamily::Proportional).or_default().insert(0, name.to_owned());
    fonts.families.entry(FontFamily::Monospace).or_default().push(name.to_owned());
    fonts
}

/// Grounds, strokes and corners of one theme.
fn visuals(theme: Theme) -> egui::Visuals {
    let dark = theme == Theme::Dark;
    let palette = palette_of(dark);
    let mut visuals = theme.default_visuals();
    let (panel, window, faint, line, text, strong, hover, rest) = if dark {
        (0x1C2128, 0x232A33, 0x212730, 0x343D49, 0xC3CCD8, 0xF2F5F9, 0x36414F, 0x2A323D)
    } else {
        (0xF3F5F8, 0xFFFFFF, 0xE9EDF2, 0xCBD3DC, 0x2C3641, 0x0B1118, 0xDCE4ED, 0xE6EBF1)
    };
    visuals.panel_fill = rgb(panel);
    visuals.window_fill = rgb(window);
    visuals.faint_bg_color = rgb(faint);
    visuals.extreme_bg_color = palette.plot_background;
    visuals.window_stroke = Stroke::new(1.0, rgb(line));
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(6);
    visuals.selection.bg_fill = palette.accent.gamma_multiply(if dark { 0.45 } else { 0.30 });
    visuals.selection.stroke = Stroke::new(1.0, if dark { rgb(0xFFFFFF) } else { rgb(0x0B3B6B) });
    if !dark {
        // egui's 0.6 is too pale for small text on the light ground.
        visuals.weak_text_alpha = 0.72;
    }
    visuals.hyperlink_color = palette.accent;
    visuals.warn_fg_color = palette.warning;
    visuals.error_fg_color = palette.error;
    visuals.slider_trailing_fill = true;
    visuals.striped = true;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, rgb(line));
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, rgb(text));
    widgets.inactive.weak_bg_fill = rgb(rest);
    widgets.inactive.bg_fill = rgb(rest);
    // on light rows the fill alone does not show where a field or a box is
    widgets.inactive.bg_stroke = if dark { Stroke::NONE } else { Stroke::new(1.0, rgb(0xB7C1CC)) };
    widgets.inactive.fg_stroke = Stroke::new(1.0, rgb(text));
    widgets.hovered.weak_bg_fill = rgb(hover);
    widgets.hovered.bg_fill = rgb(hover);
    widgets.hovered.bg_stroke = Stroke::new(1.0, palette.accent.gamma_multiply(0.7));
    widgets.hovered.fg_stroke = Stroke::new(1.0, rgb(strong));
    widgets.active.weak_bg_fill = palette.accent.gamma_multiply(0.55);
    widgets.active.bg_fill = palette.accent.gamma_multiply(0.55);
    widgets.active.fg_stroke = Stroke::new(1.0, rgb(strong));
    widgets.open.weak_bg_fill = rgb(hover);
    for state in [
        &mut widgets.noninteractive, &mut widgets.inactive, &mut widgets.hovered, &mut widgets.active,
        &mut widgets.open,
    ] {
        state.corner_radius = CornerRadius::same(4);
    }
    visuals
}
