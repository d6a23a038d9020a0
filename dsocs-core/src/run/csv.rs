//! Nodes as a table of comma-separated values.

use core::fmt::{self, Write as _};
use core::ops::ControlFlow;
use std::io::{self, Write};

use super::{AnyNode, Node, Observer, Trajectory};
use crate::system::System;
use crate::tape::declaration::Declaration;

/// Writes the nodes of a run as comma-separated values, one in a line: the time, position, velocity,
/// constraint force, energy, observed expressions and multipliers, with the column names of the command line
/// (`t,x,v_x,force_x,energy,lambda_0`). For a rotation `r` these are the quaternion `r_w,r_x,r_y,r_z` and, in
/// the frame of the body, `v_r_x,v_r_y,v_r_z` and `force_r_x,force_r_y,force_r_z`.
///
/// Each number has the shortest form that reads back the same. The writer is an observer, so that a run of any length needs no memory:
///
/// ```
/// use dsocs_core::{CsvWriter, prelude::*};
///
/// /// A mass on a spring.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
/// }]
/// struct Spring;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut flow = Flow::new(&Spring, 0.5, Start::paper([1.0], [0.0]))?;
/// let mut table = CsvWriter::new(&Spring, Vec::new())?; // or a `File`, in a `BufWriter`
/// flow.stream(1.0, &mut table)?;
/// let text = String::from_utf8(table.finish()?)?;
/// assert!(text.starts_with("t,x,v_x,force_x,energy\n0,1,0,") && text.lines().count() == 4);
/// # Ok(())
/// # }
/// ```
pub struct CsvWriter<'s, W> {
    declaration: Declaration<'s>,
    out: W,
    line: String,
    failed: Option<io::Error>,
}

impl<W> fmt::Debug for CsvWriter<'_, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CsvWriter").finish_non_exhaustive()
    }
}

impl<'s, W: Write> CsvWriter<'s, W> {
    /// Writes the names of the columns of a system. The observed expressions and multipliers are those of its
    /// current parameters.
    ///
    /// # Errors
    ///
    /// The I/O errors of the writer.
    pub fn new<S: System<N>, const N: usize>(system: &'s S, mut out: W) -> io::Result<Self> {
        let declaration = Declaration::of(system);
        let shape = declaration.shape();
        let mut names = vec!["t".to_owned()];
        for before in ["", "v_", "force_"] {
            let coordinates = shape.coordinates.iter().enumerate();
            let shown = coordinates.filter(|(i, _)| before.is_empty() || shape.moves(*i));
            names.extend(shown.map(|(_, q)| format!("{before}{}", q.name)));
        }
        names.push("energy".to_owned());
        names.extend(shape.observables.iter().map(|known| known.name.to_string()));
        names.extend((0..shape.forms).map(|form| format!("lambda_{form}")));
        writeln!(out, "{}", names.join(","))?;
        Ok(Self {
            declaration,
            out,
            line: String::new(),
            failed: None,
        })
    }

    /// Writes a node.
    ///
    /// # Errors
    ///
    /// The I/O errors of the writer.
    pub fn write(&mut self, node: &AnyNode<'_>) -> io::Result<()> {
        self.line.clear();
        let declaration = &self.declaration;
        let mut observed = vec![f64::NAN; declaration.shape().observables.len()];
        declaration.observe(node.point(), &mut observed);
        let multipliers = declaration.multipliers(node);
        let shape = declaration.shape();
        let moving = |vector| shape.moving(vector);
        let numbers = core::iter::once(&node.t)
            .chain(node.q)
            .chain(moving(node.v))
            .chain(moving(node.force))
            .chain([&node.energy])
            .chain(&observed)
            .chain(&multipliers);
        for (place, number) in numbers.enumerate() {
            let begin = self.line.len();
            let comma = if place > 0 { "," } else { "" };
            // writing to a text cannot fail
            let _ = write!(self.line, "{comma}{number:?}");
            if self.line[begin..].ends_with(".0") {
                self.line.truncate(self.line.len() - 2);
            }
        }
        self.line.push('\n');
        self.out.write_all(self.line.as_bytes())
    }

    /// Ends the table and returns the writer.
    ///
    /// # Errors
    ///
    /// The I/O errors of the writer, also one that ended a run.
    pub fn finish(mut self) -> io::Result<W> {
        match self.failed {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.out),
        }
    }
}

/// An error of the writer ends the run; [`CsvWriter::finish`] returns it.
impl<W: Write, const N: usize> Observer<N> for CsvWriter<'_, W> {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        match self.write(&node.any()) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.failed = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

impl<const N: usize> Trajectory<N> {
    /// Writes the nodes as comma-separated values, with the columns of a [`CsvWriter`].
    ///
    /// ```
    /// use dsocs_core::prelude::*;
    ///
    /// /// A mass on a wire, with an observed expression.
    /// #[dsocs {
    ///     coordinates(x, y);
    ///     lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    ///     let height = y + 1;
    ///     holonomic = y - x.powi(2);
    ///     observe = [height];
    /// }]
    /// struct Wire;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let trajectory = Flow::new(&Wire, 0.1, Start::second_order([1.0, 1.0], [0.0, 0.0]))?.until(1.0)?;
    /// let mut table = Vec::new();
    /// trajectory.write_csv(&Wire, &mut table)?;
    /// let table = String::from_utf8(table)?;
    /// let mut lines = table.lines();
    /// assert_eq!(lines.next(), Some("t,x,y,v_x,v_y,force_x,force_y,energy,height,lambda_0"));
    /// // every number reads back the same
    /// for (line, node) in lines.zip(&trajectory) {
    ///     let numbers: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
    ///     assert_eq!(numbers[..8], [node.t, node.q[0], node.q[1], node.v[0], node.v[1], node.force[0], node.force[1], node.energy]);
    ///     assert_eq!((numbers[8], numbers.len()), (node.q[1] + 1.0, 10));
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    ///
    /// The I/O errors of the writer.
    pub fn write_csv<S: System<N>>(&self, system: &S, out: impl Write) -> io::Result<()> {
        let mut table = CsvWriter::new(system, out)?;
        for node in self {
            table.write(&node.any())?;
        }
        table.finish().map(|_| ())
    }
}
