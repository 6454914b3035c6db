//! Inertia of component groups by shape, and of the whole about its centre of gravity.

use serde::Deserialize;

use super::aircraft::FixedItem;
use super::frames::body_from_datum;
use super::tensor::InertiaTensor;

/// A body axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Forward.
    X,
    /// Right.
    Y,
    /// Down.
    Z,
}

/// How the inertia of a body about its own centre of gravity follows from its mass and shape. Body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OwnInertia {
    /// All mass in one point: no inertia of its own.
    Point,
    /// A stated tensor at a stated mass, in proportion to mass otherwise: a shell of uniform thickness, a filled tank, a person.
    Given {
        /// Tensor at `at_mass_kg`.
        tensor: InertiaTensor,
        /// Mass the tensor is stated for, kg.
        at_mass_kg: f64,
    },
    /// Slender rod: `m L^2 / 12` about both axes across it.
    Rod {
        /// Length, m.
        length_m: f64,
        /// Direction.
        along: Axis,
    },
    /// Homogeneous cuboid: `Ixx = m (w^2 + h^2) / 12` and companions.
    Cuboid {
        /// Extent along x, m.
        length_m: f64,
        /// Extent along y, m.
        width_m: f64,
        /// Extent along z, m.
        height_m: f64,
    },
    /// Propeller of three or more equal slender blades turning about x: `Ixx = m R^2 / 3`, `Iyy = Izz = m R^2 / 6`.
    Propeller {
        /// Blade tip radius, m.
        radius_m: f64,
    },
}

impl OwnInertia {
    /// Inertia about the own centre of gravity of a body of this shape and mass (kg).
    pub fn tensor(&self, mass_kg: f64) -> InertiaTensor {
        match *self {
            Self::Point => InertiaTensor::default(),
            Self::Given { tensor, at_mass_kg } => tensor.scaled(mass_kg / at_mass_kg),
            Self::Rod { length_m, along } => {
                let across = mass_kg * length_m * length_m / 12.0;
                match along {
                    Axis::X => InertiaTensor::diagonal(0.0, across, across),
                    Axis::Y => InertiaTensor::diagonal(across, 0.0, across),
                    Axis::Z => InertiaTensor::diagonal(across, across, 0.0),
                }
            }
            Self::Cuboid { length_m: l, width_m: w, height_m: h } => {
                let k = mass_kg / 12.0;
                InertiaTensor::diagonal(k * (w * w + h * h), k * (l * l + h * h), k * (l * l + w * w))
            }
            Self::Propeller { radius_m } => {
                let axial = mass_kg * radius_m * radius_m / 3.0;
                InertiaTensor::diagonal(axial, axial / 2.0, axial / 2.0)
            }
        }
    }
}

/// A component group of the empty aircraft.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct InertiaGroup {
    pub name: String,
    pub mass_kg: f64,
    pub centroid_from_datum_m: [f64; 3],
    /// Inertia about the centroid.
    pub inertia: OwnInertia,
}

impl InertiaGroup {
    /// Inertia about a point (m from the datum), body axes: own inertia and the parallel-axis terms (thesis Eq. 5.8-5.9).
    pub fn about(&self, point_from_datum_m: [f64; 3]) -> InertiaTensor {
        let offset = body_from_datum(self.centroid_from_datum_m, point_from_datum_m);
        self.inertia.tensor(self.mass_kg) + InertiaTensor::point_mass(self.mass_kg, offset)
    }
}

/// Inertia of the empty aircraft.
#[derive(Clone, Debug, PartialEq)]
pub enum InertiaModel {
    /// A tensor about the centre of gravity of the empty aircraft, body axes.
    Constant(InertiaTensor),
    /// Component groups.
    Groups {
        /// The groups.
        groups: Vec<InertiaGroup>,
        /// Sum of the groups' own products of inertia that their `inertia` does not hold, body axes.
        own_products: InertiaTensor,
    },
}

impl InertiaModel {
    /// Inertia of the empty aircraft about a point (m from the datum), body axes.
    pub fn about(&self, empty: &FixedItem, point_from_datum_m: [f64; 3]) -> InertiaTensor {
        match self {
            Self::Constant(tensor) => {
                let offset = body_from_datum(empty.cg_from_datum_m, point_from_datum_m);
                *tensor + InertiaTensor::point_mass(empty.mass_kg, offset)
            }
            Self::Groups { groups, own_products } => {
                groups.iter().fold(*own_products, |sum, group| sum + group.about(point_from_datum_m))
            }
        }
    }
}
