//! The reference data: small CSV files in `tests/data` (those that the command line also needs are in
//! `dsocs-systems/data`).

use std::path::Path;

/// A CSV file with a head line.
#[derive(Clone, Debug)]
pub struct Table {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file; its path is relative to `tests/data`.
    ///
    /// # Panics
    ///
    /// If there is no such file or it is not a table.
    #[must_use]
    pub fn read(file: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(file);
        let mut reader =
            csv::Reader::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let fields = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
        let head = fields(reader.headers().expect("a head line"));
        let rows: Vec<_> = reader
            .records()
            .map(|record| fields(&record.expect("a row")))
            .collect();
        assert!(!rows.is_empty(), "{file} has no rows");
        Self { head, rows }
    }

    /// The index of a column.
    fn place(&self, column: &str) -> usize {
        let place = self.head.iter().position(|name| name == column);
        place.unwrap_or_else(|| panic!("there is no column {column} in {:?}", self.head))
    }

    /// A column of text.
    ///
    /// # Panics
    ///
    /// If there is no such column.
    #[must_use]
    pub fn text(&self, column: &str) -> Vec<&str> {
        let place = self.place(column);
        self.rows.iter().map(|row| row[place].as_str()).collect()
    }

    /// A column of numbers; NaN where a field is empty.
    ///
    /// # Panics
    ///
    /// If there is no such column, or a field is no number.
    #[must_use]
    pub fn numbers(&self, column: &str) -> Vec<f64> {
        let parse = |text: &str| {
            let number = if text.is_empty() {
                Ok(f64::NAN)
            } else {
                text.parse()
            };
            number.unwrap_or_else(|error| panic!("{text} in column {column}: {error}"))
        };
        self.text(column).into_iter().map(parse).collect()
    }

    /// A column of indices.
    ///
    /// # Panics
    ///
    /// If there is no such column, or a field is no index.
    #[must_use]
    pub fn indices(&self, column: &str) -> Vec<u64> {
        self.text(column)
            .into_iter()
            .map(|text| text.parse().expect("an index"))
            .collect()
    }

    /// Two columns of numbers, as points.
    ///
    /// # Panics
    ///
    /// As [`Table::numbers`].
    #[must_use]
    pub fn pairs(&self, columns: [&str; 2]) -> Vec<[f64; 2]> {
        let [first, second] = columns.map(|column| self.numbers(column));
        first.into_iter().zip(second).map(|(x, y)| [x, y]).collect()
    }
}
