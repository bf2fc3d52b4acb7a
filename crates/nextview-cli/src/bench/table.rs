//! Tables with named, typed columns, and how they are written.

use crate::Failure;
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// Columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    columns: Vec<(String, Column)>,
}

/// The values of a column; where there is none, `None`.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Column {
    Text(Vec<Option<String>>),
    Int(Vec<Option<i64>>),
    Float(Vec<Option<f64>>),
    Bool(Vec<Option<bool>>),
}

impl Table {
    pub fn push(&mut self, name: impl Into<String>, column: Column) {
        self.columns.push((name.into(), column));
    }

    /// Adds a column of texts.
    pub fn text<'a>(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<&'a str>>>) {
        self.push(name, Column::Text(values.map(|value| value.into().map(str::to_owned)).collect()));
    }

    /// Adds a column of counts or numbers of things.
    pub fn count(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<usize>>>) {
        // All are below 2^63: they count things that are in memory.
        self.push(name, Column::Int(values.map(|value| value.into().map(|n| n as i64)).collect()));
    }

    /// Adds a column of numbers.
    pub fn float(&mut self, name: &str, values: impl Iterator<Item = impl Into<Option<f64>>>) {
        self.push(name, Column::Float(values.map(Into::into).collect()));
    }

    fn n_rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Writes CSV as in RFC 4180, but with plain line feeds: a head line, nothing for a missing value, quotes only
    /// where they must be. Numbers read back to the same bits.
    pub fn write_csv(&self, writer: &mut impl Write) -> Result<(), Failure> {
        let names: Vec<String> = self.columns.iter().map(|(name, _)| quoted(name)).collect();
        writeln!(writer, "{}", names.join(","))?;
        for row in 0..self.n_rows() {
            let values: Vec<String> = self.columns.iter().map(|(_, column)| column.csv(row)).collect();
            writeln!(writer, "{}", values.join(","))?;
        }
        Ok(())
    }

    /// Writes Apache Parquet: one row group, no compression, every column optional.
    pub fn write_parquet(&self, writer: impl Write + Send) -> Result<(), Failure> {
        self.to_parquet(writer).map_err(Failure::data)
    }

    fn to_parquet(&self, writer: impl Write + Send) -> Result<(), ParquetError> {
        let fields = self.columns.iter().map(|(name, column)| column.field(name).map(Arc::new));
        let fields = fields.collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(writer, Arc::new(schema), properties)?;
        if self.n_rows() > 0 {
            let mut group = file.next_row_group()?;
            for (_, column) in &self.columns {
                if let Some(mut writer) = group.next_column()? {
                    column.write(&mut writer)?;
                    writer.close()?;
                }
            }
            group.close()?;
        }
        file.close().map(drop)
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
            Self::Text(values) => values[row].as_deref().map(quoted),
            Self::Int(values) => values[row].map(|value| value.to_string()),
            Self::Float(values) => values[row].map(|value| value.to_string()),
            Self::Bool(values) => values[row].map(|value| value.to_string()),
        };
        value.unwrap_or_default()
    }

    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Self::Int(_) => (PhysicalType::INT64, None),
            Self::Float(_) => (PhysicalType::DOUBLE, None),
            Self::Bool(_) => (PhysicalType::BOOLEAN, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        field.with_logical_type(logical).build()
    }

    fn write(&self, writer: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        match self {
            Self::Text(values) => {
                write_values::<ByteArrayType, _>(writer, values, |text| ByteArray::from(text.as_str()))
            }
            Self::Int(values) => write_values::<Int64Type, _>(writer, values, |value| *value),
            Self::Float(values) => write_values::<DoubleType, _>(writer, values, |value| *value),
            Self::Bool(values) => write_values::<BoolType, _>(writer, values, |value| *value),
        }
    }
}

fn write_values<D: DataType, V>(
    writer: &mut SerializedColumnWriter<'_>,
    values: &[Option<V>],
    convert: impl Fn(&V) -> D::T,
) -> Result<(), ParquetError> {
    let is_there: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let values: Vec<D::T> = values.iter().flatten().map(convert).collect();
    writer.typed::<D>().write_batch(&values, Some(&is_there), None).map(drop)
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
