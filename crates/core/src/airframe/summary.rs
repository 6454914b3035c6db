//! What there is to say about an aircraft as loaded.

use std::fmt;

use super::MassProperties;
use super::aircraft::{Aircraft, ReferenceGeometry};
use super::envelope::EnvelopeMargin;
use super::geometry::MeanChord;
use super::inertia::InertiaModel;
use super::loading::{Loading, LoadingIssue};
use super::statistics::ComponentFraction;
use super::tensor::{InertiaTensor, PrincipalAxes};

/// An aircraft's numbers in one place. `Display` writes them as the lines of `doublet check`.
#[derive(Clone, Debug, PartialEq)]
pub struct AircraftSummary {
    /// Name.
    pub name: String,
    /// Reference geometry.
    pub reference: ReferenceGeometry,
    /// Mean aerodynamic chord, where known.
    pub mean_chord: Option<MeanChord>,
    /// The empty aircraft, then the aircraft in its standard loading.
    pub states: Vec<LoadedState>,
    /// Component groups beside the statistics of comparable aircraft.
    pub components: Vec<ComponentComparison>,
    /// Findings worth knowing, one line each.
    pub findings: Vec<String>,
    /// The file's own notes.
    pub notes: Vec<String>,
}

/// A component group's mass beside the statistics of comparable aircraft, as fractions of the maximum take-off mass.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentComparison {
    /// Statistics and attributed mass.
    pub component: ComponentFraction,
    /// Attributed mass over maximum take-off mass.
    pub fraction: f64,
    /// Distance from the statistical mean in its standard deviations.
    pub standard_score: Option<f64>,
}

/// Mass properties of one loading and what they mean.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedState {
    /// Name of the loading.
    pub name: String,
    /// Mass, centre of gravity, inertia.
    pub properties: MassProperties,
    /// What is wrong with the loading, each bound to its field.
    pub warnings: Vec<LoadingIssue>,
    /// Centre of gravity as a fraction of the mean aerodynamic chord.
    pub mean_chord_fraction: Option<f64>,
    /// Margins in the envelope.
    pub envelope: Option<EnvelopeMargin>,
    /// Principal moments and axes of inertia.
    pub principal: Option<PrincipalAxes>,
    /// Class I estimate of the inertia from radii of gyration.
    pub class_one: Option<InertiaTensor>,
}

impl LoadedState {
    /// The numbers of `aircraft` with `loading` on board.
    pub fn new(name: &str, aircraft: &Aircraft, loading: &Loading) -> Self {
        let properties = loading.mass_properties(aircraft);
        let (mass_kg, x_m) = (properties.mass_kg, properties.cg_from_datum_m[0]);
        Self {
            name: name.to_owned(),
            mean_chord_fraction: aircraft.mean_chord().map(|chord| chord.fraction(x_m)),
            envelope: aircraft.envelope.as_ref().and_then(|envelope| envelope.margin(mass_kg, x_m)),
            principal: properties.inertia.principal_axes(),
            class_one: aircraft.gyration_radii.map(|radii| radii.inertia(mass_kg, aircraft.reference.span_m)),
            warnings: loading.issues(aircraft, &properties),
            properties,
        }
    }
}

/// Summary of an aircraft, empty and in its standard loading.
pub fn summary(aircraft: &Aircraft) -> AircraftSummary {
    let mut states = vec![LoadedState::new("empty", aircraft, &Loading::default())];
    if aircraft.standard_loading != Loading::default() {
        states.push(LoadedState::new("standard loading", aircraft, &aircraft.standard_loading));
    }
    AircraftSummary {
        name: aircraft.name.clone(),
        reference: aircraft.reference,
        mean_chord: aircraft.mean_chord(),
        states,
        components: component_comparisons(aircraft),
        findings: group_finding(aircraft).into_iter().collect(),
        notes: aircraft.notes.clone(),
    }
}

/// Every component group beside its statistics; none where the maximum take-off mass is not known.
fn component_comparisons(aircraft: &Aircraft) -> Vec<ComponentComparison> {
    let Some(takeoff_kg) = aircraft.limits.max_takeoff_kg else { return Vec::new() };
    let compare = |component: &ComponentFraction| ComponentComparison {
        component: component.clone(),
        fraction: component.attributed_kg / takeoff_kg,
        standard_score: component.standard_score(takeoff_kg),
    };
    aircraft.component_fractions.iter().map(compare).collect()
}

/// How the component groups' mass and centroid compare with those of the empty aircraft.
fn group_finding(aircraft: &Aircraft) -> Option<String> {
    let InertiaModel::Groups { groups, .. } = &aircraft.inertia else { return None };
    let mass_kg: f64 = groups.iter().map(|group| group.mass_kg).sum();
    let centroid: [f64; 3] = std::array::from_fn(|axis| {
        groups.iter().map(|group| group.mass_kg * group.centroid_from_datum_m[axis]).sum::<f64>() / mass_kg
    });
    let empty = &aircraft.empty;
    let offset: [f64; 3] = std::array::from_fn(|axis| centroid[axis] - empty.cg_from_datum_m[axis]);
    let added = InertiaTensor::point_mass(mass_kg, offset);
    Some(format!(
        "component groups weigh {mass_kg:.1} kg of {:.1} kg empty; their centroid lies ({:+.3}, {:+.3}, {:+.3}) m from the empty \
         centre of gravity (aft, right, up), which adds ({:.0}, {:.0}, {:.0}) kg m2 to the moments of inertia",
        empty.mass_kg, offset[0], offset[1], offset[2], added.xx, added.yy, added.zz
    ))
}

impl fmt::Display for AircraftSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.name)?;
        let reference = &self.reference;
        writeln!(
            f,
            "  reference         S {:.3} m2, b {:.3} m, c {:.4} m, aspect ratio {:.3}",
            reference.area_m2,
            reference.span_m,
            reference.chord_m,
            reference.aspect_ratio()
        )?;
        if let Some(chord) = &self.mean_chord {
            writeln!(
                f,
                "  mean chord        {:.3} m, leading edge at x {:.3} m, at y {:.3} m",
                chord.chord_m, chord.leading_edge_x_m, chord.y_m
            )?;
        }
        for state in &self.states {
            write!(f, "{state}")?;
        }
        for comparison in &self.components {
            write!(f, "{comparison}")?;
        }
        for finding in &self.findings {
            writeln!(f, "  finding           {finding}")?;
        }
        for note in &self.notes {
            writeln!(f, "  note              {note}")?;
        }
        Ok(())
    }
}

impl fmt::Display for ComponentComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = &self.component;
        write!(
            f,
            "  component         {}: {:.1} kg, {:.1} % of the maximum; comparable aircraft {:.1} +- {:.1} %",
            part.name,
            part.attributed_kg,
            self.fraction * 100.0,
            part.mean * 100.0,
            part.deviation * 100.0
        )?;
        for (method, fraction) in &part.methods {
            write!(f, ", {method} {:.1} %", fraction * 100.0)?;
        }
        writeln!(f)
    }
}

impl fmt::Display for LoadedState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MassProperties { mass_kg, cg_from_datum_m: [x, y, z], inertia } = &self.properties;
        writeln!(f, "{}", self.name)?;
        writeln!(f, "  mass              {mass_kg:.1} kg")?;
        write!(f, "  centre of gravity x {x:.3} m, y {y:.3} m, z {z:.3} m from the datum")?;
        match self.mean_chord_fraction {
            Some(fraction) => writeln!(f, ", {:.1} % MAC", fraction * 100.0)?,
            None => writeln!(f)?,
        }
        if let Some(margin) = &self.envelope {
            writeln!(
                f,
                "  envelope          {}: {:+.1} mm to the forward limit, {:+.1} mm to the aft limit, {:+.1} kg to the heaviest; \
                 nearest corner {:.0} kg at x {:.3} m ({})",
                if margin.inside() { "inside" } else { "OUTSIDE" },
                margin.forward_m * 1000.0,
                margin.aft_m * 1000.0,
                margin.heavy_kg,
                margin.corner.0,
                margin.corner.1,
                margin.side,
            )?;
        }
        writeln!(
            f,
            "  inertia           Ixx {:.1}, Iyy {:.1}, Izz {:.1}, Ixz {:.1}, Ixy {:.1}, Iyz {:.1} kg m2",
            inertia.xx, inertia.yy, inertia.zz, inertia.xz, inertia.xy, inertia.yz
        )?;
        if let Some(principal) = &self.principal {
            let [a, b, c] = principal.moments_kg_m2;
            let pitch_deg = principal.pitch_rad.to_degrees();
            writeln!(
                f,
                "  principal axes    {a:.1}, {b:.1}, {c:.1} kg m2; x axis {:.2} deg {} body x",
                pitch_deg.abs(),
                if pitch_deg < 0.0 { "below" } else { "above" }
            )?;
        }
        if let Some(estimate) = &self.class_one {
            let ratio = |own: f64, statistical: f64| (statistical / own - 1.0) * 100.0;
            writeln!(
                f,
                "  class I estimate  Ixx {:.1} ({:+.0} %), Iyy {:.1} ({:+.0} %), Izz {:.1} kg m2 ({:+.0} %)",
                estimate.xx,
                ratio(inertia.xx, estimate.xx),
                estimate.yy,
                ratio(inertia.yy, estimate.yy),
                estimate.zz,
                ratio(inertia.zz, estimate.zz)
            )?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning           {warning}")?;
        }
        Ok(())
    }
}
