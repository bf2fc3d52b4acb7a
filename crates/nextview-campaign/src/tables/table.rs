use nextview_scan::Fault;
use nextview_scan::files::csv_field;
use std::io::Write;

/// Named columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<(String, Column)>,
}

/// The values of a column; `None` for a missing value.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Texts.
    Text(Vec<Option<String>>),
    /// Whole numbers.
    Int(Vec<Option<i64>>),
    /// Other numbers.
    Float(Vec<Option<f64>>),
    /// Truth values.
    Bool(Vec<Option<bool>>),
}

impl Table {
    /// Returns the columns with their names.
    pub fn columns(&self) -> &[(String, Column)] {
        &self.columns
    }

    /// Adds a column.
    pub(super) fn push(&mut self, name: impl Into<String>, column: Column) {
        self.columns.push((name.into(), column));
    }

    /// Adds a column of texts.
    pub(super) fn text<'a>(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<&'a str>>>) {
        self.push(name, Column::Text(values.map(|value| value.into().map(str::to_owned)).collect()));
    }

    /// Adds a column of counts or indices.
    pub(super) fn count(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<usize>>>) {
        // All are below 2^63: they count things in memory.
        self.push(name, Column::Int(values.map(|value| value.into().map(|n| n as i64)).collect()));
    }

    /// Adds a column of numbers.
    pub(super) fn float(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<f64>>>) {
        self.push(name, Column::Float(values.map(Into::into).collect()));
    }

    /// Returns the number of rows.
    pub fn n_rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Writes CSV as in RFC 4180, but with plain line feeds: a header line, nothing for a missing value,
    /// quotes only where required. Numbers read back to the same bits.
    pub fn write_csv(&self, writer: &mut impl Write) -> Result<(), Fault> {
        self.write_csv_head(writer)?;
        self.write_csv_rows(writer)
    }

    /// The header line only.
    pub(super) fn write_csv_head(&self, writer: &mut impl Write) -> Result<(), Fault> {
        let names: Vec<_> = self.columns.iter().map(|(name, _)| csv_field(name)).collect();
        Ok(writeln!(writer, "{}", names.join(","))?)
    }

    /// The lines below the header.
    pub(super) fn write_csv_rows(&self, writer: &mut impl Write) -> Result<(), Fault> {
        for row in 0..self.n_rows() {
            let values: Vec<String> = self.columns.iter().map(|(_, column)| column.csv(row)).collect();
            writeln!(writer, "{}", values.join(","))?;
        }
        Ok(())
    }
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Text(values) => values.len(),
            Self::Int(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Bool(values) => values.len(),
        }
    }

    fn csv(&self, row: usize) -> String {
        let value = match self {
            Self::Text(values) => values[row].as_deref().map(|text| csv_field(text).into_owned()),
            Self::Int(values) => values[row].map(|value| value.to_string()),
            Self::Float(values) => values[row].map(|value| value.to_string()),
            Self::Bool(values) => values[row].map(|value| value.to_string()),
        };
        value.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_quotes_where_it_must() {
        let mut table = Table::default();
        table.text("a,b", [Some("x"), Some("say \"x\", y"), None].into_iter());
        table.float("c", [0.1, 1e-7, 3.0].into_iter());
        table.push("d", Column::Bool(vec![Some(true), None, Some(false)]));
        let mut text = Vec::new();
        table.write_csv(&mut text).unwrap();
        let expected = "\"a,b\",c,d\nx,0.1,true\n\"say \"\"x\"\", y\",0.0000001,\n,3,false\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
