//! Tokens → text, laid out as in the source that they come from.

use proc_macro2::{Delimiter, LineColumn, Spacing, TokenStream, TokenTree};
use syn::{Lit, LitStr};

/// The text of a declaration: its tokens in the lines and columns in which they stand in the source, as far as that is known. Comments are left out,
/// documentation is not.
pub(crate) fn text(tokens: &TokenStream) -> String {
    let mut layout = Layout::default();
    layout.write(tokens);
    layout.end()
}

/// What was written so far.
#[derive(Default)]
struct Layout {
    text: String,
    /// Where the last token ends in its source.
    last: Option<LineColumn>,
    /// Whether a token comes right after the last one.
    joint: bool,
    /// Where lines of the declaration begin, the least column of all.
    margin: Option<usize>,
    /// How deep in brackets the next token stands.
    depth: usize,
}

impl Layout {
    /// Writes tokens.
    fn write(&mut self, tokens: &TokenStream) {
        let mut trees = tokens.clone().into_iter().peekable();
        while let Some(tree) = trees.next() {
            match &tree {
                TokenTree::Punct(punct) if punct.as_char() == '#' => {
                    let doc = match trees.peek() {
                        Some(TokenTree::Group(group)) => documentation(group.stream()),
                        _ => None,
                    };
                    match doc {
                        Some(line) => {
                            trees.next();
                            self.documentation(&line);
                        }
                        None => self.token("#", &tree),
                    }
                }
                TokenTree::Group(group) => {
                    let [open, close] = match group.delimiter() {
                        Delimiter::Parenthesis => ["(", ")"],
                        Delimiter::Brace => ["{", "}"],
                        Delimiter::Bracket => ["[", "]"],
                        Delimiter::None => ["", ""],
                    };
                    self.place(open, group.span_open().start(), group.span_open().end());
                    self.joint = !matches!(open, "{");
                    self.depth += 1;
                    self.write(&group.stream());
                    self.depth -= 1;
                    self.joint = !matches!(close, "}");
                    self.place(close, group.span_close().start(), group.span_close().end());
                }
                TokenTree::Punct(punct) => {
                    let spacing = punct.spacing();
                    // signs that follow what they belong to
                    self.joint |= matches!(punct.as_char(), ';' | ',' | '.');
                    self.token(&punct.to_string(), &tree);
                    self.joint = spacing == Spacing::Joint || punct.as_char() == '.';
                }
                other => {
                    let text = other.to_string();
                    self.token(&text, &tree);
                }
            }
        }
    }

    fn token(&mut self, text: &str, tree: &TokenTree) {
        let span = tree.span();
        self.place(text, span.start(), span.end());
    }

    /// Writes a token that stands at a place of its source.
    fn place(&mut self, text: &str, start: LineColumn, end: LineColumn) {
        if text.is_empty() {
            return;
        }
        let known = start != end;
        match self.last {
            Some(last) if known && start.line == last.line && start.column >= last.column => {
                self.text
                    .extend(core::iter::repeat_n(' ', (start.column - last.column).min(4)));
            }
            Some(last) if known && start.line != last.line => self.line(start.column),
            Some(_) if !self.joint => self.text.push(' '),
            None => {
                self.margin.get_or_insert(start.column);
                if !self.text.is_empty() {
                    self.line(start.column);
                }
            }
            Some(_) => {}
        }
        self.text.push_str(text);
        self.joint = false;
        self.last = Some(end).filter(|_| known).or(self.last);
    }

    /// Begins a line at a column of the source.
    fn line(&mut self, column: usize) {
        let margin = *self.margin.get_or_insert(column);
        self.margin = Some(margin.min(column));
        self.text.truncate(self.text.trim_end().len());
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        let indent = column.saturating_sub(margin).min(64);
        self.text.extend(core::iter::repeat_n(' ', indent));
    }

    /// Writes a line of documentation.
    fn documentation(&mut self, line: &str) {
        let indent = 4 * self.depth;
        self.text.truncate(self.text.trim_end().len());
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text.extend(core::iter::repeat_n(' ', indent));
        self.text.push_str("///");
        self.text.push_str(line);
        // the next token begins a line
        self.last = Some(LineColumn {
            line: usize::MAX,
            column: 0,
        });
    }

    /// The text.
    fn end(mut self) -> String {
        self.text.truncate(self.text.trim_end().len());
        self.text.push('\n');
        self.text
    }
}

/// The line in `doc = "…"`.
fn documentation(tokens: TokenStream) -> Option<String> {
    let mut trees = tokens.into_iter();
    let (Some(TokenTree::Ident(doc)), Some(_), Some(TokenTree::Literal(text))) =
        (trees.next(), trees.next(), trees.next())
    else {
        return None;
    };
    match Lit::new(text) {
        Lit::Str(text) if doc == "doc" => Some(LitStr::value(&text)).filter(|text| !text.contains('\n')),
        _ => None,
    }
}
