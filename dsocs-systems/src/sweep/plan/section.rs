//! Tables of a plan, read with the place of each value for messages.

use std::fmt;

use toml::{Table, Value};

use crate::cli::arguments::expression;
use crate::entry::UnknownName;
use crate::sweep::SweepError;

/// A table of a plan. Values that are read are removed; keys that are left at the end are unknown.
pub(super) struct Section {
    /// Its place in the plan.
    at: String,
    /// The values that were not read yet.
    table: Table,
    /// The keys that were asked for.
    known: Vec<&'static str>,
}

impl Section {
    /// A table at a place.
    pub(super) fn new(at: &str, table: Table) -> Self {
        Self {
            at: at.to_owned(),
            table,
            known: Vec::new(),
        }
    }

    /// The place of a key.
    pub(super) fn place(&self, key: &str) -> String {
        if self.at.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.at)
        }
    }

    /// Takes a value.
    pub(super) fn take(&mut self, key: &'static str) -> Option<Value> {
        self.known.push(key);
        self.table.remove(key)
    }

    /// A number, or an expression as the command line takes it.
    pub(super) fn number(&mut self, key: &'static str) -> Result<Option<f64>, SweepError> {
        let at = self.place(key);
        self.take(key).map(|value| number(&at, &value)).transpose()
    }

    /// Numbers.
    pub(super) fn numbers(&mut self, key: &'static str) -> Result<Option<Vec<f64>>, SweepError> {
        let at = self.place(key);
        match self.take(key) {
            None => Ok(None),
            Some(Value::Array(list)) => list
                .iter()
                .map(|value| number(&at, value))
                .collect::<Result<_, _>>()
                .map(Some),
            Some(other) => wrong(&at, "a list of numbers", &other),
        }
    }

    /// A whole number, not less than `least`.
    pub(super) fn whole(&mut self, key: &'static str, least: u64) -> Result<Option<u64>, SweepError> {
        let at = self.place(key);
        match self.take(key) {
            None => Ok(None),
            Some(Value::Integer(count)) if u64::try_from(count).is_ok_and(|count| count >= least) => {
                Ok(u64::try_from(count).ok())
            }
            Some(other) => wrong(&at, &format!("a whole number, at least {least}"), &other),
        }
    }

    /// A whole number, at least 1.
    pub(super) fn count(&mut self, key: &'static str) -> Result<Option<u64>, SweepError> {
        self.whole(key, 1)
    }

    /// A string.
    pub(super) fn text(&mut self, key: &'static str) -> Result<Option<String>, SweepError> {
        let at = self.place(key);
        match self.take(key) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => wrong(&at, "a text", &other),
        }
    }

    /// Strings.
    pub(super) fn texts(&mut self, key: &'static str) -> Result<Option<Vec<String>>, SweepError> {
        let at = self.place(key);
        let texts = |list: &[Value]| -> Option<Vec<String>> {
            list.iter()
                .map(|value| value.as_str().map(str::to_owned))
                .collect()
        };
        match self.take(key) {
            None => Ok(None),
            Some(Value::Array(list)) if texts(&list).is_some() => Ok(texts(&list)),
            Some(other) => wrong(&at, "a list of names", &other),
        }
    }

    /// A flag, false by default.
    pub(super) fn flag(&mut self, key: &'static str) -> Result<bool, SweepError> {
        let at = self.place(key);
        match self.take(key) {
            None => Ok(false),
            Some(Value::Boolean(flag)) => Ok(flag),
            Some(other) => wrong(&at, "true or false", &other),
        }
    }

    /// One of some words.
    pub(super) fn choice<T: Copy>(
        &mut self,
        key: &'static str,
        words: &[(&str, T)],
    ) -> Result<Option<T>, SweepError> {
        let at = self.place(key);
        let Some(text) = self.text(key)? else {
            return Ok(None);
        };
        match words.iter().find(|(word, _)| *word == text) {
            Some((_, meaning)) => Ok(Some(*meaning)),
            None => Err(SweepError::unknown(
                &at,
                UnknownName::new("word", &text, words.iter().map(|(word, _)| *word)),
            )),
        }
    }

    /// A table, empty if there is none.
    pub(super) fn section(&mut self, key: &'static str) -> Result<Self, SweepError> {
        Ok(self
            .optional_section(key)?
            .unwrap_or_else(|| Self::new(key, Table::new())))
    }

    /// A table.
    pub(super) fn optional_section(&mut self, key: &'static str) -> Result<Option<Self>, SweepError> {
        let at = self.place(key);
        match self.take(key) {
            None => Ok(None),
            Some(Value::Table(table)) => Ok(Some(Self::new(&at, table))),
            Some(other) => wrong(&at, "a table", &other),
        }
    }

    /// All values, with their places and names, in their order.
    pub(super) fn entries(self) -> impl Iterator<Item = (String, String, Value)> {
        let at = self.at;
        self.table
            .into_iter()
            .map(move |(name, value)| (format!("{at}.{name}"), name, value))
    }

    /// Refuses keys that were not read.
    pub(super) fn finish(self) -> Result<(), SweepError> {
        match self.table.keys().next() {
            None => Ok(()),
            Some(key) => {
                let at = if self.at.is_empty() { "the plan" } else { &self.at };
                Err(SweepError::unknown(at, UnknownName::new("key", key, self.known)))
            }
        }
    }
}

/// A number, or an expression as the command line takes it.
pub(super) fn number(at: &str, value: &Value) -> Result<f64, SweepError> {
    let number = match value {
        Value::Float(number) => *number,
        #[allow(clippy::cast_precision_loss)] // as every literal
        Value::Integer(number) => *number as f64,
        Value::String(text) => match expression::number(text) {
            Ok(number) => number,
            Err(reason) => return fail(at, &reason),
        },
        other => return wrong(at, "a number, or an expression such as \"pi/2\"", other),
    };
    if number.is_finite() {
        Ok(number)
    } else {
        fail(at, &format!("{number} is not finite"))
    }
}

/// The error of a mistake at a place.
pub(super) fn fail<T>(at: &str, reason: &str) -> Result<T, SweepError> {
    Err(SweepError::plan(at, reason))
}

/// The error of a value of another type.
pub(super) fn wrong<T>(at: &str, expected: &str, found: &Value) -> Result<T, SweepError> {
    fail(
        at,
        &format!("expected {expected}, found {}", DisplayedValue(found)),
    )
}

/// A value in the notation of messages.
struct DisplayedValue<'v>(&'v Value);

impl fmt::Display for DisplayedValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Value::String(text) => write!(f, "{text:?}"),
            Value::Integer(number) => write!(f, "{number}"),
            Value::Float(number) => write!(f, "{number}"),
            Value::Boolean(flag) => write!(f, "{flag}"),
            other => write!(f, "a value of the kind {}", other.type_str()),
        }
    }
}
