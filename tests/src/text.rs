//! Systems of the tests that need no compiling: a declaration stays in the source as it is written, and is
//! parsed when the test runs.
//!
//! [`System`], [`Flow`], [`TaylorFlow`] and [`ComposedFlow`] stand for those of the library with the same
//! names: they take parsed systems as well as compiled ones.

use core::fmt::Write as _;
use core::iter::FusedIterator;
use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::{TapeKernel, Text};
use dsocs_core::{
    AnyComposedFlow, Composition, Declaration, Inputs, Kernel, Node, Point, Run, RunError, SetupError, Start,
    Stepper, Symmetry, Tolerance,
};

/// Declares a system that is parsed at run time. After the struct, whose fields are the parameters, come the
/// statements of the attribute `#[dsocs]`.
///
/// With the feature `compiled`, the attribute also compiles the same statements, and every parsed system is
/// compared with the compiled one.
#[macro_export]
macro_rules! declared {
    (@read $name:ident { $($field:ident: $type:ty),* } $($statements:tt)*) => {
        impl $crate::text::Declared for $name {
            const NAME: &'static str = stringify!($name);
            const PARAMETERS: &'static [(&'static str, &'static [usize])] =
                &[$((stringify!($field), <$type as $crate::text::Parameter>::LENGTHS)),*];
            const STATEMENTS: &'static str = stringify!($($statements)*);

            fn values(&self) -> Vec<f64> {
                let values: &[Vec<f64>] = &[$($crate::text::Parameter::values(&self.$field)),*];
                values.concat()
            }

            #[cfg(feature = "compiled")]
            fn is_the_compiled_one(&self, read: &dyn dsocs_core::Kernel) {
                #[dsocs_core::dsocs { $($statements)* }]
                struct Compiled { $($field: $type),* }
                let compiled = Compiled { $($field: self.$field.clone()),* };
                $crate::tape::same_everywhere(dsocs_core::System::kernel(&compiled), read, 20);
            }
        }

        impl<const N: usize> $crate::text::System<N> for $name {
            fn kernel(&self) -> &dyn dsocs_core::Kernel {
                $crate::text::read(self)
            }

            fn series(
                &self,
                start: dsocs_core::Start<N>,
                tolerance: dsocs_core::Tolerance,
            ) -> Result<$crate::text::TaylorFlow<'_, N>, dsocs_core::SetupError> {
                $crate::text::TaylorFlow::read($crate::text::read(self), start, tolerance)
            }
        }
    };
    ($(#[$meta:meta])* $visible:vis struct $name:ident; $($statements:tt)*) => {
        $(#[$meta])*
        $visible struct $name;

        $crate::declared!(@read $name {} $($statements)*);
    };
    (
        $(#[$meta:meta])*
        $visible:vis struct $name:ident { $($(#[$of_field:meta])* $seen:vis $field:ident: $type:ty),* $(,)? }
        $($statements:tt)*
    ) => {
        $(#[$meta])*
        $visible struct $name { $($(#[$of_field])* $seen $field: $type),* }

        $crate::declared!(@read $name { $($field: $type),* } $($statements)*);
    };
}

/// The type of a parameter field: a number, an array or a matrix.
pub trait Parameter {
    /// The number of elements of an array, or of rows and columns of a matrix; empty for a number.
    const LENGTHS: &'static [usize];

    /// Its numbers.
    fn values(&self) -> Vec<f64>;
}

impl Parameter for f64 {
    const LENGTHS: &'static [usize] = &[];

    fn values(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl<const N: usize> Parameter for [f64; N] {
    const LENGTHS: &'static [usize] = &[N];

    fn values(&self) -> Vec<f64> {
        self.to_vec()
    }
}

impl<const N: usize, const M: usize> Parameter for [[f64; M]; N] {
    const LENGTHS: &'static [usize] = &[N, M];

    fn values(&self) -> Vec<f64> {
        self.concat()
    }
}

/// A declaration that is parsed at run time.
pub trait Declared {
    /// The name of the system.
    const NAME: &'static str;
    /// The parameters, each with its lengths if it is an array or a matrix.
    const PARAMETERS: &'static [(&'static str, &'static [usize])];
    /// The statements.
    const STATEMENTS: &'static str;

    /// The values of the parameters.
    fn values(&self) -> Vec<f64>;

    /// Compares the parsed system with the compiled one.
    #[cfg(feature = "compiled")]
    fn is_the_compiled_one(&self, read: &dyn Kernel);
}

/// The parsed systems, by the text with its first values, and the values. They stay until the program ends.
type ParsedSystems = HashMap<(String, Vec<u64>), &'static TapeKernel>;

static PARSED_SYSTEMS: LazyLock<Mutex<ParsedSystems>> = LazyLock::new(Mutex::default);

/// The system of a declaration.
///
/// # Panics
///
/// If the declaration has mistakes, with their messages.
pub fn read<D: Declared>(declared: &D) -> &'static TapeKernel {
    let written = Written {
        name: D::NAME,
        parameters: D::PARAMETERS,
        statements: D::STATEMENTS,
        values: declared.values(),
    };
    written.read(&|_system| {
        #[cfg(feature = "compiled")]
        declared.is_the_compiled_one(_system);
    })
}

/// The system of a text.
///
/// # Panics
///
/// If the text has mistakes, with their messages.
#[must_use]
pub fn parsed(text: &str) -> TapeKernel {
    Text::parse("system", text)
        .unwrap_or_else(|error| panic!("{error}"))
        .system
}

/// A declaration without its type, so that the code that parses it is compiled once.
struct Written {
    name: &'static str,
    parameters: &'static [(&'static str, &'static [usize])],
    statements: &'static str,
    values: Vec<f64>,
}

impl Written {
    /// The parsed system, passed to `first` if it is parsed for the first time with these values.
    fn read(&self, first: &dyn Fn(&TapeKernel)) -> &'static TapeKernel {
        let mut text = String::new();
        if !self.parameters.is_empty() {
            text.push_str("parameters {");
            for (name, lengths) in self.parameters {
                let lengths = lengths.iter().rev();
                let zeros = lengths.fold("0".to_owned(), |zeros, length| format!("[{zeros}; {length}]"));
                // writing to a string does not fail
                let _ = write!(text, " {name} = {zeros},");
            }
            text.push_str(" }\n");
        }
        text.push_str(self.statements);
        let mut found = PARSED_SYSTEMS.lock().unwrap_or_else(PoisonError::into_inner);
        let plain: &TapeKernel =
            found
                .entry((text.clone(), Vec::new()))
                .or_insert_with(|| match Text::parse(self.name, &text) {
                    Ok(text) => Box::leak(Box::new(text.system)),
                    Err(error) => panic!("{error}"),
                });
        let bits = self.values.iter().map(|value| value.to_bits()).collect();
        found.entry((text, bits)).or_insert_with(|| {
            let mut system = plain.clone();
            for (place, &value) in self.values.iter().enumerate() {
                if let Some(parameter) = system.parameter_mut(place) {
                    *parameter = value;
                }
            }
            first(&system);
            Box::leak(Box::new(system))
        })
    }
}

/// A system with `N` coordinates, parsed or compiled.
pub trait System<const N: usize> {
    /// The system without its type.
    fn kernel(&self) -> &dyn Kernel;

    /// The continuous motion.
    ///
    /// # Errors
    ///
    /// As [`dsocs_core::TaylorFlow::new`].
    fn series(&self, start: Start<N>, tolerance: Tolerance) -> Result<TaylorFlow<'_, N>, SetupError>;

    /// The composed discrete motion.
    ///
    /// # Errors
    ///
    /// As [`dsocs_core::ComposedFlow::new`].
    fn composed(
        &self,
        h: f64,
        method: Composition,
        start: Start<N>,
    ) -> Result<ComposedFlow<'_, N>, SetupError> {
        let flow = AnyComposedFlow::new(self.kernel(), h, method, &start.into())?;
        Ok(ComposedFlow(flow.into_run()))
    }

    /// The name of its type.
    fn name(&self) -> &str {
        &self.kernel().shape().name
    }

    /// As [`dsocs_core::System::energy`].
    fn energy(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> f64 {
        Declaration::of(self.kernel()).energy(t, q, v)
    }

    /// As [`dsocs_core::System::external_forces`].
    fn external_forces(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        let mut forces = [0.0; N];
        Declaration::of(self.kernel()).external_forces(t, q, v, &mut forces);
        forces
    }

    /// As [`dsocs_core::System::observe`].
    fn observe(&self, point: &Point<f64, N>, out: &mut [f64]) {
        Declaration::of(self.kernel()).observe(point.any(), out);
    }

    /// As [`dsocs_core::System::SYMMETRY`].
    fn symmetry(&self) -> Symmetry {
        self.kernel().shape().symmetry
    }

    /// As [`dsocs_core::System::lagrangian`].
    fn lagrangian(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> f64 {
        Declaration::of(self.kernel()).lagrangian(t, q, v)
    }
}

impl<S: dsocs_core::System<N>, const N: usize> System<N> for S {
    fn kernel(&self) -> &dyn Kernel {
        dsocs_core::System::kernel(self)
    }

    fn series(&self, start: Start<N>, tolerance: Tolerance) -> Result<TaylorFlow<'_, N>, SetupError> {
        let flow = dsocs_core::TaylorFlow::new(self, start, tolerance)?;
        Ok(TaylorFlow(Series::Compiled(flow)))
    }

    fn composed(
        &self,
        h: f64,
        method: Composition,
        start: Start<N>,
    ) -> Result<ComposedFlow<'_, N>, SetupError> {
        let flow = dsocs_core::ComposedFlow::new(self, h, method, start)?;
        Ok(ComposedFlow(flow.into_run()))
    }
}

/// Discrete flows.
#[derive(Debug)]
pub struct Flow;

impl Flow {
    /// As [`dsocs_core::Flow::new`].
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    #[allow(clippy::new_ret_no_self)] // the library's
    pub fn new<S: System<N>, const N: usize>(
        system: &S,
        h: f64,
        start: Start<N>,
    ) -> Result<dsocs_core::Flow<'_, N>, SetupError> {
        dsocs_core::Flow::of(system.kernel(), h, start)
    }
}

/// As [`dsocs_core::TaylorFlow`].
#[derive(Debug)]
pub struct TaylorFlow<'s, const N: usize>(Series<'s, N>);

#[derive(Debug)]
enum Series<'s, const N: usize> {
    Read(AnyTaylorFlow<'s>),
    Compiled(dsocs_core::TaylorFlow<'s, N>),
}

impl<'s, const N: usize> TaylorFlow<'s, N> {
    /// As [`dsocs_core::TaylorFlow::new`].
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    pub fn new<S: System<N>>(
        system: &'s S,
        start: Start<N>,
        tolerance: Tolerance,
    ) -> Result<Self, SetupError> {
        system.series(start, tolerance)
    }

    /// The motion of a parsed system.
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    pub fn read(system: &'s TapeKernel, start: Start<N>, tolerance: Tolerance) -> Result<Self, SetupError> {
        let flow = AnyTaylorFlow::of_tape(system, &start.into(), tolerance)?;
        Ok(Self(Series::Read(flow)))
    }

    /// As [`dsocs_core::TaylorFlow::every`].
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    pub fn every(self, h: f64) -> Result<Self, SetupError> {
        Ok(Self(match self.0 {
            Series::Read(flow) => Series::Read(flow.every(h)?),
            Series::Compiled(flow) => Series::Compiled(flow.every(h)?),
        }))
    }

    /// The number of rejected steps; `None` for a parsed system.
    #[must_use]
    pub fn rejected(&self) -> Option<u64> {
        match &self.0 {
            Series::Read(_) => None,
            Series::Compiled(flow) => Some(flow.rejected()),
        }
    }

    /// The number of steps.
    #[must_use]
    pub fn steps(&self) -> u64 {
        match &self.0 {
            Series::Read(flow) => flow.steps(),
            Series::Compiled(flow) => flow.steps(),
        }
    }
}

impl<const N: usize> Stepper<N> for TaylorFlow<'_, N> {
    fn run(&self) -> &dyn Run {
        match &self.0 {
            Series::Read(flow) => flow,
            Series::Compiled(flow) => flow.run(),
        }
    }

    fn run_mut(&mut self) -> &mut dyn Run {
        match &mut self.0 {
            Series::Read(flow) => flow,
            Series::Compiled(flow) => flow.run_mut(),
        }
    }
}

impl<const N: usize> Iterator for TaylorFlow<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<const N: usize> FusedIterator for TaylorFlow<'_, N> {}

impl<const N: usize> Inputs<N> for TaylorFlow<'_, N> {}

/// As [`dsocs_core::ComposedFlow`].
pub struct ComposedFlow<'s, const N: usize>(Box<dyn Run + 's>);

impl<const N: usize> core::fmt::Debug for ComposedFlow<'_, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("ComposedFlow").field(&self.node()).finish()
    }
}

impl<'s, const N: usize> ComposedFlow<'s, N> {
    /// As [`dsocs_core::ComposedFlow::new`].
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    pub fn new<S: System<N>>(
        system: &'s S,
        h: f64,
        method: Composition,
        start: Start<N>,
    ) -> Result<Self, SetupError> {
        system.composed(h, method, start)
    }

    /// The composed discrete motion of a parsed system.
    ///
    /// # Errors
    ///
    /// The errors of the library's function.
    pub fn read(
        system: &'s TapeKernel,
        h: f64,
        method: Composition,
        start: Start<N>,
    ) -> Result<Self, SetupError> {
        let flow = AnyComposedFlow::new(system, h, method, &start.into())?;
        Ok(Self(flow.into_run()))
    }

    /// The position of the current node.
    #[must_use]
    pub fn position(&self) -> [f64; N] {
        self.node().q
    }
}

impl<const N: usize> Stepper<N> for ComposedFlow<'_, N> {
    fn run(&self) -> &dyn Run {
        &*self.0
    }

    fn run_mut(&mut self) -> &mut dyn Run {
        &mut *self.0
    }
}

impl<const N: usize> Iterator for ComposedFlow<'_, N> {
    type Item = Result<Node<N>, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_node()
    }
}

impl<const N: usize> FusedIterator for ComposedFlow<'_, N> {}

impl<const N: usize> Inputs<N> for ComposedFlow<'_, N> {}
