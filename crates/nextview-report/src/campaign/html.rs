//! The report as one HTML page, without network access or scripts.

use super::document::{Block, Cell, Document, Figure, Row, Section, Table};
use crate::plot::Plot;
use crate::text::{STYLE, escape, fill};

/// The page.
pub(crate) fn render(document: &Document) -> String {
    let values = [
        ("title", escape(&document.title)),
        ("style", [STYLE, include_str!("style.css")].concat()),
        ("subtitle", escape(&document.subtitle)),
        ("sections", document.sections.iter().map(section).collect()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    fill(include_str!("page.html"), &values)
}

fn section(section: &Section) -> String {
    let blocks: String = section.blocks.iter().map(block).collect();
    format!("<section>\n<h2>{}</h2>\n{blocks}</section>\n", escape(&section.title))
}

fn block(block: &Block) -> String {
    match block {
        Block::Text(text) => format!("<p class=\"text\">{}</p>\n", escape(text)),
        Block::Table(table) => self::table(table),
        Block::Figure(figure) => self::figure(figure),
        Block::Aside(title, text) => {
            format!("<details><summary>{}</summary><pre>{}</pre></details>\n", escape(title), escape(text))
        }
    }
}

fn figure(figure: &Figure) -> String {
    let overview = figure
        .overview
        .as_ref()
        .map_or_else(String::new, |plot| format!("<div class=\"overview\">{}</div>\n", plot.draw()));
    let panel = |(title, plot): &(String, Plot)| {
        format!("<div><p class=\"panel\">{}</p>{}</div>\n", escape(title), plot.draw())
    };
    let panels: String = figure.panels.iter().map(panel).collect();
    let panels = if panels.is_empty() { panels } else { format!("<div class=\"panels\">\n{panels}</div>\n") };
    format!(
        "<figure>\n{overview}{panels}<figcaption class=\"note\">{}</figcaption>\n\
         <details><summary>The numbers</summary>\n{}</details>\n</figure>\n",
        escape(&figure.caption),
        table(&figure.data)
    )
}

fn table(table: &Table) -> String {
    let caption = match table.caption.as_str() {
        "" => String::new(),
        caption => format!("<caption>{}</caption>", escape(caption)),
    };
    let class = |i: usize| if table.head[i].is_number { " class=\"number\"" } else { "" };
    let head: String = (table.head.iter().enumerate())
        .map(|(i, column)| format!("<th scope=\"col\"{}>{}</th>", class(i), escape(&column.name)))
        .collect();
    let cell = |(i, cell): (usize, &Cell)| match i {
        0 => format!("<th scope=\"row\">{}</th>", content(cell)),
        _ => format!("<td{}>{}</td>", class(i), content(cell)),
    };
    let row = |row: &Row| {
        let total = if row.is_total { " class=\"total\"" } else { "" };
        format!("<tr{total}>{}</tr>\n", row.cells.iter().enumerate().map(cell).collect::<String>())
    };
    let rows: String = table.rows.iter().map(row).collect();
    format!(
        "<div class=\"wide\"><table>{caption}<thead><tr>{head}</tr></thead>\n\
         <tbody>{rows}</tbody></table></div>\n"
    )
}

fn content(cell: &Cell) -> String {
    match cell.note.as_str() {
        "" => escape(&cell.text),
        note => format!("{}<small>{}</small>", escape(&cell.text), escape(note)),
    }
}
