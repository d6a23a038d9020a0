//! What a run keeps of its nodes, as arrays that Python sees without a copy.

use dsocs_core::{AnyNode, OwnedNode, Run};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};

use crate::error::no_memory;

/// Rows of numbers that grow. New rows are kept by themselves until someone looks; then they become a part of an array.
///
/// An array that was handed out shows the same rows for ever. The next one shows the same memory and more of it, as long as there is room for the new
/// rows behind the old ones. Where there is not, all rows move to an array with room for as many again. So whoever looks after every step waits for a
/// number of copies that does not grow with the run.
pub struct Column {
    /// How many numbers a row has.
    width: usize,
    /// The numbers of new rows.
    fresh: Vec<f64>,
    /// The rows that were looked at.
    seen: Option<Seen>,
}

/// Rows in an array.
struct Seen {
    /// The array, with room behind the rows.
    buffer: Py<PyArray2<f64>>,
    /// How many rows there are.
    rows: usize,
    /// For how many there is room.
    room: usize,
    /// What was handed out.
    view: Py<PyAny>,
}

impl Column {
    /// No rows of a width yet.
    pub fn new(width: usize) -> Self {
        Self {
            width,
            fresh: Vec::new(),
            seen: None,
        }
    }

    /// Whether a row has no numbers.
    pub fn is_empty_row(&self) -> bool {
        self.width == 0
    }

    /// Adds the numbers of a row.
    #[inline]
    pub fn extend(&mut self, row: &[f64]) {
        self.fresh.extend_from_slice(row);
    }

    /// Takes room for so many rows more; `false` if there is no memory for them.
    fn reserve(&mut self, rows: usize) -> bool {
        let numbers = rows.checked_mul(self.width);
        numbers.is_some_and(|numbers| self.fresh.try_reserve(numbers).is_ok())
    }

    /// The rows as an array that cannot be written to: of two dimensions, or of one where a row is a number.
    pub fn array<'py>(&mut self, py: Python<'py>, flat: bool) -> PyResult<Bound<'py, PyAny>> {
        if let Some(seen) = &self.seen
            && self.fresh.is_empty()
        {
            return Ok(seen.view.bind(py).clone());
        }
        let added = self.fresh.len().checked_div(self.width).unwrap_or(0);
        let before = self.seen.take();
        let (buffer, rows, room) = match before {
            None => {
                let numbers = std::mem::take(&mut self.fresh);
                let array = PyArray1::from_vec(py, numbers).reshape([added, self.width])?;
                (array, added, added)
            }
            Some(seen) => {
                let rows = seen.rows + added;
                let (buffer, room) = if rows <= seen.room {
                    (seen.buffer.into_bound(py), seen.room)
                } else {
                    let room = 2 * rows;
                    let larger = PyArray2::<f64>::zeros(py, [room, self.width], false);
                    copy(
                        &larger,
                        0,
                        &seen.buffer.bind(py).readonly().as_slice()?[..seen.rows * self.width],
                    )?;
                    (larger, room)
                };
                copy(&buffer, seen.rows * self.width, &self.fresh)?;
                self.fresh.clear();
                (buffer, rows, room)
            }
        };
        let shown = PySlice::new(py, 0, isize::try_from(rows)?, 1);
        let mut view = buffer.as_any().get_item(shown)?;
        if flat {
            view = view.call_method1("reshape", (rows,))?;
        }
        let fixed = PyDict::new(py);
        fixed.set_item("write", false)?;
        view.call_method("setflags", (), Some(&fixed))?;
        self.seen = Some(Seen {
            buffer: buffer.unbind(),
            rows,
            room,
            view: view.clone().unbind(),
        });
        Ok(view)
    }
}

/// Puts numbers into an array, from a place on.
fn copy(to: &Bound<'_, PyArray2<f64>>, from: usize, numbers: &[f64]) -> PyResult<()> {
    let mut to = to.try_readwrite()?;
    to.as_slice_mut()?[from..from + numbers.len()].copy_from_slice(numbers);
    Ok(())
}

/// The nodes of a run, every so many of them.
pub struct Record {
    /// Every so many nodes one is kept.
    every: u64,
    /// No node with a smaller number is kept from now on.
    next: u64,
    /// The current node.
    node: OwnedNode,
    /// How many are kept.
    rows: usize,
    /// Time, position, velocity, acceleration, constraint force, energy.
    columns: [Column; 6],
}

impl Record {
    /// The names of its columns.
    pub const NAMES: [&'static str; 6] = ["t", "q", "v", "a", "force", "energy"];

    /// No nodes yet.
    pub fn new(coordinates: usize, every: u64) -> Self {
        let widths = [1, coordinates, coordinates, coordinates, coordinates, 1];
        Self {
            every: every.max(1),
            next: 0,
            node: OwnedNode::new(coordinates),
            rows: 0,
            columns: widths.map(Column::new),
        }
    }

    /// How many nodes there are up to the next one that is kept, from one of a number on.
    pub fn ahead(&self, index: u64) -> u64 {
        self.next.saturating_sub(index).max(1)
    }

    /// Every so many nodes one is kept.
    pub fn every(&self) -> u64 {
        self.every
    }

    /// How many nodes are kept.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Keeps the current node of a run, if it is one of those that are kept.
    #[inline]
    pub fn take(&mut self, run: &dyn Run) {
        let index = run.clock().index();
        // most nodes of a run that keeps few of them end here, without a division
        if index < self.next || !index.is_multiple_of(self.every) {
            return;
        }
        self.next = index.saturating_add(self.every);
        self.node.take(run);
        let AnyNode {
            t,
            q,
            v,
            a,
            force,
            energy,
            ..
        } = self.node.any();
        for (column, row) in self.columns.iter_mut().zip([&[t], q, v, a, force, &[energy]]) {
            column.extend(row);
        }
        self.rows += 1;
    }

    /// Takes room for so many nodes more.
    pub fn reserve(&mut self, nodes: u64) -> PyResult<()> {
        let rows = usize::try_from(nodes / self.every).unwrap_or(usize::MAX);
        if self.columns.iter_mut().all(|column| column.reserve(rows)) {
            Ok(())
        } else {
            Err(no_memory())
        }
    }

    /// The array of a column, by its place.
    pub fn array<'py>(&mut self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        self.columns[place].array(py, place == 0 || place == 5)
    }
}
