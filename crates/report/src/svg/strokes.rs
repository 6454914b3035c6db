//! What keeps marks apart where their colours do not print: a dash pattern for every line of a panel, a shape for every kind of point.

use doublet_engine::report::document::{Colour, Figure, LineStyle, Mark, Panel};

/// Dash patterns in the order in which the lines of a panel get them; the first is solid.
const DASHES: [&str; 7] = ["", "4 2.5", "7 2 1.2 2", "1.3 1.5", "9 2.5", "5 1.5 1.2 1.5 1.2 1.5", "2.5 1.2"];
/// Place of the pattern of a dashed line that has none of its own.
const DASHED: usize = 1;
/// Opacity of the parts of an axis, in the order of their names.
const OPACITIES: [&str; 2] = ["0.25", "0.5"];

/// Shapes of points in the order in which the points of a panel get them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Disc,
    Ring,
    Triangle,
    Square,
    Cross,
}

const SHAPES: [Shape; 5] = [Shape::Disc, Shape::Ring, Shape::Triangle, Shape::Square, Shape::Cross];

/// A kind of mark: how it is drawn, and its colour.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Joined(LineStyle, Colour),
    Points(Colour),
    Span(Colour),
}

/// The place of every kind of mark with a name, the same in all panels of a figure.
#[derive(Default)]
pub struct Strokes {
    places: Vec<(Kind, usize)>,
}

impl Strokes {
    pub fn of_figure(figure: &Figure) -> Self {
        let mut strokes = Self::default();
        for panel in &figure.panels {
            let Panel::Plot(plot) = panel else { continue };
            strokes.add(&plot.marks);
        }
        strokes
    }

    /// Gives every named kind of one panel a place of its own there. A kind keeps the place that another panel gave it while it is free.
    fn add(&mut self, marks: &[Mark]) {
        let mut taken: Vec<(Kind, usize)> = Vec::new();
        for kind in marks.iter().filter_map(named_kind) {
            if taken.iter().any(|(other, _)| *other == kind) {
                continue;
            }
            let is_free = |place: &usize| taken.iter().all(|(other, own)| !is_like(*other, kind) || own != place);
            let known = self.place(kind).filter(is_free);
            let first = usize::from(matches!(kind, Kind::Joined(LineStyle::Dashed, _)));
            let place = known.unwrap_or_else(|| (first..).find(is_free).unwrap_or(first));
            taken.push((kind, place));
            self.places.retain(|(other, _)| *other != kind);
            self.places.push((kind, place));
        }
    }

    fn place(&self, kind: Kind) -> Option<usize> {
        self.places.iter().find(|(other, _)| *other == kind).map(|(_, place)| *place)
    }

    /// The dash pattern of a line as an attribute; nothing for a solid one.
    pub fn dashes(&self, style: LineStyle, colour: Colour) -> String {
        let usual = if style == LineStyle::Dashed { DASHED } else { 0 };
        let place = self.place(Kind::Joined(style, colour)).unwrap_or(usual);
        let pattern = DASHES[place % DASHES.len()];
        if pattern.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{pattern}\"") }
    }

    pub fn shape(&self, colour: Colour) -> Shape {
        SHAPES[self.place(Kind::Points(colour)).unwrap_or(0) % SHAPES.len()]
    }

    pub fn opacity(&self, colour: Colour) -> &'static str {
        OPACITIES[self.place(Kind::Span(colour)).unwrap_or(0) % OPACITIES.len()]
    }
}

/// Whether two kinds are told apart by their places.
fn is_like(one: Kind, other: Kind) -> bool {
    std::mem::discriminant(&one) == std::mem::discriminant(&other)
}

/// The kind of a mark that is in the legend.
fn named_kind(mark: &Mark) -> Option<Kind> {
    match mark {
        Mark::Line { label, .. } | Mark::Points { label, .. } | Mark::Span { label, .. } if label.is_empty() => None,
        Mark::Line { style: LineStyle::Dots, colour, .. } | Mark::Points { style: LineStyle::Dots, colour, .. } => {
            Some(Kind::Points(*colour))
        }
        Mark::Line { style, colour, .. } | Mark::Points { style, colour, .. } => Some(Kind::Joined(*style, *colour)),
        Mark::Span { colour, .. } => Some(Kind::Span(*colour)),
        Mark::Band { .. } | Mark::Bars { .. } | Mark::Level { .. } => None,
    }
}

/// A point of a shape as SVG.
pub fn draw_shape((x, y): (f64, f64), ink: &str, shape: Shape) -> String {
    match shape {
        Shape::Disc => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.5\" fill=\"{ink}\"/>"),
        Shape::Ring => format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.8\" fill=\"#ffffff\" stroke=\"{ink}\" stroke-width=\"0.8\"/>"
        ),
        Shape::Triangle => {
            format!("<path d=\"M{:.1} {:.1}h4.4l-2.2 -3.8z\" fill=\"{ink}\"/>", x - 2.2, y + 1.6)
        }
        Shape::Square => format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"3.2\" height=\"3.2\" fill=\"#ffffff\" stroke=\"{ink}\" stroke-width=\"0.8\"/>",
            x - 1.6,
            y - 1.6
        ),
        Shape::Cross => format!(
            "<path d=\"M{:.1} {:.1}l3.6 3.6m0 -3.6l-3.6 3.6\" stroke=\"{ink}\" stroke-width=\"0.8\"/>",
            x - 1.8,
            y - 1.8
        ),
    }
}

#[cfg(test)]
mod tests {
    use doublet_engine::report::document::{Axis, Plot};

    use super::*;

    fn panel(marks: &[(&'static str, usize, LineStyle)]) -> Panel {
        let marks = marks.iter().map(|&(label, colour, style)| Mark::Points {
            label: label.into(),
            colour: Colour::by_index(colour),
            style,
            points: Vec::new(),
        });
        Panel::Plot(Plot { x: Axis::default(), y: Axis::default(), marks: marks.collect() })
    }

    #[test]
    fn lines_and_points_of_a_panel_differ_without_their_colours() {
        use LineStyle::{Dashed, Dots, Solid};
        let panels = vec![
            panel(&[("one", 0, Solid), ("two", 1, Solid), ("three", 2, Dashed), ("a", 3, Dots), ("b", 4, Dots)]),
            panel(&[("three", 2, Dashed), ("", 6, Dashed), ("residual", 5, Solid)]),
        ];
        let figure = Figure { name: String::new(), caption: String::new(), columns: 1, panel_height_mm: 20.0, panels };
        let strokes = Strokes::of_figure(&figure);
        let dashes = |style, colour| strokes.dashes(style, Colour::by_index(colour));
        let first = [dashes(Solid, 0), dashes(Solid, 1), dashes(Dashed, 2)];
        assert!(first[0].is_empty() && first[1] != first[2] && !first[1].is_empty() && !first[2].is_empty());
        assert!(dashes(Solid, 5).is_empty(), "the only solid line of its panel");
        assert!(dashes(Dashed, 6).contains(DASHES[DASHED]));
        assert_ne!(strokes.shape(Colour::by_index(3)), strokes.shape(Colour::by_index(4)));
    }
}
