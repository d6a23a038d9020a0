//! Tables of rows as CSV and JSON, written row by row.

use std::io::{self, Write};
use std::path::Path;

use clap::ValueEnum;
use serde_json::{Map, Value};

use crate::cli::CliError;
use crate::cli::output::number::shortest;

/// The format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Comma-separated values with a line of names. Each number has the shortest form that reads back the same; numbers that are not finite are empty
    Csv,
    /// One object `{…, "columns": […], "rows": [[…], …]}`; numbers that are not finite are null
    Json,
}

impl TableFormat {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    ///
    /// [`CliError::TableFormat`] for another ending than `.csv` and `.json`.
    pub fn of(path: &Path) -> Result<Self, CliError> {
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            // a device's name has no extension
            _ if path.exists() && !path.is_file() && !path.is_dir() => Ok(Self::Csv),
            _ => Err(CliError::TableFormat(path.display().to_string())),
        }
    }
}

/// Writes a table. Its head is written with the first row: a run that does not begin writes nothing.
pub struct TableWriter<W: Write> {
    /// The part before the rows, until it is written.
    head: Option<Head>,
    /// The writer of the format.
    sink: Sink<W>,
}

/// The part of a table before its rows.
struct Head {
    /// The description of the rows, written if the format has a place for it.
    about: Map<String, Value>,
    /// The names of the columns.
    columns: Vec<String>,
}

/// A writer of one of the formats.
enum Sink<W: Write> {
    /// As CSV.
    Csv(Box<csv::Writer<W>>),
    /// As JSON.
    Json(W),
}

impl<W: Write> TableWriter<W> {
    /// Begins a table. `about` goes before the rows, if the format has a place for it.
    pub fn new(format: TableFormat, to: W, about: Map<String, Value>, columns: Vec<String>) -> Self {
        let sink = match format {
            TableFormat::Csv => Sink::Csv(Box::new(csv::Writer::from_writer(to))),
            TableFormat::Json => Sink::Json(to),
        };
        Self {
            head: Some(Head { about, columns }),
            sink,
        }
    }

    /// The writer below the table.
    pub fn get_ref(&self) -> &W {
        match &self.sink {
            Sink::Csv(writer) => writer.get_ref(),
            Sink::Json(to) => to,
        }
    }

    /// Writes a row.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn row(&mut self, values: &[f64]) -> io::Result<()> {
        let head = self.head.take();
        match &mut self.sink {
            Sink::Csv(writer) => {
                if let Some(head) = head {
                    writer.write_record(&head.columns).map_err(io_error)?;
                }
                for value in values {
                    let field = if value.is_finite() {
                        shortest(*value)
                    } else {
                        String::new()
                    };
                    writer.write_field(field).map_err(io_error)?;
                }
                writer.write_record(None::<&[u8]>).map_err(io_error)
            }
            Sink::Json(to) => {
                match head {
                    Some(head) => head.write(to)?,
                    None => to.write_all(b",\n")?,
                }
                Ok(serde_json::to_writer(to, values)?)
            }
        }
    }

    /// Ends the table and returns the writer below it.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        match self.sink {
            Sink::Csv(writer) => writer.into_inner().map_err(|error| {
                let error = error.error();
                io::Error::new(error.kind(), error.to_string())
            }),
            Sink::Json(mut to) => {
                if let Some(head) = self.head {
                    head.write(&mut to)?;
                }
                to.write_all(b"\n]}\n")?;
                to.flush()?;
                Ok(to)
            }
        }
    }
}

impl Head {
    /// Writes the beginning of the JSON object, up to the first row.
    fn write(&self, to: &mut impl Write) -> io::Result<()> {
        to.write_all(b"{")?;
        for (key, value) in &self.about {
            write!(to, "{}:{value},", Value::from(key.as_str()))?;
        }
        to.write_all(b"\"columns\":")?;
        serde_json::to_writer(&mut *to, &self.columns)?;
        to.write_all(b",\"rows\":[\n")
    }
}

/// The I/O error inside, whose kind tells whether a pipe is broken.
fn io_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(format: TableFormat) -> String {
        let mut about = Map::new();
        about.insert("step".to_owned(), 0.5.into());
        let columns = vec!["t".to_owned(), "x".to_owned()];
        let mut table = TableWriter::new(format, Vec::new(), about, columns);
        table.row(&[0.1, f64::NAN]).unwrap();
        table.row(&[-1.0, 2.5e-9]).unwrap();
        String::from_utf8(table.finish().unwrap()).unwrap()
    }

    #[test]
    fn csv_has_short_numbers_and_leaves_out_what_is_not_finite() {
        assert_eq!(written(TableFormat::Csv), "t,x\n0.1,\n-1,2.5e-9\n");
    }

    #[test]
    fn json_is_one_object_with_null_for_what_is_not_finite() {
        let value: Value = serde_json::from_str(&written(TableFormat::Json)).unwrap();
        assert_eq!(value["step"], 0.5);
        assert_eq!(value["rows"], serde_json::json!([[0.1, null], [-1.0, 2.5e-9]]));
    }
}
