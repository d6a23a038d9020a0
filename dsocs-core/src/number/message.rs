//! The format of numbers in messages.

use core::fmt;

/// Numbers in brackets, short enough for a message.
pub(crate) struct Numbers<'a>(pub &'a [f64]);

impl fmt::Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        for (i, x) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            let ordinary = *x == 0.0 || !x.is_finite() || (1e-4..1e7).contains(&x.abs());
            if ordinary {
                write!(f, "{}", Rounded(*x))?;
            } else {
                write!(f, "{x:.3e}")?;
            }
        }
        f.write_str("]")
    }
}

/// A number with at most nine digits after the point and no zeros at its end.
pub(crate) struct Rounded(pub f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_nan() {
            return f.write_str("undefined");
        }
        let text = format!("{:.9}", self.0);
        let short = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        f.write_str(short)
    }
}

/// A number in four digits.
pub(crate) struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x) = *self;
        if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
            let digits = if x == 0.0 {
                0.0
            } else {
                3.0 - x.abs().log10().floor()
            };
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 6
            let text = format!("{x:.*}", digits.max(0.0) as usize);
            let short = if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.')
            } else {
                &text
            };
            f.write_str(short)
        } else {
            write!(f, "{x:.3e}")
        }
    }
}

/// A size in two digits.
pub(crate) struct Magnitude(pub f64);

impl fmt::Display for Magnitude {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_nan() {
            return f.write_str("undefined");
        }
        write!(f, "{:.1e}", self.0)
    }
}
