//! Figures of the author's choice, from the plots of the window and back.

use super::document::Figure;
use crate::session::ReportFigure;

impl ReportFigure {
    /// `figure` as it is now.
    pub fn from_figure(figure: &Figure) -> Result<Self, String> {
        Self::pack(&figure.caption, &figure.thinned())
    }

    /// The figure under its present caption.
    pub fn figure(&self) -> Result<Figure, String> {
        Ok(Figure { caption: self.caption.clone(), ..self.unpack()? })
    }
}
