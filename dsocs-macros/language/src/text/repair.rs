//! Beginners' mistakes in texts: reserved words as names, decimal commas, missing semicolons. Each is
//! reported at its place and repaired there, so that the rest of the text is read as it is meant.

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};

use crate::mistakes::errors::Errors;
use crate::parse::{STATEMENTS, foreign_statement_hint};

/// Words that begin statements and that Rust reserves, so that the rest of such a statement cannot be read.
const CONTROL: [&str; 9] = [
    "fn", "for", "while", "loop", "match", "return", "struct", "static", "pub",
];

/// The tokens of a text with such mistakes repaired.
pub(super) fn repaired(tokens: TokenStream, errors: &Errors) -> TokenStream {
    let tokens = with_valid_names(tokens, errors);
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let mut repaired = Repaired::default();
    let mut place = 0;
    while let Some(tree) = trees.get(place) {
        let rest = &trees[place..];
        if repaired.is_inside() && begins_statement(rest) && repaired.ends_above(tree) {
            repaired.end(errors);
        }
        match rest {
            [TokenTree::Ident(word), ..]
                if !repaired.is_inside() && CONTROL.iter().any(|control| word == control) =>
            {
                let message = foreign_statement_hint(&word.to_string()).unwrap_or("leave this word out");
                errors.at(word, format!("no statement begins with `{word}`: {message}"));
                place += length_of_unreadable(rest);
                continue;
            }
            [TokenTree::Ident(word), TokenTree::Group(group), ..]
                if !repaired.is_inside() && (word == "parameters" || word == "run") =>
            {
                repaired.push(tree.clone());
                repaired.push_block(with_decimal_points(group, errors));
                place += 2;
                continue;
            }
            [
                TokenTree::Ident(word),
                TokenTree::Ident(name),
                TokenTree::Group(group),
                ..,
            ] if !repaired.is_inside() && word == "run" => {
                repaired.push(tree.clone());
                repaired.push(name.clone().into());
                repaired.push_block(with_decimal_points(group, errors));
                place += 3;
                continue;
            }
            _ => {}
        }
        if let Some(number) = decimal_comma(rest, errors) {
            repaired.push(number.into());
            place += 3;
            continue;
        }
        repaired.push(tree.clone());
        place += 1;
    }
    repaired.trees.into_iter().collect()
}

/// The repaired tokens so far.
#[derive(Default)]
struct Repaired {
    trees: Vec<TokenTree>,
    /// The first token of the current statement that is not documentation; `last` is its last token so far.
    first: Option<TokenTree>,
    last: Option<TokenTree>,
    /// Whether the next token may belong to documentation.
    is_doc: bool,
}

impl Repaired {
    /// Whether a statement has begun.
    fn is_inside(&self) -> bool {
        self.first.is_some()
    }

    /// Whether the last token stands in a line above another token.
    fn ends_above(&self, tree: &TokenTree) -> bool {
        let last = self.last.as_ref();
        // a name may stand in the line below its `let`
        let names =
            |last: &TokenTree| matches!(last, TokenTree::Ident(word) if word == "let" || word == "const");
        let last = last.filter(|last| !names(last));
        last.is_some_and(|last| last.span().end().line < tree.span().start().line)
    }

    fn push(&mut self, tree: TokenTree) {
        let is_sharp = matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == '#');
        let is_end = matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == ';');
        if is_end {
            self.first = None;
        } else if !self.is_inside() && (is_sharp || self.is_doc) {
            self.is_doc = !matches!(tree, TokenTree::Group(_));
        } else {
            self.first.get_or_insert_with(|| tree.clone());
        }
        self.last = Some(tree.clone());
        self.trees.push(tree);
    }

    /// Adds the block that ends a statement.
    fn push_block(&mut self, group: Group) {
        self.last = Some(group.clone().into());
        self.trees.push(group.into());
        self.first = None;
    }

    /// Ends a statement that lacks its semicolon.
    fn end(&mut self, errors: &Errors) {
        let (Some(first), Some(last)) = (self.first.take(), &self.last) else {
            return;
        };
        // a statement that does not exist is reported as such
        if matches!(&first, TokenTree::Ident(word) if is_statement(word)) {
            errors.at(
                last_token(last),
                "expected `;` behind this, at the end of the statement",
            );
        }
        let mut semicolon = Punct::new(';', Spacing::Alone);
        semicolon.set_span(last.span());
        self.trees.push(semicolon.into());
    }
}

/// The last token of a tree: for a group, its closing bracket.
fn last_token(tree: &TokenTree) -> TokenStream {
    let mut end = tree.clone();
    if let TokenTree::Group(group) = tree {
        let mut punct = Punct::new(';', Spacing::Alone);
        punct.set_span(group.span_close());
        end = punct.into();
    }
    end.into()
}

/// The number of tokens up to the end of a statement that cannot be read: up to a semicolon, a block, or the
/// line above another statement.
fn length_of_unreadable(trees: &[TokenTree]) -> usize {
    for (place, tree) in trees.iter().enumerate() {
        match tree {
            TokenTree::Punct(punct) if punct.as_char() == ';' => return place + 1,
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return place + 1,
            _ if place > 0 && begins_statement(&trees[place..]) => return place,
            _ => {}
        }
    }
    trees.len()
}

/// Whether a word begins a statement.
fn is_statement(word: &Ident) -> bool {
    let others = ["let", "const", "parameters", "run"];
    STATEMENTS
        .iter()
        .chain(&others)
        .any(|statement| word == statement)
}

/// Whether tokens can only be the beginning of a statement or of its documentation.
fn begins_statement(trees: &[TokenTree]) -> bool {
    let is = |tree: Option<&TokenTree>, c: char| matches!(tree, Some(TokenTree::Punct(punct)) if punct.as_char() == c);
    let is_group = |tree: Option<&TokenTree>, delimiter| matches!(tree, Some(TokenTree::Group(group)) if group.delimiter() == delimiter);
    let (second, third) = (trees.get(1), trees.get(2));
    match trees.first() {
        Some(TokenTree::Punct(punct)) if punct.as_char() == '#' => {
            is_group(second, Delimiter::Bracket) || (is(second, '!') && is_group(third, Delimiter::Bracket))
        }
        Some(TokenTree::Ident(word)) => match word.to_string().as_str() {
            "let" | "const" => matches!(second, Some(TokenTree::Ident(_))) && is(third, '='),
            "parameters" => is_group(second, Delimiter::Brace),
            "run" => {
                let named = matches!(second, Some(TokenTree::Ident(_))) && is_group(third, Delimiter::Brace);
                named || is_group(second, Delimiter::Brace)
            }
            "coordinates" => is_group(second, Delimiter::Parenthesis),
            // also an unknown statement, or one without its `let`: inside a statement, no name stands before
            // `=`
            _ => is(second, '=') && !is(third, '='),
        },
        _ => false,
    }
}

/// A group with decimal commas replaced by points.
fn with_decimal_points(group: &Group, errors: &Errors) -> Group {
    let trees: Vec<TokenTree> = group.stream().into_iter().collect();
    let mut repaired = Vec::with_capacity(trees.len());
    let mut place = 0;
    while let Some(tree) = trees.get(place) {
        if let Some(number) = decimal_comma(&trees[place..], errors) {
            repaired.push(number.into());
            place += 3;
        } else {
            repaired.push(tree.clone());
            place += 1;
        }
    }
    let mut new = Group::new(group.delimiter(), repaired.into_iter().collect());
    new.set_span(group.span());
    new
}

/// The number that is written with a decimal comma, such as `1,5`, if the tokens begin with one.
fn decimal_comma(trees: &[TokenTree], errors: &Errors) -> Option<Literal> {
    let [
        TokenTree::Literal(whole),
        TokenTree::Punct(comma),
        TokenTree::Literal(part),
        ..,
    ] = trees
    else {
        return None;
    };
    let follow = |a: Span, b: Span| a.end() == b.start();
    let (before, after) = (whole.to_string(), part.to_string());
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_number =
        comma.as_char() == ',' && is_digits(&before) && after.starts_with(|c: char| c.is_ascii_digit());
    if !is_number || !follow(whole.span(), comma.span()) || !follow(comma.span(), part.span()) {
        return None;
    }
    let written = format!("{before}.{after}");
    let mut number: Literal = written.parse().ok()?;
    let span = whole.span().join(part.span()).unwrap_or_else(|| whole.span());
    number.set_span(span);
    errors.at(
        TokenTree::from(number.clone()),
        format!("a decimal has a point: expected `{written}`"),
    );
    Some(number)
}

/// Reserved words of Rust that mean something in the language.
const KNOWN: [&str; 13] = [
    "let", "if", "else", "const", "use", "crate", "self", "as", "true", "false", "mut", "ref", "_",
];

/// Tokens with reserved words replaced where a name is expected.
fn with_valid_names(tokens: TokenStream, errors: &Errors) -> TokenStream {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let mut named = Vec::with_capacity(trees.len());
    for (place, tree) in trees.iter().enumerate() {
        named.push(match tree {
            TokenTree::Group(group) => {
                let mut new = Group::new(group.delimiter(), with_valid_names(group.stream(), errors));
                new.set_span(group.span());
                new.into()
            }
            TokenTree::Ident(word) => valid_name(word, trees.get(place + 1), errors).into(),
            other => other.clone(),
        });
    }
    named.into_iter().collect()
}

/// A word; a reserved one in place of a name is reported and replaced by a valid name.
fn valid_name(word: &Ident, next: Option<&TokenTree>, errors: &Errors) -> Ident {
    let text = word.to_string();
    // other words can be names
    let is_free =
        KNOWN.contains(&text.as_str()) || text.starts_with("r#") || syn::parse_str::<Ident>(&text).is_ok();
    let is_name = match next {
        Some(TokenTree::Punct(sign)) if text == "move" => sign.as_char() != '|',
        // an expression may begin with this sign
        Some(TokenTree::Punct(sign)) if CONTROL.contains(&text.as_str()) => {
            !matches!(sign.as_char(), '-' | '!' | '&' | '|')
        }
        None | Some(TokenTree::Punct(_)) => true,
        _ => false,
    };
    if is_free || !is_name {
        return word.clone();
    }
    errors.at(
        word,
        format!("`{text}` is a reserved word; expected another name, such as `{text}_1`"),
    );
    match text.as_str() {
        "super" | "Self" => Ident::new("Super", word.span()),
        _ => Ident::new_raw(&text, word.span()),
    }
}
