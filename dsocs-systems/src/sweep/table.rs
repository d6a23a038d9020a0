//! Parquet tables. The same values give the same bytes.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Whole,
    /// Numbers; NaN is written as null.
    Number,
    /// Texts, or null.
    Text,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Numbers; NaN is null.
    Number(Vec<f64>),
    /// Texts, or null.
    Text(Vec<Option<String>>),
}

impl Cells {
    /// A column without values.
    pub fn new(kind: Kind) -> Self {
        match kind {
            Kind::Whole => Self::Whole(Vec::new()),
            Kind::Number => Self::Number(Vec::new()),
            Kind::Text => Self::Text(Vec::new()),
        }
    }
}

/// Writes a table, row group by row group.
pub struct Writer<W: Write + Send>(SerializedFileWriter<W>);

impl<W: Write + Send> Writer<W> {
    /// Begins a table with these columns, and with the text of the system in its metadata.
    ///
    /// # Errors
    ///
    /// [`ParquetError`] if it cannot be written.
    pub fn new(to: W, columns: &[(String, Kind)], text: Option<&str>) -> Result<Self, ParquetError> {
        let fields = columns
            .iter()
            .map(|(name, kind)| {
                let (physical, repetition) = match kind {
                    Kind::Whole => (Physical::INT64, Repetition::REQUIRED),
                    Kind::Number => (Physical::DOUBLE, Repetition::OPTIONAL),
                    Kind::Text => (Physical::BYTE_ARRAY, Repetition::OPTIONAL),
                };
                let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
                let field = match kind {
                    Kind::Text => field.with_logical_type(Some(LogicalType::String)),
                    _ => field,
                };
                field.build().map(Arc::new)
            })
            .collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
        // the bytes depend only on the values, not on the version of the crate `parquet`
        let properties = WriterProperties::builder()
            .set_created_by(CREATED_BY.to_owned())
            .set_key_value_metadata(text.map(|text| vec![KeyValue::new(TEXT.to_owned(), text.to_owned())]))
            .build();
        Ok(Self(SerializedFileWriter::new(
            to,
            Arc::new(schema),
            Arc::new(properties),
        )?))
    }

    /// Writes rows, the cells of each column in the order of the columns.
    ///
    /// # Errors
    ///
    /// [`ParquetError`] if they cannot be written.
    pub fn rows(&mut self, cells: &[Cells]) -> Result<(), ParquetError> {
        let mut group = self.0.next_row_group()?;
        let mut cells = cells.iter();
        while let Some(mut column) = group.next_column()? {
            match cells.next() {
                Some(Cells::Whole(values)) => {
                    column.typed::<Int64Type>().write_batch(values, None, None)?;
                }
                Some(Cells::Number(values)) => {
                    let levels: Vec<i16> = values.iter().map(|value| i16::from(!value.is_nan())).collect();
                    let values: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
                    column
                        .typed::<DoubleType>()
                        .write_batch(&values, Some(&levels), None)?;
                }
                Some(Cells::Text(values)) => {
                    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
                    let values: Vec<ByteArray> =
                        values.iter().flatten().map(|text| text.as_str().into()).collect();
                    column
                        .typed::<ByteArrayType>()
                        .write_batch(&values, Some(&levels), None)?;
                }
                None => return Err(ParquetError::General("a column has no cells".to_owned())),
            }
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Completes the table.
    ///
    /// # Errors
    ///
    /// [`ParquetError`] if it cannot be written.
    pub fn finish(self) -> Result<(), ParquetError> {
        self.0.close().map(drop)
    }
}

/// The key of the system's text in the Parquet files.
const TEXT: &str = "dsocs.text";

/// The text of the system in a Parquet file, if it has one.
///
/// # Errors
///
/// [`ParquetError`] if it cannot be read.
pub fn text(path: &Path) -> Result<Option<String>, ParquetError> {
    let reader = SerializedFileReader::new(File::open(path)?)?;
    let entries = reader.metadata().file_metadata().key_value_metadata();
    let text = entries.into_iter().flatten().find(|entry| entry.key == TEXT);
    Ok(text.and_then(|entry| entry.value.clone()))
}

/// The name of the writer in the Parquet files.
const CREATED_BY: &str = concat!("dsocs-systems version ", env!("CARGO_PKG_VERSION"));

/// Reads some columns of a table. An unknown name is an error.
///
/// # Errors
///
/// [`ParquetError`] if it cannot be read.
pub fn read(path: &Path, names: &[&str]) -> Result<Vec<Cells>, ParquetError> {
    let reader = SerializedFileReader::new(File::open(path)?)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut all = Vec::new();
    for name in names {
        let place = schema
            .columns()
            .iter()
            .position(|column| column.name() == *name)
            .ok_or_else(|| ParquetError::General(format!("it has no column `{name}`")))?;
        let mut cells: Option<Cells> = None;
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group)?;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a number of rows
            let rows = group.metadata().num_rows() as usize;
            let mut levels = Vec::new();
            match group.get_column_reader(place)? {
                ColumnReader::Int64ColumnReader(mut column) => {
                    let mut values = Vec::new();
                    column.read_records(rows, None, None, &mut values)?;
                    match cells.get_or_insert(Cells::Whole(Vec::new())) {
                        Cells::Whole(all) => all.extend(values),
                        _ => return Err(mixed(name)),
                    }
                }
                ColumnReader::DoubleColumnReader(mut column) => {
                    let mut values = Vec::new();
                    column.read_records(rows, Some(&mut levels), None, &mut values)?;
                    let mut values = values.into_iter();
                    let next = |&level: &i16| {
                        if level > 0 {
                            values.next().unwrap_or(f64::NAN)
                        } else {
                            f64::NAN
                        }
                    };
                    match cells.get_or_insert(Cells::Number(Vec::new())) {
                        Cells::Number(all) => all.extend(levels.iter().map(next)),
                        _ => return Err(mixed(name)),
                    }
                }
                ColumnReader::ByteArrayColumnReader(mut column) => {
                    let mut values = Vec::new();
                    column.read_records(rows, Some(&mut levels), None, &mut values)?;
                    let mut values = values.into_iter();
                    let text = |value: ByteArray| String::from_utf8_lossy(value.data()).into_owned();
                    let next = |&level: &i16| (level > 0).then(|| values.next().map(text)).flatten();
                    match cells.get_or_insert(Cells::Text(Vec::new())) {
                        Cells::Text(all) => all.extend(levels.iter().map(next)),
                        _ => return Err(mixed(name)),
                    }
                }
                _ => return Err(mixed(name)),
            }
        }
        all.push(cells.unwrap_or(Cells::Number(Vec::new())));
    }
    Ok(all)
}

/// The error for a column of a type that sweeps do not write.
fn mixed(name: &str) -> ParquetError {
    ParquetError::General(format!("its column `{name}` is of no kind that a sweep writes"))
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // written and read back
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let columns = [
            ("point".to_owned(), Kind::Whole),
            ("x".to_owned(), Kind::Number),
            ("error".to_owned(), Kind::Text),
        ];
        let cells = [
            Cells::Whole(vec![0, 1, 2]),
            Cells::Number(vec![0.5, f64::INFINITY, f64::NAN]),
            Cells::Text(vec![None, Some("singular".to_owned()), None]),
        ];
        let written = || {
            let mut bytes = Vec::new();
            let mut writer = Writer::new(&mut bytes, &columns, Some("coordinates(x);")).unwrap();
            writer.rows(&cells).unwrap();
            writer.rows(&cells).unwrap();
            writer.finish().unwrap();
            bytes
        };
        let bytes = written();
        assert_eq!(bytes, written());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(text(&path).unwrap().as_deref(), Some("coordinates(x);"));
        let found = read(&path, &["x", "point", "error"]).unwrap();
        let Cells::Number(x) = &found[0] else { panic!() };
        assert!(x[0] == 0.5 && x[4].is_infinite() && x[5].is_nan());
        assert_eq!(found[1], Cells::Whole(vec![0, 1, 2, 0, 1, 2]));
        let Cells::Text(error) = &found[2] else { panic!() };
        assert_eq!(error[4].as_deref(), Some("singular"));
        assert!(
            read(&path, &["y"])
                .unwrap_err()
                .to_string()
                .contains("no column `y`")
        );
    }
}
