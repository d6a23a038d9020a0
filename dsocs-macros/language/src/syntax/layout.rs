//! Tokens → text, with the lines and columns of their source.

use proc_macro2::{Delimiter, LineColumn, Spacing, TokenStream, TokenTree};
use syn::{Lit, LitStr};

use crate::syntax::shared;

/// The text of a declaration, with its tokens in the lines and columns of the source, as far as these are
/// known. Comments are left out, documentation is kept.
pub(crate) fn text(tokens: &TokenStream) -> String {
    let mut layout = Layout::default();
    // with the statements that several declarations share
    for statement in shared::statements_in_order(tokens.clone()) {
        layout.write(&statement.tokens);
        layout.is_line_due = true;
    }
    layout.finish()
}

/// The text written so far, and the state at its end.
#[derive(Default)]
struct Layout {
    text: String,
    /// The end of the last token in its source.
    last: Option<LineColumn>,
    /// Whether the next token follows without a space.
    joint: bool,
    /// The margin of the statement: the least column in which one of its lines begins.
    margin: Option<usize>,
    /// For each bracket around the next token, its first and last line in the source.
    around: Vec<(usize, usize)>,
    /// Whether the last token's place is unknown, so that the distance to the next token is, too.
    is_foreign: bool,
    /// The column of the first token of this line.
    column: usize,
    /// Whether the next token begins a line, as it does after a statement or documentation.
    is_line_due: bool,
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
                    let (from, to) = (group.span_open(), group.span_close());
                    // in a group that was moved, each bracket has the span of the whole group
                    let is_whole = to.start() == from.start() && from.start() != from.end();
                    let mut after = from.end();
                    if is_whole {
                        after.line = from.start().line;
                        after.column = from.start().column + 1;
                    }
                    self.place(open, from.start(), after);
                    self.joint = !matches!(open, "{");
                    let (begun, column) = (self.text.len(), self.column);
                    self.around.push((from.start().line, to.end().line));
                    self.write(&group.stream());
                    self.around.pop();
                    self.joint = !matches!(close, "}");
                    if is_whole && !close.is_empty() {
                        if self.text[begun..].contains('\n') && self.text.ends_with([',', ';']) {
                            let at = self.margin.map_or(column, |margin| column.max(margin));
                            self.begin_line(at);
                            self.joint = true;
                        }
                        self.append(close);
                    } else {
                        self.place(close, to.start(), to.end());
                    }
                }
                TokenTree::Punct(punct) => {
                    let spacing = punct.spacing();
                    // these follow without a space
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

    /// Writes a token with a known place in the source.
    fn place(&mut self, text: &str, start: LineColumn, end: LineColumn) {
        if text.is_empty() {
            return;
        }
        let around = self.around.last();
        let is_known = start != end && around.is_none_or(|&(from, to)| (from..=to).contains(&start.line));
        let is_due = core::mem::take(&mut self.is_line_due) && !self.text.is_empty();
        if is_due && self.around.is_empty() {
            // each statement has its own margin: it may come from another source
            self.margin = None;
            self.begin_line(start.column);
        } else if is_due {
            self.begin_line(if is_known { start.column } else { self.column });
        } else if !is_known {
            self.append(text);
            return;
        } else if self.is_foreign
            && (matches!(text, ";" | ",") || self.last.is_some_and(|last| last.line == start.line))
        {
            if !self.joint {
                self.text.push(' ');
            }
        } else {
            self.space_before(start);
        }
        self.text.push_str(text);
        (self.joint, self.is_foreign) = (false, !is_known);
        self.last = Some(end).filter(|_| is_known).or(self.last);
    }

    /// Writes a token whose place in the source is unknown.
    fn append(&mut self, text: &str) {
        if !self.joint && !self.text.is_empty() {
            self.text.push(' ');
        }
        self.text.push_str(text);
        (self.joint, self.is_foreign) = (false, true);
    }

    /// Writes the space between the last token and one at `start`.
    fn space_before(&mut self, start: LineColumn) {
        match self.last {
            Some(last) if start.line == last.line && start.column >= last.column => {
                let blanks = (start.column - last.column).min(4);
                self.text.extend(core::iter::repeat_n(' ', blanks));
            }
            Some(last) if start.line != last.line => self.begin_line(start.column),
            Some(_) if !self.joint => self.text.push(' '),
            Some(_) => {}
            None => self.begin_line(start.column),
        }
    }

    /// Begins a line at a column of the source.
    fn begin_line(&mut self, column: usize) {
        let margin = *self.margin.get_or_insert(column);
        self.column = column;
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
        let indent = 4 * self.around.len();
        self.text.truncate(self.text.trim_end().len());
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text.extend(core::iter::repeat_n(' ', indent));
        self.text.push_str("///");
        self.text.push_str(line);
        self.is_line_due = true;
    }

    /// The finished text.
    fn finish(mut self) -> String {
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
