//! A line through the lags of chunks, of which some are wrong.

/// Correction of a clock at its own time `own_s`.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// Own time, s.
    pub own_s: f64,
    /// Correction, s.
    pub value_s: f64,
    /// Standard deviation, s.
    pub sd_s: f64,
}

/// `value = intercept + slope (t - centre)`.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub centre_s: f64,
    pub intercept_s: f64,
    pub slope: f64,
    /// Variances of intercept and slope, which are independent about the centre.
    pub variance: [f64; 2],
}

impl Line {
    pub fn at(&self, own_s: f64) -> f64 {
        self.intercept_s + self.slope * (own_s - self.centre_s)
    }
}

/// Least standard deviation of a point, s: below it, interpolation between samples decides.
pub(super) const LEAST_SD_S: f64 = 1e-4;

/// Which points lie within `agreement_s` of the line through two of them that has most others near it; a level line
/// through each point where `sloped` is false. Slopes beyond `max_slope` are left out.
pub(super) fn agreeing(points: &[Point], agreement_s: f64, max_slope: f64, sloped: bool) -> Vec<bool> {
    let near = |intercept: f64, slope: f64, from: f64| -> Vec<bool> {
        points.iter().map(|p| (p.value_s - intercept - slope * (p.own_s - from)).abs() <= agreement_s).collect()
    };
    let mut best = (0.0, vec![false; points.len()]);
    let mut offer = |inside: Vec<bool>, distance: f64| {
        // Ties go to the line that is nearer to its points.
        let merit = inside.iter().filter(|&&used| used).count() as f64 - distance.min(0.5);
        if merit > best.0 {
            best = (merit, inside);
        }
    };
    for (i, p) in points.iter().enumerate() {
        if !sloped {
            let inside = near(p.value_s, 0.0, 0.0);
            let distance = sum_distances(points, &inside, p.value_s, 0.0, 0.0);
            offer(inside, distance);
            continue;
        }
        for q in &points[i + 1..] {
            let slope = (q.value_s - p.value_s) / (q.own_s - p.own_s);
            if slope.abs() <= max_slope {
                let inside = near(p.value_s, slope, p.own_s);
                let distance = sum_distances(points, &inside, p.value_s, slope, p.own_s);
                offer(inside, distance);
            }
        }
    }
    best.1
}

fn sum_distances(points: &[Point], inside: &[bool], intercept: f64, slope: f64, from: f64) -> f64 {
    points
        .iter()
        .zip(inside)
        .filter(|(_, used)| **used)
        .map(|(p, _)| (p.value_s - intercept - slope * (p.own_s - from)).abs())
        .sum()
}

/// Points beyond the line's own unknowns from which their scatter tells their variance.
const ENOUGH: usize = 5;

/// Weighted least-squares line through the points marked `used`. Variances are those of the points scaled to their scatter
/// about the line; with few points, only widened by it.
pub(super) fn weighted_line(points: &[Point], used: &[bool], sloped: bool) -> Option<Line> {
    let kept: Vec<Point> = points.iter().zip(used).filter(|(_, used)| **used).map(|(point, _)| *point).collect();
    let weight = |p: &Point| 1.0 / p.sd_s.max(LEAST_SD_S).powi(2);
    let total: f64 = kept.iter().map(weight).sum();
    let free = usize::from(sloped) + 1;
    if kept.len() < free {
        return None;
    }
    let centre_s = kept.iter().map(|p| weight(p) * p.own_s).sum::<f64>() / total;
    let intercept_s = kept.iter().map(|p| weight(p) * p.value_s).sum::<f64>() / total;
    let moment: f64 = kept.iter().map(|p| weight(p) * (p.own_s - centre_s).powi(2)).sum();
    let slope = if sloped {
        kept.iter().map(|p| weight(p) * (p.own_s - centre_s) * (p.value_s - intercept_s)).sum::<f64>() / moment
    } else {
        0.0
    };
    let mut line = Line { centre_s, intercept_s, slope, variance: [0.0; 2] };
    let squares: f64 = kept.iter().map(|p| weight(p) * (p.value_s - line.at(p.own_s)).powi(2)).sum();
    let beyond = kept.len() - free;
    let scatter = squares / beyond.max(1) as f64;
    let scale = if beyond >= ENOUGH { scatter } else { scatter.max(1.0) };
    line.variance = [scale / total, if sloped { scale / moment } else { 0.0 }];
    line.slope.is_finite().then_some(line)
}
