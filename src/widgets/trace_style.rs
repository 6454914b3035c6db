//! How the curves of time plots are drawn.

use super::chart::LegendMark;

/// How a trace is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceStyle {
    /// Unbroken line.
    Line,
    /// Dashed line, for references and truth.
    Dashed,
    /// One dot per sample, for measurements under a fit.
    Dots,
    /// One cross per sample, for what was left out.
    Crosses,
}

impl TraceStyle {
    /// Whether each sample is drawn by itself, without a line.
    pub(super) fn is_points(self) -> bool {
        matches!(self, Self::Dots | Self::Crosses)
    }

    /// Its mark in a legend.
    pub(super) fn legend(self) -> LegendMark {
        match self {
            Self::Line => LegendMark::Line,
            Self::Dashed => LegendMark::Dashed,
            Self::Dots | Self::Crosses => LegendMark::Dots,
        }
    }
}
