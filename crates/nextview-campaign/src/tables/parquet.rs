use super::table::{Column, Table};
use nextview_scan::Fault;
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// An Apache Parquet file in progress: no compression, every column optional, one row group per table.
pub(super) struct ParquetFile<W: Write + Send>(SerializedFileWriter<W>);

impl<W: Write + Send> ParquetFile<W> {
    /// Begins a file with the columns of this table, without its rows.
    pub fn begin(writer: W, table: &Table) -> Result<Self, ParquetError> {
        let fields = table.columns().iter().map(|(name, column)| column.field(name).map(Arc::new));
        let fields = fields.collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        Ok(Self(SerializedFileWriter::new(writer, Arc::new(schema), properties)?))
    }

    /// Adds the rows of a table with the same columns.
    pub fn add(&mut self, table: &Table) -> Result<(), ParquetError> {
        if table.n_rows() == 0 {
            return Ok(());
        }
        let mut group = self.0.next_row_group()?;
        for (_, column) in table.columns() {
            if let Some(mut writer) = group.next_column()? {
                column.write(&mut writer)?;
                writer.close()?;
            }
        }
        group.close().map(drop)
    }

    /// Ends the file.
    pub fn end(self) -> Result<W, ParquetError> {
        self.0.into_inner()
    }
}

impl Table {
    /// Writes Apache Parquet: one row group, no compression, every column optional.
    pub fn write_parquet(&self, writer: impl Write + Send) -> Result<(), Fault> {
        let written = ParquetFile::begin(writer, self).and_then(|mut file| {
            file.add(self)?;
            file.end().map(drop)
        });
        written.map_err(Fault::data)
    }
}

impl Column {
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
