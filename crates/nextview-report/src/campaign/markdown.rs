//! The report as Markdown; figures become tables of their numbers.

use super::document::{Block, Cell, Document, Row, Table};

/// The text of the page.
pub(crate) fn render(document: &Document) -> String {
    let mut out = format!("# {}\n\n{}\n", escape(&document.title), escape(&document.subtitle));
    for section in &document.sections {
        out += &format!("\n## {}\n", escape(&section.title));
        for block in &section.blocks {
            out += &match block {
                Block::Text(text) => format!("\n{}\n", escape(text)),
                Block::Table(table) => self::table(table, &table.caption),
                Block::Figure(figure) => table(&figure.data, &figure.caption),
                Block::Aside(title, text) => {
                    let fenced: String = text.lines().map(|line| format!("    {line}\n")).collect();
                    format!("\n{}:\n\n{fenced}", escape(title))
                }
            };
        }
    }
    out
}

fn table(table: &Table, caption: &str) -> String {
    let caption = if caption.is_empty() { String::new() } else { format!("\n{}\n", escape(caption)) };
    let head: String = table.head.iter().map(|c| format!(" {} |", escape(&c.name))).collect();
    let rule: String = table.head.iter().map(|c| if c.is_number { "---:|" } else { "---|" }).collect();
    let rows: String = table.rows.iter().map(row).collect();
    format!("{caption}\n|{head}\n|{rule}\n{rows}")
}

fn row(row: &Row) -> String {
    let cell = |cell: &Cell| match (row.is_total && !cell.text.is_empty(), escape(&join(cell))) {
        (true, text) => format!(" **{text}** |"),
        (false, text) => format!(" {text} |"),
    };
    format!("|{}\n", row.cells.iter().map(cell).collect::<String>())
}

fn join(cell: &Cell) -> String {
    match cell.note.as_str() {
        "" => cell.text.clone(),
        note => format!("{} ({note})", cell.text),
    }
}

/// Text that Markdown shows literally, on one line.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '<' | '>' | '[' | ']' | '|' | '#' => out.extend(['\\', c]),
            '\n' | '\r' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_not_markup() {
        assert_eq!(escape("a|b_c\n*<i>"), r"a\|b\_c \*\<i\>");
    }
}
