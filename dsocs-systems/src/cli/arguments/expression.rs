//! Numbers on the command line: `1e-3`, and small expressions such as `-pi/2` or `(1 + sqrt(5))/2`.

/// The deepest nesting of parentheses and signs.
const DEEPEST_NESTING: usize = 64;

/// The grammar, as an error message gives it.
const GRAMMAR: &str = "numbers, pi, sqrt(…), 30deg, + - * / and parentheses";

/// Reads a number or an expression.
pub fn number(text: &str) -> Result<f64, String> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Ok(value);
    }
    let mut reader = Reader { rest: text, depth: 0 };
    let value = reader.sum()?;
    match reader.rest.trim_start() {
        "" => Ok(value),
        rest => Err(format!(
            "expected an operator before `{rest}`; {GRAMMAR} can be written"
        )),
    }
}

/// The text that is still to be read.
struct Reader<'a> {
    /// The text.
    rest: &'a str,
    /// The current nesting of parentheses and signs.
    depth: usize,
}

impl Reader<'_> {
    /// Takes a word or sign, if it comes next.
    fn take(&mut self, word: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(word);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// A sum of products.
    fn sum(&mut self) -> Result<f64, String> {
        let mut sum = self.product()?;
        loop {
            if self.take("+") {
                sum += self.product()?;
            } else if self.take("-") {
                sum -= self.product()?;
            } else {
                return Ok(sum);
            }
        }
    }

    /// A product of factors.
    fn product(&mut self) -> Result<f64, String> {
        let mut product = self.factor()?;
        loop {
            if self.take("*") {
                product *= self.factor()?;
            } else if self.take("/") {
                product /= self.factor()?;
            } else {
                return Ok(product);
            }
        }
    }

    /// A factor, with its sign.
    fn factor(&mut self) -> Result<f64, String> {
        self.depth += 1;
        if self.depth > DEEPEST_NESTING {
            return Err(format!(
                "parentheses and signs are nested more than {DEEPEST_NESTING} deep"
            ));
        }
        let value = if self.take("-") {
            -self.factor()?
        } else if self.take("+") {
            self.factor()?
        } else if self.take("sqrt") {
            if !self.take("(") {
                return Err("`sqrt` stands before parentheses: sqrt(2)".to_owned());
            }
            self.closed()?.sqrt()
        } else if self.take("(") {
            let value = self.closed()?;
            self.in_degrees(value)
        } else if self.take("pi") || self.take("π") {
            std::f64::consts::PI
        } else {
            let value = self.literal()?;
            self.in_degrees(value)
        };
        self.depth -= 1;
        Ok(value)
    }

    /// A value with the unit that may follow it: degrees become radians.
    fn in_degrees(&mut self, value: f64) -> f64 {
        if self.take("deg") || self.take("°") {
            value.to_radians()
        } else {
            value
        }
    }

    /// A sum up to a closing parenthesis.
    fn closed(&mut self) -> Result<f64, String> {
        let value = self.sum()?;
        if self.take(")") {
            Ok(value)
        } else {
            Err("a parenthesis is not closed".to_owned())
        }
    }

    /// A number in digits.
    fn literal(&mut self) -> Result<f64, String> {
        let text = self.rest.trim_start();
        let (mut end, mut before) = (0, ' ');
        for (place, sign) in text.char_indices() {
            let exponent = matches!(sign, 'e' | 'E') && before.is_ascii_digit();
            let of_exponent = matches!(sign, '+' | '-') && matches!(before, 'e' | 'E');
            if !(sign.is_ascii_digit() || sign == '.' || exponent || of_exponent) {
                break;
            }
            (end, before) = (place + sign.len_utf8(), sign);
        }
        let (digits, rest) = text.split_at(end);
        self.rest = rest;
        digits.parse().map_err(|_| match (digits, text) {
            ("", "") => "a number is missing at the end".to_owned(),
            ("", word) | (word, _) => format!("`{word}` is not a number; {GRAMMAR} can be written"),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::number;

    #[test]
    fn expressions_have_the_values_of_school() {
        for (text, value) in [
            ("1e-3", 1e-3),
            ("-2", -2.0),
            ("pi/2", PI / 2.0),
            ("-π", -PI),
            (" 2 * pi / 3 ", 2.0 * PI / 3.0),
            ("1 - 2 - 3", -4.0),
            ("8/2/2", 2.0),
            ("(1 + sqrt(5))/2", f64::midpoint(1.0, 5.0_f64.sqrt())),
            ("1e-3+2E+2", 200.001),
            ("--1", 1.0),
            ("2*-3", -6.0),
            (".5", 0.5),
            ("30deg", PI / 6.0),
            ("-90 deg", -PI / 2.0),
            ("(45 + 45)° / 2", PI / 4.0),
        ] {
            let found = number(text).unwrap();
            assert!((found - value).abs() <= 1e-15 * value.abs(), "{text}: {found}");
        }
        assert!(
            number("1/0").unwrap().is_infinite(),
            "refused where it is used, as `inf` is"
        );
    }

    #[test]
    fn what_is_no_expression_is_refused_with_the_reason() {
        for (text, reason) in [
            ("", "missing at the end"),
            ("x", "`x` is not a number"),
            ("2pi", "operator before `pi`"),
            ("1 +", "missing at the end"),
            ("(1", "not closed"),
            ("1)", "operator before `)`"),
            ("sqrt 2", "sqrt(2)"),
            ("1.2.3", "`1.2.3` is not"),
            ("2^3", "operator before `^3`"),
            ("1e", "`1e` is not"),
            ("30 degrees", "operator before `rees`"),
            ("pi deg", "operator before `deg`"),
        ] {
            let message = number(text).unwrap_err();
            assert!(message.contains(reason), "{text}: {message}");
        }
        assert!(number(&"(".repeat(100_000)).unwrap_err().contains("nested"));
    }
}
