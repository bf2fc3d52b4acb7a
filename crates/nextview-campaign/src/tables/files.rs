use super::Table;
#[cfg(feature = "parquet")]
use super::parquet::ParquetFile;
use nextview_scan::Fault;
use nextview_scan::files::{NewFile, Overwrite};
use std::path::Path;

/// The names of the tables.
const NAMES: [&str; 3] = ["runs", "steps", "times"];

/// The table files in progress; none appears before all rows are written.
pub(super) struct TableFiles([TableFile; 3]);

struct TableFile {
    csv: NewFile,
    #[cfg(feature = "parquet")]
    parquet: ParquetFile<NewFile>,
}

impl TableFiles {
    /// Begins the files in this folder with the columns of these tables, without their rows.
    pub fn begin(dir: &Path, tables: &[Table; 3]) -> Result<Self, Fault> {
        let [runs, steps, times] = tables;
        let [a, b, c] = NAMES;
        Ok(Self([
            TableFile::begin(dir, a, runs)?,
            TableFile::begin(dir, b, steps)?,
            TableFile::begin(dir, c, times)?,
        ]))
    }

    /// Adds the rows of tables with the same columns.
    pub fn add(&mut self, tables: &[Table; 3]) -> Result<(), Fault> {
        self.0.iter_mut().zip(tables).try_for_each(|(file, table)| file.add(table))
    }

    /// Renames the files to their names.
    pub fn publish(self) -> Result<(), Fault> {
        self.0.into_iter().try_for_each(TableFile::publish)
    }
}

impl TableFile {
    fn begin(dir: &Path, name: &str, table: &Table) -> Result<Self, Fault> {
        let file =
            |extension: &str| NewFile::begin(&dir.join(format!("{name}.{extension}")), &Overwrite::results());
        let mut csv = file("csv")?;
        table.write_csv_head(&mut csv).map_err(|fault| csv.fault(fault))?;
        Ok(Self {
            csv,
            #[cfg(feature = "parquet")]
            parquet: ParquetFile::begin(file("parquet")?, table).map_err(Fault::data)?,
        })
    }

    fn add(&mut self, table: &Table) -> Result<(), Fault> {
        table.write_csv_rows(&mut self.csv).map_err(|fault| self.csv.fault(fault))?;
        #[cfg(feature = "parquet")]
        self.parquet.add(table).map_err(|error| self.csv.fault(Fault::data(error)))?;
        Ok(())
    }

    fn publish(self) -> Result<(), Fault> {
        #[cfg(feature = "parquet")]
        self.parquet.end().map_err(|error| self.csv.fault(Fault::data(error)))?.publish()?;
        self.csv.publish()
    }
}
