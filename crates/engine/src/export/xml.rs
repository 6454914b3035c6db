//! XML as text: elements, attributes, what follows in order.

use std::io::Write;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::ExportError;

/// An XML document under construction.
pub struct Document {
    writer: Writer<Vec<u8>>,
}

impl Document {
    /// An empty document with its declaration.
    pub fn new() -> Result<Self, ExportError> {
        let mut document = Self { writer: Writer::new_with_indent(Vec::new(), b' ', 2) };
        document.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(document)
    }

    fn event(&mut self, event: Event<'_>) -> Result<(), ExportError> {
        self.writer.write_event(event).map_err(|error| ExportError::Xml(error.to_string()))
    }

    /// A document type.
    pub(crate) fn doctype(&mut self, text: &str) -> Result<(), ExportError> {
        self.event(Event::DocType(BytesText::from_escaped(text)))
    }

    /// A comment; two hyphens in a row, which XML forbids in one, become one.
    pub fn comment(&mut self, text: &str) -> Result<(), ExportError> {
        let mut text = text.replace("--", "-");
        while text.contains("--") {
            text = text.replace("--", "-");
        }
        self.event(Event::Comment(BytesText::from_escaped(format!(" {} ", text.trim_end_matches('-')))))
    }

    /// An element with attributes and what `content` writes into it.
    pub fn element(
        &mut self,
        name: &str,
        attributes: &[(&str, &str)],
        content: impl FnOnce(&mut Self) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let start = self.start(name, attributes);
        self.event(Event::Start(start))?;
        content(self)?;
        self.event(Event::End(quick_xml::events::BytesEnd::new(name)))
    }

    /// An element with nothing in it.
    pub fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) -> Result<(), ExportError> {
        let start = self.start(name, attributes);
        self.event(Event::Empty(start))
    }

    /// An element with text.
    pub fn text(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) -> Result<(), ExportError> {
        let start = self.start(name, attributes);
        self.event(Event::Start(start))?;
        self.event(Event::Text(BytesText::new(text)))?;
        self.event(Event::End(quick_xml::events::BytesEnd::new(name)))
    }

    /// An element with a number, all digits of it.
    pub fn number(&mut self, name: &str, value: f64) -> Result<(), ExportError> {
        self.text(name, &[], &number(value))
    }

    fn start<'a>(&self, name: &'a str, attributes: &[(&'a str, &'a str)]) -> quick_xml::events::BytesStart<'a> {
        quick_xml::events::BytesStart::new(name).with_attributes(attributes.iter().copied())
    }

    /// The text.
    pub fn finish(mut self) -> Result<String, ExportError> {
        let xml = |error: &dyn std::fmt::Display| ExportError::Xml(error.to_string());
        self.writer.get_mut().write_all(b"\n").map_err(|error| xml(&error))?;
        String::from_utf8(self.writer.into_inner()).map_err(|error| xml(&error))
    }
}

/// The shortest decimal that reads back as the same number.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-5..1e15).contains(&magnitude) { format!("{value}") } else { format!("{value:e}") }
}
