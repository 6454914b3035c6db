//! Figures of the author's choice, from the plots of the window and back.

use super::document::Figure;
use crate::session::ReportFigure;

impl ReportFigure {
    /// `figure` as it is now.
    ///
    /// # Errors
    /// One line should it have no saved form.
    pub fn from_figure(figure: &Figure) -> Result<Self, String> {
        Self::pack(&figure.caption, &figure.thinned())
    }

    /// The figure under its present caption.
    ///
    /// # Errors
    /// One line where what was saved is damaged.
    pub fn figure(&self) -> Result<Figure, String> {
        Ok(Figure { caption: self.caption.clone(), ..self.unpack()? })
    }
}
