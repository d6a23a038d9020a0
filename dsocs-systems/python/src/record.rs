//! The kept nodes of a run, as arrays that Python sees without a copy.

use dsocs_core::{AnyNode, Run};
use dsocs_systems::entry::{LastNodes, Row};
use dsocs_systems::warnings::Warnings;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};

use crate::error::no_memory;

/// Rows of numbers that grow. New rows are collected until an array is asked for; then they are moved into
/// it.
///
/// An array that was returned never changes. The next one shows the same memory and more of it, as long as
/// there is room for the new rows behind the old ones. Otherwise all rows move to an array of twice the room.
/// So a user who asks after every step waits for a number of copies that does not grow with the run.
pub struct Column {
    /// The number of numbers in a row.
    width: usize,
    /// The numbers of new rows.
    fresh: Vec<f64>,
    /// The rows in an array, if one was asked for.
    in_array: Option<ArrayRows>,
}

/// Rows in an array.
struct ArrayRows {
    /// The array, with room behind the rows.
    buffer: Py<PyArray2<f64>>,
    /// The number of rows.
    rows: usize,
    /// The number of rows for which there is room.
    room: usize,
    /// The array that was returned last.
    view: Py<PyAny>,
}

impl Column {
    /// No rows yet, of this width.
    pub fn new(width: usize) -> Self {
        Self {
            width,
            fresh: Vec::new(),
            in_array: None,
        }
    }

    /// Whether a row has no numbers.
    pub fn is_empty_row(&self) -> bool {
        self.width == 0
    }

    /// Adds the numbers of a row.
    #[inline]
    pub fn extend(&mut self, row: &[f64]) {
        // few numbers are written without a call
        match row {
            [x] => self.fresh.push(*x),
            [x, y] => {
                self.fresh.push(*x);
                self.fresh.push(*y);
            }
            _ => self.fresh.extend_from_slice(row),
        }
    }

    /// Reserves room for more rows; `false` if there is no memory for them.
    fn reserve(&mut self, rows: usize) -> bool {
        let numbers = rows.checked_mul(self.width);
        numbers.is_some_and(|numbers| self.fresh.try_reserve(numbers).is_ok())
    }

    /// The rows as a read-only array: of two dimensions, or of one (`flat`) where a row is a number.
    pub fn array<'py>(&mut self, py: Python<'py>, flat: bool) -> PyResult<Bound<'py, PyAny>> {
        if let Some(in_array) = &self.in_array
            && self.fresh.is_empty()
        {
            return Ok(in_array.view.bind(py).clone());
        }
        let added = self.fresh.len().checked_div(self.width).unwrap_or(0);
        let before = self.in_array.take();
        let (buffer, rows, room) = match before {
            None => {
                let numbers = std::mem::take(&mut self.fresh);
                let array = PyArray1::from_vec(py, numbers).reshape([added, self.width])?;
                (array, added, added)
            }
            Some(in_array) => {
                let rows = in_array.rows + added;
                let (buffer, room) = if rows <= in_array.room {
                    (in_array.buffer.into_bound(py), in_array.room)
                } else {
                    let room = 2 * rows;
                    let larger = PyArray2::<f64>::zeros(py, [room, self.width], false);
                    copy(
                        &larger,
                        0,
                        &in_array.buffer.bind(py).readonly().as_slice()?[..in_array.rows * self.width],
                    )?;
                    (larger, room)
                };
                copy(&buffer, in_array.rows * self.width, &self.fresh)?;
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
        self.in_array = Some(ArrayRows {
            buffer: buffer.unbind(),
            rows,
            room,
            view: view.clone().unbind(),
        });
        Ok(view)
    }
}

/// Copies numbers into an array, from an index on.
fn copy(to: &Bound<'_, PyArray2<f64>>, from: usize, numbers: &[f64]) -> PyResult<()> {
    let mut to = to.try_readwrite()?;
    to.as_slice_mut()?[from..from + numbers.len()].copy_from_slice(numbers);
    Ok(())
}

/// The kept nodes of a run: every `every`-th.
pub struct Record {
    /// The distance of two kept nodes, in nodes.
    every: u64,
    /// The smallest index of the next node that is kept.
    next: u64,
    /// The last two kept nodes.
    nodes: LastNodes,
    /// The observers for warnings.
    pub warnings: Warnings,
    /// Time, position, velocity, acceleration, constraint force, energy.
    columns: [Column; 6],
}

impl Record {
    /// The names of its columns.
    pub const NAMES: [&'static str; 6] = ["t", "q", "v", "a", "force", "energy"];

    /// No nodes yet.
    pub fn new(coordinates: usize, every: u64, warnings: Warnings) -> Self {
        let widths = [1, coordinates, coordinates, coordinates, coordinates, 1];
        Self {
            every: every.max(1),
            next: 0,
            nodes: LastNodes::new(coordinates),
            warnings,
            columns: widths.map(Column::new),
        }
    }

    /// The number of nodes from `index` up to the next one that is kept.
    pub fn ahead(&self, index: u64) -> u64 {
        self.next.saturating_sub(index).max(1)
    }

    /// The distance of two kept nodes, in nodes.
    pub fn every(&self) -> u64 {
        self.every
    }

    /// The number of kept nodes.
    pub fn rows(&self) -> usize {
        self.nodes.taken()
    }

    /// Keeps the current node of a run, if it is to be kept, and looks whether something is to be told of it.
    #[inline]
    pub fn take(&mut self, run: &dyn Run) {
        let index = run.clock().index();
        // most nodes return here or go on without a division
        if index < self.next || (index > self.next && !index.is_multiple_of(self.every)) {
            return;
        }
        self.next = index.saturating_add(self.every);
        let (before, node) = self.nodes.take(run);
        let AnyNode {
            t,
            q,
            v,
            a,
            force,
            energy,
            ..
        } = node;
        let [times, positions, velocities, accelerations, forces, energies] = &mut self.columns;
        times.fresh.push(t);
        positions.extend(q);
        velocities.extend(v);
        accelerations.extend(a);
        forces.extend(force);
        energies.fresh.push(energy);
        let row = || Row {
            before,
            ..Row::of(node, run.declaration_at_node())
        };
        // the work between nodes that are not kept is not known
        if self.every == 1 || !self.warnings.ask_for_all() {
            self.warnings.look(&node, row);
        } else {
            self.warnings.look_at_inputs(&row());
        }
    }

    /// Reserves room for the kept ones of this many nodes.
    pub fn reserve(&mut self, nodes: u64) -> PyResult<()> {
        let rows = usize::try_from(nodes / self.every).unwrap_or(usize::MAX);
        if self.columns.iter_mut().all(|column| column.reserve(rows)) {
            Ok(())
        } else {
            Err(no_memory(nodes))
        }
    }

    /// The array of a column, by its index.
    pub fn array<'py>(&mut self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        self.columns[place].array(py, place == 0 || place == 5)
    }
}
