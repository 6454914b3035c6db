//! A designed input: deflections against time.

/// Controls of a design: aileron, elevator, rudder, and the throttle, whose input is the sum of the thrusts.
pub const CONTROLS: usize = 4;
/// Place of the throttle.
pub const THROTTLE: usize = 3;

/// Deflections of aileron, elevator and rudder about the trim, rad, and the change of the thrust, N: straight lines between nodes, zero before
/// the first and behind the last. Two nodes at one time are a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Input {
    time_s: Vec<f64>,
    deflections_rad: Vec<[f64; CONTROLS]>,
}

impl Input {
    /// An input from its nodes, in order of time.
    pub fn new(nodes: impl IntoIterator<Item = (f64, [f64; CONTROLS])>) -> Self {
        let (time_s, deflections_rad) = nodes.into_iter().unzip();
        Self { time_s, deflections_rad }
    }

    /// One input of several signals, each the nodes of one control (0 aileron, 1 elevator, 2 rudder, 3 throttle): at every time at which one of
    /// them has a node the sum has one.
    pub(crate) fn of_surfaces(signals: &[(usize, Vec<(f64, f64)>)]) -> Self {
        let mut times: Vec<f64> = signals.iter().flat_map(|(_, nodes)| nodes.iter().map(|node| node.0)).collect();
        times.sort_by(f64::total_cmp);
        // A step keeps its two nodes; a time that two surfaces share is one node where neither steps.
        let steps = |time: f64| {
            signals.iter().any(|(_, nodes)| nodes.windows(2).any(|pair| pair[0].0 == time && pair[1].0 == time))
        };
        times.dedup();
        let mut nodes = Vec::with_capacity(times.len());
        for time in times {
            if steps(time) {
                nodes.push(Self::sum_at(signals, time, false));
            }
            nodes.push(Self::sum_at(signals, time, true));
        }
        Self::new(nodes)
    }

    fn sum_at(signals: &[(usize, Vec<(f64, f64)>)], time: f64, after: bool) -> (f64, [f64; CONTROLS]) {
        let mut deflections = [0.0; CONTROLS];
        for (surface, nodes) in signals {
            if let Some(deflection) = deflections.get_mut(*surface) {
                *deflection += value(nodes, time, after);
            }
        }
        (time, deflections)
    }

    /// Nodes in order of time.
    pub fn nodes(&self) -> impl Iterator<Item = (f64, [f64; CONTROLS])> + '_ {
        self.time_s.iter().copied().zip(self.deflections_rad.iter().copied())
    }

    /// Times of the nodes, s.
    pub fn times_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Deflections at a time; at a step those behind it.
    pub fn at(&self, time_s: f64) -> [f64; CONTROLS] {
        let next = self.time_s.partition_point(|&time| time <= time_s);
        self.between(next, time_s)
    }

    /// Deflections just before a time: at a step those ahead of it.
    pub fn before(&self, time_s: f64) -> [f64; CONTROLS] {
        let next = self.time_s.partition_point(|&time| time < time_s);
        self.between(next, time_s)
    }

    fn between(&self, next: usize, time_s: f64) -> [f64; CONTROLS] {
        let Some((start, from)) = next.checked_sub(1).and_then(|index| self.node(index)) else {
            return [0.0; CONTROLS];
        };
        let Some((end, to)) = self.node(next) else {
            // The last node itself still counts, nothing behind it does.
            return if time_s <= start { from } else { [0.0; CONTROLS] };
        };
        let fraction = if end > start { (time_s - start) / (end - start) } else { 0.0 };
        std::array::from_fn(|surface| from[surface] + (to[surface] - from[surface]) * fraction)
    }

    fn node(&self, index: usize) -> Option<(f64, [f64; CONTROLS])> {
        Some((*self.time_s.get(index)?, *self.deflections_rad.get(index)?))
    }

    /// Largest input of each control to either side, rad or N: that of the sum.
    pub fn peaks(&self) -> [f64; CONTROLS] {
        let mut peaks = [0.0; CONTROLS];
        for deflections in &self.deflections_rad {
            peaks.iter_mut().zip(deflections).for_each(|(peak, value)| *peak = f64::max(*peak, value.abs()));
        }
        peaks
    }

    /// Steepest slope of each control, rad/s or N/s; infinite at a step.
    pub fn rates(&self) -> [f64; CONTROLS] {
        let mut rates = [0.0; CONTROLS];
        for index in 1..self.time_s.len() {
            let Some(((start, from), (end, to))) = self.node(index - 1).zip(self.node(index)) else { continue };
            for surface in 0..CONTROLS {
                let change = (to[surface] - from[surface]).abs();
                if change > 0.0 {
                    rates[surface] = f64::max(rates[surface], change / (end - start));
                }
            }
        }
        rates
    }

    /// The input with each surface's deflection multiplied.
    #[must_use]
    pub fn scaled(&self, factors: [f64; CONTROLS]) -> Self {
        let scale =
            |deflections: &[f64; CONTROLS]| std::array::from_fn(|surface| factors[surface] * deflections[surface]);
        Self { time_s: self.time_s.clone(), deflections_rad: self.deflections_rad.iter().map(scale).collect() }
    }

    /// Time of the last node, s.
    pub fn end_s(&self) -> f64 {
        self.time_s.last().copied().unwrap_or(0.0)
    }
}

/// Value of straight lines between nodes, at a step ahead of it or behind it.
fn value(nodes: &[(f64, f64)], time_s: f64, after: bool) -> f64 {
    let next = nodes.partition_point(|node| if after { node.0 <= time_s } else { node.0 < time_s });
    let Some(&(start, from)) = next.checked_sub(1).and_then(|index| nodes.get(index)) else {
        // Ahead of a step at the first node there is nothing.
        return 0.0;
    };
    let Some(&(end, to)) = nodes.get(next) else { return if time_s <= start { from } else { 0.0 } };
    if end > start { from + (to - from) * (time_s - start) / (end - start) } else { from }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sum_of_surfaces_has_the_nodes_of_both_and_steps_stay_steps() {
        let aileron = vec![(1.0, 0.0), (1.0, 0.1), (2.0, 0.1), (2.0, 0.0)];
        let rudder = vec![(0.5, 0.0), (1.5, 0.2), (2.5, 0.0)];
        let input = Input::of_surfaces(&[(0, aileron), (2, rudder)]);
        assert_eq!(input.times_s(), [0.5, 1.0, 1.0, 1.5, 2.0, 2.0, 2.5]);
        assert_eq!(input.before(1.0), [0.0, 0.0, 0.1, 0.0]);
        assert_eq!(input.at(1.0), [0.1, 0.0, 0.1, 0.0]);
        assert_eq!(input.at(1.25), [0.1, 0.0, 0.15000000000000002, 0.0]);
        assert_eq!(input.at(2.0), [0.0, 0.0, 0.1, 0.0]);
        assert_eq!(input.at(3.0), [0.0; CONTROLS]);
        assert_eq!(input.peaks(), [0.1, 0.0, 0.2, 0.0]);
        assert_eq!(input.rates(), [f64::INFINITY, 0.0, 0.2, 0.0]);
        assert_eq!(input.scaled([2.0, 1.0, 0.5, 1.0]).peaks(), [0.2, 0.0, 0.1, 0.0]);
    }
}
