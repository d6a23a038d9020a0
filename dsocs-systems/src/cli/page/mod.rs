//! HTML pages: each is one file that loads no other, and that can be read without JavaScript.

mod bodies;
pub mod motion;
pub mod provenance;
mod scene;
mod space;

pub use scene::Scene;

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Map, Value};

use crate::cli::CliError;
use crate::figure::escaped;

/// The style sheet of a page.
const STYLE: &str = include_str!("page.css");

/// The script of a page.
const SCRIPT: &str = include_str!("page.js");

/// The content security policy: a page loads nothing from outside.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A page in the making.
pub struct Page {
    /// The HTML so far.
    text: String,
    /// The data for the script, by key.
    data: Map<String, Value>,
}

impl Page {
    /// Begins a page.
    pub fn new(title: &str, below: &str) -> Self {
        let (title, below) = (escaped(title), escaped(below));
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <header>\n<h1>{title}</h1>\n<p class=\"soft\">{below}</p>\n</header>\n<main>\n"
        );
        Self {
            text,
            data: Map::new(),
        }
    }

    /// Adds HTML.
    pub fn add(&mut self, html: impl AsRef<str>) {
        self.text.push_str(html.as_ref());
        self.text.push('\n');
    }

    /// Begins a section.
    pub fn heading(&mut self, heading: &str) {
        self.add(format!("<h2>{}</h2>", escaped(heading)));
    }

    /// Adds a paragraph; text between backticks is code.
    pub fn paragraph(&mut self, text: &str) {
        self.add(format!("<p>{}</p>", with_code(text)));
    }

    /// Adds preformatted text.
    pub fn preformatted(&mut self, text: &str) {
        self.add(format!("<pre>{}</pre>", escaped(text)));
    }

    /// Adds data for the script.
    pub fn data(&mut self, key: &str, value: Value) {
        self.data.insert(key.to_owned(), value);
    }

    /// The whole page.
    pub fn finish(self) -> String {
        // a string in the data must not close the script element
        let data = Value::Object(self.data).to_string().replace('<', "\\u003c");
        format!(
            "{}</main>\n<script type=\"application/json\" id=\"data\">{data}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
            self.text
        )
    }
}

/// A finished page with another script, which may send requests to the server of the page.
pub fn with_script(html: &str, script: &str) -> String {
    html.replacen(POLICY, &format!("{POLICY}; connect-src 'self'"), 1)
        .replacen("</body>", &format!("<script>{script}</script>\n</body>"), 1)
}

/// A finished page with an error at its top, and a paragraph on the rest of the page.
pub fn with_error(html: &str, error: &str, remark: &str) -> String {
    let (error, remark) = (escaped(error), escaped(remark));
    let first = format!("<main>\n<pre class=\"error\">{error}</pre>\n<p>{remark}</p>\n");
    html.replacen("<main>\n", &first, 1)
}

/// Refuses a file whose name is not that of a page.
///
/// # Errors
///
/// [`CliError::PageFormat`].
pub fn check_name(path: &Path) -> Result<(), CliError> {
    let ending = path
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("html" | "htm") => Ok(()),
        _ => Err(CliError::PageFormat(path.display().to_string())),
    }
}

/// A cell of a table.
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, which stands at the right.
    Number(String),
    /// Whether a limit is met.
    #[cfg(all(feature = "dsocs", not(test)))]
    Verdict(bool),
}

/// A table with a caption. A head that begins with `#` marks a column of numbers.
pub fn table(caption: &str, head: &[&str], rows: impl IntoIterator<Item = Vec<Cell>>) -> String {
    let mut html = "<div class=\"scroll\"><table>\n".to_owned();
    if !caption.is_empty() {
        let _ = writeln!(html, "<caption>{}</caption>", escaped(caption));
    }
    if !head.is_empty() {
        html.push_str("<thead><tr>");
        for name in head {
            let (class, name) = match name.strip_prefix('#') {
                Some(name) => (" class=\"number\"", name),
                None => ("", *name),
            };
            let _ = write!(html, "<th scope=\"col\"{class}>{}</th>", escaped(name));
        }
        html.push_str("</tr></thead>\n");
    }
    html.push_str("<tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            let _ = match cell {
                Cell::Text(text) => write!(html, "<td>{}</td>", escaped(&text)),
                Cell::Number(text) => write!(html, "<td class=\"number\">{}</td>", escaped(&text)),
                #[cfg(all(feature = "dsocs", not(test)))]
                Cell::Verdict(true) => write!(html, "<td class=\"ok\">ok</td>"),
                #[cfg(all(feature = "dsocs", not(test)))]
                Cell::Verdict(false) => write!(html, "<td class=\"missed\">MISSED</td>"),
            };
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>");
    html
}

/// Escaped text; parts between backticks become code.
fn with_code(text: &str) -> String {
    let parts = escaped(text);
    let parts = parts.split('`').enumerate();
    let parts = parts.map(|(place, part)| match place % 2 {
        0 => part.to_owned(),
        _ => format!("<code>{part}</code>"),
    });
    parts.collect()
}

/// A label with `_{}` as subscripts, in HTML.
pub fn with_subscripts(label: &str) -> String {
    escaped(label).replace("_{", "<sub>").replace('}', "</sub>")
}

/// A number rounded to some significant digits, as data for the script; null if it is not finite.
pub fn rounded(x: f64, digits: usize) -> Value {
    let text = format!("{x:.*e}", digits.saturating_sub(1));
    text.parse::<f64>()
        .ok()
        .filter(|x| x.is_finite())
        .map_or(Value::Null, Value::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_asks_for_nothing_and_its_data_cannot_end_it() {
        let mut page = Page::new("a < b & c", "\"quoted\"");
        page.data("text", "</script><b>".into());
        let page = page.finish();
        assert!(page.contains("<h1>a &lt; b &amp; c</h1>"));
        assert_eq!(page.matches("</script>").count(), 2);
        for request in ["src=\"", "url(", "@import", "fetch(", "http-equiv=\"refresh"] {
            assert!(!page.contains(request), "{request}");
        }
    }

    #[test]
    fn numbers_are_rounded() {
        assert_eq!(rounded(1.0 / 3.0, 4).to_string(), "0.3333");
        assert_eq!(rounded(-0.000_123_456_7, 3).to_string(), "-0.000123");
        assert_eq!(rounded(f64::NAN, 3), Value::Null);
    }
}
