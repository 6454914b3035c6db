//! Inertia tensor: parallel axis, plausibility, principal axes.

use nalgebra::{Matrix3, SymmetricEigen, U3};
use serde::Serialize;
use thiserror::Error;

/// Moments and products of inertia in body axes, kg m².
///
/// Products carry their positive sign, `xz = integral of x z dm`, so the matrix holds `-xz` off its diagonal
/// (thesis Eq. 5.7; `docs/conventions.md`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct InertiaTensor {
    /// Moment about x, kg m².
    #[serde(rename = "ixx_kg_m2")]
    pub xx: f64,
    /// Moment about y, kg m².
    #[serde(rename = "iyy_kg_m2")]
    pub yy: f64,
    /// Moment about z, kg m².
    #[serde(rename = "izz_kg_m2")]
    pub zz: f64,
    /// Product of inertia, integral of x z dm, kg m².
    #[serde(rename = "ixz_kg_m2")]
    pub xz: f64,
    /// Product of inertia, integral of x y dm, kg m²; zero for a symmetric aircraft.
    #[serde(rename = "ixy_kg_m2")]
    pub xy: f64,
    /// Product of inertia, integral of y z dm, kg m²; zero for a symmetric aircraft.
    #[serde(rename = "iyz_kg_m2")]
    pub yz: f64,
}

/// Why no body can have this inertia tensor.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum InertiaError {
    #[error("an entry of the inertia tensor is not a finite number")]
    NotFinite,
    #[error("smallest principal moment of inertia is {smallest_kg_m2:.3} kg m2, allowed is above 0")]
    NotPositive { smallest_kg_m2: f64 },
    #[error(
        "largest principal moment of inertia is {largest_kg_m2:.1} kg m2, \
         allowed is at most the sum of the other two, {others_kg_m2:.1} kg m2"
    )]
    Triangle { largest_kg_m2: f64, others_kg_m2: f64 },
}

/// Principal moments of inertia and their axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalAxes {
    /// Principal moments, ordered by the body axis each is nearest to, kg m².
    pub moments_kg_m2: [f64; 3],
    /// Columns are the principal axes in body axes; right-handed, each pointing along its body axis.
    pub body_from_principal: Matrix3<f64>,
    /// Angle from body x to the principal x axis in the plane of symmetry, positive nose-up, rad.
    pub pitch_rad: f64,
}

/// Relative slack of the triangle inequality: a flat plate meets it with equality, so round-off must not refuse one.
const TRIANGLE_SLACK: f64 = 1e-9;
/// Part by which published principal moments may break the triangle inequality: those of different loadings or to two digits do.
pub const PUBLISHED_SLACK: f64 = 0.05;
/// Sweeps after which an eigenvalue iteration is given up; a symmetric 3 x 3 matrix needs fewer than ten.
const EIGEN_ITERATIONS: usize = 100;

impl InertiaTensor {
    /// A tensor without products of inertia, kg m².
    pub const fn diagonal(xx: f64, yy: f64, zz: f64) -> Self {
        Self { xx, yy, zz, xz: 0.0, xy: 0.0, yz: 0.0 }
    }

    /// The symmetric matrix of thesis Eq. 5.7, `[[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]]`, kg m².
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::new(
            self.xx, -self.xy, -self.xz, //
            -self.xy, self.yy, -self.yz, //
            -self.xz, -self.yz, self.zz,
        )
    }

    /// Inertia of a point mass (kg) at an offset (m, body axes) from the point of reference: the terms that the parallel
    /// axis theorem adds.
    ///
    /// `Ixx += m (y^2 + z^2)`, `Ixz += m x z` and their companions (thesis Eq. 5.8-5.9).
    pub fn point_mass(mass_kg: f64, offset_body_m: [f64; 3]) -> Self {
        let [x, y, z] = offset_body_m;
        Self {
            xx: mass_kg * (y * y + z * z),
            yy: mass_kg * (x * x + z * z),
            zz: mass_kg * (x * x + y * y),
            xz: mass_kg * x * z,
            xy: mass_kg * x * y,
            yz: mass_kg * y * z,
        }
    }

    /// This tensor times a factor: the inertia of a body whose mass grows by it at unchanged shape.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            xx: self.xx * factor,
            yy: self.yy * factor,
            zz: self.zz * factor,
            xz: self.xz * factor,
            xy: self.xy * factor,
            yz: self.yz * factor,
        }
    }

    /// Eigenvalues and eigenvectors of [`Self::matrix`]; `None` where an entry is not finite.
    fn eigen(&self) -> Option<SymmetricEigen<f64, U3>> {
        let matrix = self.matrix();
        let finite = matrix.iter().all(|entry| entry.is_finite());
        finite.then(|| SymmetricEigen::try_new(matrix, f64::EPSILON, EIGEN_ITERATIONS)).flatten()
    }

    /// Whether an aircraft may be computed with this tensor: finite, positive definite, and no principal moment above the sum of the
    /// others by more than a twentieth.
    ///
    /// # Errors
    /// [`InertiaError`] with the numbers that contradict.
    pub fn check(&self) -> Result<(), InertiaError> {
        let [smallest, ..] = self.check_part(PUBLISHED_SLACK)?;
        if smallest > 0.0 { Ok(()) } else { Err(InertiaError::NotPositive { smallest_kg_m2: smallest }) }
    }

    /// Part by which the largest principal moment exceeds the sum of the others, which that of no body does; none where it does not.
    pub fn triangle_excess(&self) -> Option<f64> {
        let moments: [f64; 3] = self.eigen()?.eigenvalues.into();
        let largest = moments.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let excess = largest / (moments.iter().sum::<f64>() - largest) - 1.0;
        (excess > TRIANGLE_SLACK).then_some(excess)
    }

    /// Principal moments, smallest first, where a part of a body can have this tensor: a moment may be zero (a slender rod),
    /// and the largest may exceed the sum of the others by the fraction `slack` (printed moments are rounded).
    pub(super) fn check_part(&self, slack: f64) -> Result<[f64; 3], InertiaError> {
        let eigen = self.eigen().ok_or(InertiaError::NotFinite)?;
        let mut moments: [f64; 3] = eigen.eigenvalues.into();
        moments.sort_by(f64::total_cmp);
        let [smallest, middle, largest] = moments;
        if smallest < -slack * largest.abs() {
            return Err(InertiaError::NotPositive { smallest_kg_m2: smallest });
        }
        if largest > (smallest + middle) * (1.0 + slack) {
            return Err(InertiaError::Triangle { largest_kg_m2: largest, others_kg_m2: smallest + middle });
        }
        Ok(moments)
    }

    /// Principal moments and axes, by the eigenvectors of [`Self::matrix`]; `None` where an entry is not finite.
    pub fn principal_axes(&self) -> Option<PrincipalAxes> {
        let eigen = self.eigen()?;
        let order = nearest_axes(&eigen.eigenvectors);
        let mut axes = Matrix3::zeros();
        for (axis, &column) in order.iter().enumerate() {
            let vector = eigen.eigenvectors.column(column);
            axes.set_column(axis, &(vector * vector[axis].signum()));
        }
        if axes.determinant() < 0.0 {
            axes.set_column(2, &(-axes.column(2)));
        }
        Some(PrincipalAxes {
            moments_kg_m2: order.map(|column| eigen.eigenvalues[column]),
            pitch_rad: (-axes[(2, 0)]).atan2(axes[(0, 0)]),
            body_from_principal: axes,
        })
    }
}

/// Assignment of eigenvector columns to body axes that maximises the sum of the absolute cosines.
fn nearest_axes(vectors: &Matrix3<f64>) -> [usize; 3] {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let cosines = |order: &[usize; 3]| (0..3).map(|axis| vectors[(axis, order[axis])].abs()).sum::<f64>();
    ORDERS.into_iter().max_by(|a, b| cosines(a).total_cmp(&cosines(b))).unwrap_or(ORDERS[0])
}

impl std::ops::Add for InertiaTensor {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xz: self.xz + other.xz,
            xy: self.xy + other.xy,
            yz: self.yz + other.yz,
        }
    }
}

impl std::ops::AddAssign for InertiaTensor {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
