//! A report as one HTML file: style and figures inside, nothing fetched.

use std::fmt::Write;

use doublet_engine::notation;
use doublet_engine::report::document::{Block, Document, Style};
use doublet_engine::report::{Cell, Table, alignments};

use crate::PROGRAM;
use crate::svg::{escape, svg};

const STYLE: &str = include_str!("style.css");

/// The whole file.
pub fn html(document: &Document) -> String {
    let mut page = Page { out: String::new(), figures: 0, tables: 0 };
    let title = escape(&document.title);
    page.put(format_args!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <meta name=\"generator\" content=\"{}\"><title>{title}</title><style>{STYLE}</style></head><body><header>{}<h1>{title}</h1><p>{}</p>\
         </header><div id=\"cover\">\n",
        escape(PROGRAM),
        head(&document.style),
        escape(&document.subtitle)
    ));
    document.cover.iter().for_each(|block| page.block(block));
    page.out.push_str("</div><nav><ul>");
    let numbers = document.numbers();
    for (section, number) in document.sections.iter().zip(&numbers) {
        let (name, title) = (escape(&section.name), escape(&section.title));
        page.put(format_args!("<li class=\"plain\"><a href=\"#{name}\">{number} {title}</a></li>"));
    }
    page.out.push_str("</ul></nav><main>\n");
    for (index, section) in document.sections.iter().enumerate() {
        let (name, title) = (escape(&section.name), escape(&section.title));
        let number = &numbers[index];
        let number = if number.is_empty() { String::new() } else { format!("{number} ") };
        page.put(format_args!("<section id=\"{name}\"><h2>{number}{title}</h2>\n"));
        section.blocks.iter().for_each(|block| page.block(block));
        page.out.push_str("</section>\n");
    }
    let (app, date) = (escape(PROGRAM), escape(&document.date));
    let words = [&document.style.footer, &document.notice].map(|words| match words.as_str() {
        "" => String::new(),
        words => format!("<p>{}</p>", escape(words)),
    });
    let notice = words.concat();
    page.put(format_args!("</main><footer>{notice}{app}, {date}</footer></body></html>\n"));
    page.out
}

/// Logo and words of the house; colour of headings.
fn head(style: &Style) -> String {
    let accent = &style.accent;
    let mut out = format!("<style>h1,h2{{color:{accent}}}</style>");
    if let Some(logo) = &style.logo {
        let kind = if logo.ending == "svg" { "svg+xml" } else { logo.ending };
        let picture = base64(&logo.bytes);
        let _ =
            write!(out, "<img class=\"logo\" alt=\"logo\" height=\"52\" src=\"data:image/{kind};base64,{picture}\">");
    }
    if !style.header.is_empty() {
        let _ = write!(out, "<p>{}</p>", escape(&style.header));
    }
    out
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let byte = |index: usize| u32::from(part.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let digit = (bits >> (18 - 6 * place)) & 63;
            out.push(if place <= part.len() { char::from(DIGITS[digit as usize]) } else { '=' });
        }
    }
    out
}

/// A page being written.
struct Page {
    out: String,
    figures: usize,
    tables: usize,
}

impl Page {
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.out.write_fmt(text);
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Heading(text) => self.put(format_args!("<h3>{}</h3>\n", escape(text))),
            Block::Paragraph(text) => self.put(format_args!("<p>{}</p>\n", escape(text))),
            Block::Facts(facts) => {
                self.out.push_str("<dl>");
                for (name, text) in facts {
                    self.put(format_args!("<dt>{}</dt><dd>{}</dd>", escape(name), escape(text)));
                }
                self.out.push_str("</dl>\n");
            }
            Block::List(lines) => {
                self.out.push_str("<ul>");
                lines.iter().for_each(|line| self.put(format_args!("<li>{}</li>", escape(line))));
                self.out.push_str("</ul>\n");
            }
            Block::Outcome(level, text) => {
                self.put(format_args!("<p class=\"outcome {}\">{}</p>\n", level.name(), escape(text)));
            }
            Block::Table(table) => self.table(table),
            Block::Lines(count) => self.out.push_str(&"<p class=\"line\">&nbsp;</p>\n".repeat(*count)),
            Block::Figure(figure) => {
                self.figures += 1;
                let number = self.figures;
                let drawing = svg(figure, &format!("f{number}-"));
                self.put(format_args!(
                    "<figure>{drawing}<figcaption>Figure {number}: {}</figcaption></figure>\n",
                    escape(&figure.caption)
                ));
            }
        }
    }

    fn table(&mut self, table: &Table) {
        self.tables += 1;
        let right: Vec<bool> = alignments(table).collect();
        let class = |index: usize| if right[index] { " class=\"r\"" } else { "" };
        let (number, name, caption) = (self.tables, escape(&table.name), escape(&table.caption));
        self.put(format_args!(
            "<table id=\"table-{number}-{name}\"><caption>Table {number}: {caption}</caption><thead><tr>"
        ));
        for (index, column) in table.columns.iter().enumerate() {
            self.put(format_args!("<th{}>{}</th>", class(index), escape(&column.title())));
        }
        self.out.push_str("</tr></thead><tbody>\n");
        for row in &table.rows {
            self.out.push_str("<tr>");
            for (index, (cell, column)) in row.iter().zip(&table.columns).enumerate() {
                self.put(format_args!("<td{}>{}</td>", class(index), cell_text(cell, column.digits)));
            }
            self.out.push_str("</tr>\n");
        }
        self.out.push_str("</tbody></table>\n");
    }
}

fn cell_text(cell: &Cell, digits: usize) -> String {
    match cell {
        Cell::Symbol(name) => {
            let (letter, subscript, suffix) = notation::derivative_parts(name);
            format!("<i>{}</i><sub>{}</sub>{}", escape(&letter), escape(&subscript), escape(&suffix))
        }
        // The value to its last digit for whoever copies it, the readable one for the eye.
        Cell::Number(value) | Cell::Measured { value, .. } if value.is_finite() => {
            format!("<data value=\"{value}\">{}</data>", escape(&cell.readable(digits)))
        }
        _ => escape(&cell.readable(digits)),
    }
}

#[cfg(test)]
mod tests {
    use super::base64;

    #[test]
    fn bytes_are_the_text_of_rfc_4648() {
        for (bytes, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
