//! A light drawing of an aircraft in the proportions that its file gives, its controls deflected.

use doublet_core::airframe::Aircraft;
use doublet_core::airframe::frames::{body_from_datum, body_from_ned};
use nalgebra::Vector3;

/// Parts of the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapePart {
    /// Fuselage.
    Body,
    Wing,
    /// Fixed tail.
    Tail,
    /// Aileron, elevator or rudder.
    Control,
}

/// A closed outline in body axes (x forward, y right, z down) about the centre of gravity, m.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeOutline {
    pub part: ShapePart,
    pub corners: Vec<[f64; 3]>,
}

/// Length over span where neither the file's length nor its places tell it: usual of light aircraft.
const LENGTH_OVER_SPAN: f64 = 0.78;
/// Part of the length ahead of the quarter chord of the wing.
const AHEAD: f64 = 0.33;
/// Half width and half height of the fuselage over its length.
const GIRTH: f64 = 0.062;
/// Places along the fuselage from the nose, with the part of its girth there and its height over the axis, in girths.
const SECTIONS: [(f64, f64, f64); 5] =
    [(0.0, 0.25, 0.2), (0.12, 0.8, 0.0), (0.3, 1.0, 0.0), (0.55, 0.75, 0.0), (1.0, 0.15, -0.5)];
/// Corners of a section of the fuselage.
const AROUND: usize = 8;
/// Span and chord of the horizontal tail and height of the fin, over span, chord and span of the wing.
const TAIL: [f64; 3] = [0.32, 0.6, 0.15];
/// Part of the chord that moves, and of the half span that has the aileron.
const MOVING: f64 = 0.3;
const AILERON: [f64; 2] = [0.6, 0.97];

/// The outlines of an aircraft about a centre of gravity (m from the datum) with its controls deflected: aileron, elevator and rudder, rad, in the
/// signs of `docs/conventions.md` (right aileron, elevator trailing edge down, rudder trailing edge left).
pub fn shape(
    aircraft: &Aircraft,
    cg_from_datum_m: [f64; 3],
    [aileron, elevator, rudder]: [f64; 3],
) -> Vec<ShapeOutline> {
    let reference = &aircraft.reference;
    let (span, chord) = (reference.span_m, reference.chord_m);
    let leading_m = aircraft.mean_chord().map_or(cg_from_datum_m[0] - 0.25 * chord, |mean| mean.leading_edge_x_m);
    let length = aircraft.gyration_radii.map_or(LENGTH_OVER_SPAN * span, |radii| radii.length_m);
    let nose = leading_m + 0.25 * chord - AHEAD * length;
    let girth = GIRTH * length;
    let middle_z = cg_from_datum_m[2];
    let wing_z = middle_z + 0.8 * girth;
    let mut drawing = Drawing { cg: cg_from_datum_m, outlines: Vec::new() };
    drawing.fuselage((nose, middle_z), length, girth);
    let (wing_tip, tail_tip) = (0.5 * span, 0.5 * TAIL[0] * span);
    let aileron_at = [AILERON[0] * wing_tip, AILERON[1] * wing_tip];
    for (side, deflection) in [(1.0, aileron), (-1.0, -aileron)] {
        let panel = Panel { leading: leading_m, chord, z: wing_z };
        drawing.wing(aircraft, &panel, (side, wing_tip));
        drawing.flap(&panel, [side * aileron_at[0], side * aileron_at[1]], deflection, taper(aircraft));
    }
    let tail_chord = TAIL[1] * chord;
    let tail = Panel { leading: nose + length - tail_chord, chord: tail_chord, z: middle_z + 0.5 * girth };
    for side in [1.0, -1.0] {
        let tip = side * tail_tip;
        let hinge = tail.leading + (1.0 - MOVING) * tail_chord;
        let corners = [[tail.leading, 0.0], [tail.leading, tip], [hinge, tip], [hinge, 0.0]];
        drawing.add(ShapePart::Tail, corners.map(|[x, y]| [x, y, tail.z]));
        drawing.flap(&tail, [0.0, tip], elevator, 1.0);
    }
    drawing.fin(&tail, TAIL[2] * span, rudder);
    drawing.outlines
}

/// Chord at the tip over that at the root.
fn taper(aircraft: &Aircraft) -> f64 {
    aircraft.wing_panels.iter().map(|panel| panel.taper).product::<f64>().clamp(0.2, 1.0)
}

/// A lifting surface: leading edge and chord at its root, and its height, datum axes, m.
struct Panel {
    leading: f64,
    chord: f64,
    z: f64,
}

struct Drawing {
    cg: [f64; 3],
    outlines: Vec<ShapeOutline>,
}

impl Drawing {
    /// Adds an outline given in datum axes.
    fn add(&mut self, part: ShapePart, corners: impl IntoIterator<Item = [f64; 3]>) {
        let corners = corners.into_iter().map(|corner| body_from_datum(corner, self.cg)).collect();
        self.outlines.push(ShapeOutline { part, corners });
    }

    fn fuselage(&mut self, (nose, z): (f64, f64), length: f64, girth: f64) {
        let corner = |(along, part, up): (f64, f64, f64), at: usize| {
            let angle = std::f64::consts::TAU * at as f64 / AROUND as f64;
            let (sin, cos) = angle.sin_cos();
            [nose + along * length, part * girth * cos, z + girth * (part * sin - up)]
        };
        for section in SECTIONS {
            self.add(ShapePart::Body, (0..AROUND).map(|at| corner(section, at)));
        }
        for at in (0..AROUND).step_by(2) {
            let there = SECTIONS.into_iter().map(|section| corner(section, at));
            let back = SECTIONS.into_iter().rev().map(|section| corner(section, at));
            self.add(ShapePart::Body, there.chain(back));
        }
    }

    /// One half of the wing, as its panels give it, or as a rectangle.
    fn wing(&mut self, aircraft: &Aircraft, panel: &Panel, (side, tip): (f64, f64)) {
        if aircraft.wing_panels.is_empty() {
            let trailing = panel.leading + panel.chord;
            let corners = [[panel.leading, 0.0], [panel.leading, tip], [trailing, tip], [trailing, 0.0]];
            return self.add(ShapePart::Wing, corners.map(|[x, y]| [x, side * y, panel.z]));
        }
        for own in &aircraft.wing_panels {
            let (root, tip) = (side * own.root_y_m, side * (own.root_y_m + own.semispan_m));
            let corners = [
                [own.root_leading_edge_x_m, root],
                [own.tip_leading_edge_x_m, tip],
                [own.tip_leading_edge_x_m + own.taper * own.root_chord_m, tip],
                [own.root_leading_edge_x_m + own.root_chord_m, root],
            ];
            self.add(ShapePart::Wing, corners.map(|[x, y]| [x, y, panel.z]));
        }
    }

    /// The moving rear of a surface between two places of the span, its trailing edge down by an angle.
    fn flap(&mut self, panel: &Panel, [from, to]: [f64; 2], down_rad: f64, taper: f64) {
        let length = MOVING * panel.chord * taper;
        let hinge = panel.leading + panel.chord * (1.0 + taper) / 2.0 - length;
        let (sin, cos) = down_rad.sin_cos();
        let (trailing, low) = (hinge + length * cos, panel.z - length * sin);
        let corners = [[hinge, from, panel.z], [hinge, to, panel.z], [trailing, to, low], [trailing, from, low]];
        self.add(ShapePart::Control, corners);
    }

    /// The fin with its rudder, trailing edge left by an angle.
    fn fin(&mut self, tail: &Panel, height: f64, left_rad: f64) {
        let top = tail.z + height;
        let hinge = tail.leading + (1.0 - MOVING) * tail.chord;
        let swept = tail.leading + 0.4 * tail.chord;
        self.add(
            ShapePart::Tail,
            [[tail.leading, 0.0, tail.z], [swept, 0.0, top], [hinge, 0.0, top], [hinge, 0.0, tail.z]],
        );
        let length = MOVING * tail.chord;
        let (sin, cos) = left_rad.sin_cos();
        let (trailing, y) = (hinge + length * cos, -length * sin);
        self.add(
            ShapePart::Control,
            [[hinge, 0.0, tail.z], [hinge, 0.0, top], [trailing, y, top], [trailing, y, tail.z]],
        );
    }
}

/// Turns points of body axes into local Earth axes (north, east, down) by bank, pitch and heading, rad.
pub fn ned_from_body([phi, theta, psi]: [f64; 3]) -> impl Fn([f64; 3]) -> [f64; 3] {
    let turn = body_from_ned(phi, theta, psi).inverse();
    move |point| (turn * Vector3::from(point)).into()
}
