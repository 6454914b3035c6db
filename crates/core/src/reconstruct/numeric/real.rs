//! The number the packed filter is written over: one `f64`, or a vector of them with one manoeuvre per lane.
//!
//! Everything here is inlined into the entry points of `packed::dispatch`, which alone enable vector instructions. Hence
//! plain functions and loops: a closure would be compiled without them.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or several side by side that undergo the same operations.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Its numbers in memory, an array with one for each lane.
    type Lanes: Copy + Default + AsRef<[f64]> + AsMut<[f64]>;

    /// The same value in every lane.
    fn splat(value: f64) -> Self;

    /// The numbers at a place in memory.
    fn load(values: &Self::Lanes) -> Self;

    /// Writes the numbers to a place in memory.
    fn store(self, into: &mut Self::Lanes);

    /// `self * factor + term`, fused where the machine can.
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// `term - self * factor`, fused where the machine can.
    fn neg_mul_add(self, factor: Self, term: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// `above` in lanes where `self > limit`, `other` elsewhere, also where a comparison is undefined.
    fn select_above(self, limit: Self, above: Self, other: Self) -> Self;

    /// Whether `self > limit` in any lane.
    fn any_above(self, limit: Self) -> bool;

    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// Magnitude.
    #[inline(always)]
    fn abs(self) -> Self {
        self.select_above(Self::zero(), self, -self)
    }

    /// The smaller of two; the second where either is not a number.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        other.select_above(self, self, other)
    }

    /// Nearest integer, ties to even, for magnitudes below 2^51.
    #[inline(always)]
    fn round(self) -> Self {
        let shift = Self::splat(6_755_399_441_055_744.0); // 1.5 * 2^52: adding it leaves no bits for a fraction
        (self + shift) - shift
    }

    /// An angle, rad, brought into [-pi, pi] by whole turns.
    #[inline(always)]
    fn wrapped(self) -> Self {
        let turns = (self * Self::splat(1.0 / std::f64::consts::TAU)).round();
        turns.neg_mul_add(Self::splat(std::f64::consts::TAU), self)
    }

    /// Sine and cosine of an angle, rad, to 2e-16 for magnitudes below 1e5: reduction to an eighth of a turn, then the
    /// minimax polynomials of Moshier's Cephes library.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let quarters = (self * Self::splat(std::f64::consts::FRAC_2_PI)).round();
        // pi/2 in three parts, the first two short enough that their products with `quarters` are exact.
        let x = quarters.neg_mul_add(Self::splat(2.0 * 7.853_981_256_484_985_351_56e-1), self);
        let x = quarters.neg_mul_add(Self::splat(2.0 * 3.774_894_707_930_798_176_68e-8), x);
        let x = quarters.neg_mul_add(Self::splat(2.0 * 2.695_151_429_079_059_526_45e-15), x);
        let z = x * x;
        let sin = polynomial(z, &SIN).mul_add(x * z, x);
        let cos = polynomial(z, &COS).mul_add(z * z, z.neg_mul_add(Self::splat(0.5), Self::splat(1.0)));

        // quadrant is -2, -1, 0, 1 or 2
        let quadrant = (quarters * Self::splat(0.25)).round().neg_mul_add(Self::splat(4.0), quarters);
        let half = Self::splat(0.5);
        let evenness = (quadrant.abs() - Self::splat(1.0)).abs();
        let (first, second) = (evenness.select_above(half, sin, cos), evenness.select_above(half, cos, sin));
        let mirrored = Self::splat(1.5);
        let sin = quadrant.select_above(mirrored, -first, (-half).select_above(quadrant, -first, first));
        let cos = quadrant.select_above(half, -second, (-mirrored).select_above(quadrant, -second, second));
        (sin, cos)
    }

    /// Angle of the point (`x`, `self`), rad, in [-pi, pi], to 4e-16: reduction below tan(pi/8), then the rational
    /// approximation of Moshier's Cephes library. Not a number at the origin.
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let zero = Self::zero();
        let (rise, run) = (self.abs(), x.abs());
        let (least, most) = (rise.select_above(run, run, rise), rise.select_above(run, rise, run));
        let limit = most * Self::splat(std::f64::consts::SQRT_2 - 1.0);
        let t = least.select_above(limit, least - most, least) / least.select_above(limit, least + most, most);
        let base = least.select_above(limit, Self::splat(std::f64::consts::FRAC_PI_4), zero);
        let z = t * t;
        let ratio = z * polynomial(z, &ATAN_NUMERATOR) / polynomial(z, &ATAN_DENOMINATOR);
        let angle = base + ratio.mul_add(t, t);
        let angle = rise.select_above(run, Self::splat(std::f64::consts::FRAC_PI_2) - angle, angle);
        let angle = zero.select_above(x, Self::splat(std::f64::consts::PI) - angle, angle);
        zero.select_above(self, -angle, angle)
    }
}

const SIN: [f64; 6] = [
    1.589_623_015_765_465_680_60e-10,
    -2.505_074_776_285_780_728_66e-8,
    2.755_731_362_138_572_452_13e-6,
    -1.984_126_982_958_953_859_96e-4,
    8.333_333_333_322_118_588_78e-3,
    -1.666_666_666_666_663_072_95e-1,
];
const COS: [f64; 6] = [
    -1.135_853_652_138_768_173_00e-11,
    2.087_570_084_197_473_167_78e-9,
    -2.755_731_417_929_673_881_12e-7,
    2.480_158_728_885_170_453_48e-5,
    -1.388_888_888_887_305_641_16e-3,
    4.166_666_666_666_659_292_18e-2,
];
const ATAN_NUMERATOR: [f64; 5] = [
    -8.750_608_600_031_904_122_785e-1,
    -1.615_753_718_733_365_076_637e1,
    -7.500_855_792_314_704_667_340e1,
    -1.228_866_684_490_136_173_410e2,
    -6.485_021_904_942_025_371_773e1,
];
const ATAN_DENOMINATOR: [f64; 6] = [
    1.0,
    2.485_846_490_142_306_297_962e1,
    1.650_270_098_316_988_542_046e2,
    4.328_810_604_912_902_668_951e2,
    4.853_903_996_359_136_964_868e2,
    1.945_506_571_482_613_964_425e2,
];

/// Polynomial in `x`, highest power first.
#[inline(always)]
fn polynomial<T: Real, const N: usize>(x: T, coefficients: &[f64; N]) -> T {
    let mut sum = T::splat(coefficients[0]);
    for k in 1..N {
        sum = sum.mul_add(x, T::splat(coefficients[k]));
    }
    sum
}

impl Real for f64 {
    type Lanes = [f64; 1];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn load(values: &[f64; 1]) -> Self {
        values[0]
    }

    #[inline(always)]
    fn store(self, into: &mut [f64; 1]) {
        into[0] = self;
    }

    // Not `f64::mul_add`: without the instruction that is a slow library call.
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        term - self * factor
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn select_above(self, limit: Self, above: Self, other: Self) -> Self {
        if self > limit { above } else { other }
    }

    #[inline(always)]
    fn any_above(self, limit: Self) -> bool {
        self > limit
    }
}

#[cfg(test)]
mod tests {
    use super::Real;

    /// Rounding of the last place or two, over angles of a few turns.
    const ROUNDING: f64 = 6e-16;

    #[test]
    fn sine_and_cosine_match_the_standard_library() {
        for k in -20_000..20_000 {
            let angle = f64::from(k) * 1.7e-3;
            let (sin, cos) = Real::sin_cos(angle);
            assert!((sin - angle.sin()).abs() < ROUNDING && (cos - angle.cos()).abs() < ROUNDING, "{angle}");
        }
    }

    #[test]
    fn arctangent_matches_the_standard_library_in_every_quadrant() {
        for k in 0..10_000 {
            let (y, x) = (f64::from(k) * 6e-4 - 3.0).sin_cos();
            let (y, x) = (y * 80.0, x * 80.0);
            assert!((Real::atan2(y, x) - f64::atan2(y, x)).abs() < 2.0 * ROUNDING, "{y} {x}");
        }
    }

    #[test]
    fn wrapping_takes_whole_turns_off() {
        assert!((Real::wrapped(6.0_f64) - (6.0 - std::f64::consts::TAU)).abs() < ROUNDING);
        assert!((Real::wrapped(-0.3_f64) + 0.3).abs() < ROUNDING);
    }
}
