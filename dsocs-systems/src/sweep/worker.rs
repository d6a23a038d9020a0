//! The work of a thread: it computes the points of a part and writes their tables.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::SweepError;
use super::folder::{Folder, PartFile, TableKind};
use super::setting::{Setting, Target};
use super::table::{Cells, Kind, Writer};
use crate::entry::{self, Entry, Row, RunItem, VariedParameter, failure_code};

/// The rows of nodes are written when there are this many. The last run may exceed it.
const MOST_ROWS: usize = 1 << 17;

/// The number of points that are run side by side: eight fill the lanes, and more of them share the cost of
/// each call.
const POINTS_AT_ONCE: u64 = 32;

/// A thread with a system of its own.
pub struct Worker<'s> {
    /// The system, with the parameters of the last point.
    entry: Entry,
    /// The settings that all points share.
    setting: &'s Setting,
    /// The system as a text, which stands in every table.
    text: Option<&'s str>,
    /// The run, with the inputs of the last point.
    run: entry::Plan,
    /// The values of the quantities that vary.
    values: Vec<f64>,
    /// Position and velocity at the start.
    start: [Vec<f64>; 2],
}

impl<'s> Worker<'s> {
    /// The worker of a thread.
    pub fn new(entry: Entry, setting: &'s Setting, text: Option<&'s str>) -> Self {
        Self {
            entry,
            setting,
            text,
            run: setting.run.clone(),
            values: Vec::new(),
            start: setting.base.clone(),
        }
    }

    /// Computes a part and writes it. Returns the number of points that failed, or `None` if `end` stopped it.
    ///
    /// # Errors
    ///
    /// [`SweepError::Write`] if it cannot be written.
    pub fn part(
        &mut self,
        folder: &Folder,
        part: u64,
        points: Range<u64>,
        end: &dyn Fn() -> bool,
        done: Option<&AtomicU64>,
    ) -> Result<Option<u64>, SweepError> {
        let setting = self.setting;
        let mut table = Rows::new(&setting.columns[0]);
        let mut nodes = Rows::new(&setting.columns[1]);
        let mut file = match setting.nodes {
            Some(_) => Some(folder.begin_part(TableKind::Nodes, part)?),
            None => None,
        };
        let place = folder.part(TableKind::Nodes, part);
        let mut writer = match &mut file {
            Some(file) => Some(
                Writer::new(file.file(), &setting.columns[1], self.text)
                    .map_err(|cause| SweepError::table(&place, cause))?,
            ),
            None => None,
        };
        let mut failed = 0;
        let mut lane_ends = LaneEnds::default();
        for point in points.clone() {
            if end() {
                return Ok(None);
            }
            if setting.in_lanes && !lane_ends.holds(point) {
                lane_ends = self.lane_ends(point..points.end.min(point + POINTS_AT_ONCE));
            }
            failed += u64::from(!self.point(point, lane_ends.take(point), &mut table, &mut nodes));
            if let Some(writer) = &mut writer
                && nodes.count >= MOST_ROWS
            {
                nodes
                    .write(writer)
                    .map_err(|cause| SweepError::table(&place, cause))?;
            }
            add(done, 1);
        }
        if let Some(mut writer) = writer.take() {
            if nodes.count > 0 {
                nodes
                    .write(&mut writer)
                    .map_err(|cause| SweepError::table(&place, cause))?;
            }
            writer
                .finish()
                .map_err(|cause| SweepError::table(&place, cause))?;
        }
        drop(writer);
        file.map_or(Ok(()), PartFile::finish)?;
        let mut file = folder.begin_part(TableKind::Points, part)?;
        let place = file.path().to_owned();
        let mut writer = Writer::new(file.file(), &setting.columns[0], self.text)
            .map_err(|cause| SweepError::table(&place, cause))?;
        table
            .write(&mut writer)
            .and_then(|()| writer.finish())
            .map_err(|cause| SweepError::table(&place, cause))?;
        file.finish()?;
        Ok(Some(failed))
    }

    /// Runs points side by side.
    fn lane_ends(&mut self, points: Range<u64>) -> LaneEnds {
        let setting = self.setting;
        let mut beginnings = Vec::new();
        let mut parameters: Vec<VariedParameter> = setting
            .targets
            .iter()
            .filter_map(|target| match target {
                Target::Parameter(name) => Some((name.clone(), Vec::new())),
                _ => None,
            })
            .collect();
        for point in points.clone() {
            self.set(point);
            beginnings.push(setting.beginning(&self.start[0], &self.start[1]));
            let mut varied = parameters.iter_mut();
            for (&value, target) in self.values.iter().zip(&setting.targets) {
                if let Target::Parameter(_) = target
                    && let Some((_, values)) = varied.next()
                {
                    values.push(value);
                }
            }
        }
        let mut ends = vec![None; beginnings.len()];
        self.entry
            .run_in_lanes(&self.run, &beginnings, &parameters, &mut |place, row| {
                let mut values = Vec::new();
                row.write(&mut values);
                ends[place] = Some(values);
            });
        LaneEnds { points, ends }
    }

    /// Sets the quantities that vary to their values at a point.
    fn set(&mut self, point: u64) {
        let setting = self.setting;
        setting.points.values(point, &mut self.values);
        for (&value, target) in self.values.iter().zip(&setting.targets) {
            match *target {
                Target::Position(place) => self.start[0][place] = value,
                Target::Velocity(place) => self.start[1][place] = value,
                Target::Input(input, row) => self.run.inputs[input].values[row][1] = value,
                // the name has been looked up
                Target::Parameter(ref name) => drop(self.entry.set(name, value)),
            }
        }
    }

    /// Runs a point, unless its end is known, and returns whether it reached its end.
    fn point(&mut self, point: u64, known: Option<Vec<f64>>, table: &mut Rows, nodes: &mut Rows) -> bool {
        let setting = self.setting;
        self.set(point);
        let beginning = setting.beginning(&self.start[0], &self.start[1]);
        let extremes = setting.extremes.len();
        let mut kept = KeptResults {
            values: Vec::new(),
            end: vec![f64::NAN; setting.end.len()],
            extremes: [vec![f64::INFINITY; extremes], vec![f64::NEG_INFINITY; extremes]],
            events: vec![(0, f64::NAN, f64::NAN); setting.events.len()],
        };
        let looked_at = setting.nodes.is_some() || extremes > 0;
        #[allow(clippy::cast_possible_wrap)] // below 2⁵³
        let number = point as i64;
        let result = if let Some(values) = known {
            kept.values = values;
            kept.keep_end(setting);
            Ok(None)
        } else {
            self.entry
                .run_point(&self.run, &beginning, &setting.watched, looked_at, &mut |item| {
                    kept.take(setting, number, nodes, &item);
                })
        };
        table.whole(number);
        for &value in &self.values {
            table.number(value);
        }
        for &value in &kept.end {
            table.number(value);
        }
        for value in kept.extremes.iter().flatten() {
            // a run without nodes has no extremes
            table.number(if value.is_finite() { *value } else { f64::NAN });
        }
        for &(count, first, last) in &kept.events {
            table.whole(count);
            table.number(first);
            table.number(last);
        }
        if setting.watched.iter().any(|event| event.ends) {
            table.text(match &result {
                Ok(Some(event)) => Some(setting.events[*event].clone()),
                Ok(None) => Some("until".to_owned()),
                Err(_) => None,
            });
        }
        table.text(
            result
                .as_ref()
                .err()
                .map(|failure| failure_code(failure).to_owned()),
        );
        table.text(result.as_ref().err().map(ToString::to_string));
        table.end();
        result.is_ok()
    }
}

/// The ends of points that were run side by side; `None` for points that have to be run alone.
#[derive(Default)]
struct LaneEnds {
    points: Range<u64>,
    ends: Vec<Option<Vec<f64>>>,
}

impl LaneEnds {
    /// Whether a point is among them.
    fn holds(&self, point: u64) -> bool {
        self.points.contains(&point)
    }

    /// The columns of a point's end.
    fn take(&mut self, point: u64) -> Option<Vec<f64>> {
        let place = usize::try_from(point.checked_sub(self.points.start)?).ok()?;
        self.ends.get_mut(place)?.take()
    }
}

/// The results that are kept of a run.
struct KeptResults {
    /// Room for the columns of a node.
    values: Vec<f64>,
    /// The columns of the end.
    end: Vec<f64>,
    /// The least and the greatest.
    extremes: [Vec<f64>; 2],
    /// For each event: the number of times it happened, and its first and last time.
    events: Vec<(i64, f64, f64)>,
}

impl KeptResults {
    /// Takes in an item of a run: a node, an event or its end.
    fn take(&mut self, setting: &Setting, point: i64, nodes: &mut Rows, item: &RunItem<'_>) {
        match *item {
            RunItem::Event(event, t) => {
                let (count, first, last) = &mut self.events[event];
                *count += 1;
                (*first, *last) = (if first.is_nan() { t } else { *first }, t);
            }
            RunItem::Node(row) => {
                self.read(row);
                self.extremes(setting);
                if let Some((every, columns)) = &setting.nodes
                    && row.node.index % every == 0
                {
                    nodes.whole(point);
                    #[allow(clippy::cast_possible_wrap)]
                    nodes.whole(row.node.index as i64);
                    for &column in columns {
                        nodes.number(self.values[column]);
                    }
                    nodes.end();
                }
            }
            RunItem::End(row) => {
                self.read(row);
                // at an event between nodes a value may exceed those of all nodes
                self.extremes(setting);
                self.keep_end(setting);
            }
        }
    }

    /// Keeps the columns of the current node as those of the end.
    fn keep_end(&mut self, setting: &Setting) {
        for (kept, &column) in self.end.iter_mut().zip(&setting.end) {
            *kept = self.values[column];
        }
    }

    /// Reads the columns of a node.
    fn read(&mut self, row: &Row<'_>) {
        row.write(&mut self.values);
    }

    /// Updates the extremes.
    fn extremes(&mut self, setting: &Setting) {
        let [least, greatest] = &mut self.extremes;
        for ((least, greatest), &column) in least.iter_mut().zip(greatest).zip(&setting.extremes) {
            // NaN is never an extreme
            (*least, *greatest) = (least.min(self.values[column]), greatest.max(self.values[column]));
        }
    }
}

/// Rows of a table, cell by cell.
struct Rows {
    /// The columns.
    columns: Vec<(String, Kind)>,
    /// The cells, by column.
    cells: Vec<Cells>,
    /// The column of the next cell.
    next: usize,
    /// The number of rows.
    count: usize,
}

impl Rows {
    /// No rows.
    fn new(columns: &[(String, Kind)]) -> Self {
        Self {
            columns: columns.to_vec(),
            cells: columns.iter().map(|(_, kind)| Cells::new(*kind)).collect(),
            next: 0,
            count: 0,
        }
    }

    /// Writes a whole number into the next cell.
    fn whole(&mut self, value: i64) {
        if let Some(Cells::Whole(cells)) = self.cells.get_mut(self.next) {
            cells.push(value);
        }
        self.next += 1;
    }

    /// Writes a number into the next cell; NaN is null.
    fn number(&mut self, value: f64) {
        if let Some(Cells::Number(cells)) = self.cells.get_mut(self.next) {
            cells.push(value);
        }
        self.next += 1;
    }

    /// Writes a text into the next cell.
    fn text(&mut self, value: Option<String>) {
        if let Some(Cells::Text(cells)) = self.cells.get_mut(self.next) {
            cells.push(value);
        }
        self.next += 1;
    }

    /// Ends the row.
    fn end(&mut self) {
        (self.next, self.count) = (0, self.count + 1);
    }

    /// Writes the rows to the file, and removes them from memory.
    fn write<W: std::io::Write + Send>(
        &mut self,
        writer: &mut Writer<W>,
    ) -> Result<(), parquet::errors::ParquetError> {
        writer.rows(&self.cells)?;
        *self = Self::new(&self.columns);
        Ok(())
    }
}

/// Adds finished points to the counter.
pub(super) fn add(done: Option<&AtomicU64>, count: u64) {
    if let Some(done) = done {
        done.fetch_add(count, Ordering::Relaxed);
    }
}
