//! Labels of columns in figures and on pages.

use crate::entry::Column;

/// The label of a column, with its unit where it is known; `_{}` marks a subscript.
pub fn label(column: &Column) -> String {
    let name = short(&column.name);
    match &column.unit {
        Some(unit) => format!("{name} [{unit}]"),
        None => name,
    }
}

/// The label of a column without its unit.
pub fn short(column: &str) -> String {
    let parts: Vec<&str> = column.split('_').map(greek).collect();
    let number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    match parts[..] {
        [of @ ("v" | "force" | "error" | "λ" | "regularity"), ref rest @ ..] if !rest.is_empty() => {
            format!("{of}_{{{}}}", rest.join(""))
        }
        [ref words @ .., last] if !words.is_empty() && number(last) => {
            format!("{}_{{{last}}}", words.join(" "))
        }
        _ => parts.join(" "),
    }
}

/// A label without the marks of subscripts, for plain text.
pub fn plain(label: &str) -> String {
    label.replace("_{", "_").replace('}', "")
}

/// The Greek letter of a name.
fn greek(name: &str) -> &str {
    match name {
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "delta" => "δ",
        "kappa" => "κ",
        "lambda" => "λ",
        "mu" => "μ",
        "omega" => "ω",
        "phi" => "φ",
        "psi" => "ψ",
        "rho" => "ρ",
        "sigma" => "σ",
        "tau" => "τ",
        "theta" => "θ",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_letters_and_subscripts() {
        for (column, label) in [
            ("theta", "θ"),
            ("theta_1", "θ_{1}"),
            ("v_theta_1", "v_{θ1}"),
            ("lambda_0", "λ_{0}"),
            ("force_x", "force_{x}"),
            ("rod_angle", "rod angle"),
            ("v", "v"),
        ] {
            assert_eq!(short(column), label);
        }
        assert_eq!(plain("v_{θ1} [rad/s]"), "v_θ1 [rad/s]");
    }
}
