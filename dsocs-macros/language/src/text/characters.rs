//! Characters that may not stand in a text, and those that look like others.
//!
//! A text is checked before it is split into tokens, since the lexer gives no reasons. A character that only
//! looks like a sign of the language is reported and replaced by that sign, so that the rest of the text is
//! checked, too.

use proc_macro2::{TokenStream, TokenTree};
use syn::{Lit, LitStr};

use super::DEEPEST;
use crate::mistakes::Mistake;

/// Characters that look like a sign of the language, and that sign.
const LOOK_ALIKE: [(&str, char); 16] = [
    ("−–—‐‑‒﹣－", '-'),
    ("×·⋅∙•∗＊", '*'),
    ("÷∕⁄／", '/'),
    ("＋", '+'),
    ("＝", '='),
    ("，、", ','),
    ("；", ';'),
    ("：", ':'),
    ("（", '('),
    ("）", ')'),
    ("［", '['),
    ("］", ']'),
    ("｛", '{'),
    ("｝", '}'),
    ("“”„‟«»＂", '"'),
    ("．", '.'),
];

/// Signs of mathematics that are written as words: the sign, its replacement, and a hint.
const WRITTEN: [(&str, char, &str); 14] = [
    ("²", ' ', "a square is written `x.powi(2)`"),
    ("³", ' ', "a third power is written `x.powi(3)`"),
    ("⁰¹⁴⁵⁶⁷⁸⁹⁻⁺", ' ', "a power is written `x.powi(4)`"),
    ("√", ' ', "a root is written `x.sqrt()`"),
    ("∑", ' ', "a sum is written `sum(0..n, |i| x[i])`"),
    ("∏", ' ', "a product is written `product(0..n, |i| x[i])`"),
    (
        "∂∇",
        ' ',
        "the equations of motion are derived for you; the time derivative is written `dot(x)`",
    ),
    ("∞", '0', "expected a number that is finite"),
    ("≤", '<', "written `<=`"),
    ("≥", '>', "written `>=`"),
    ("≠", '<', "written `<` or `>`"),
    ("½", '1', "written `0.5`"),
    ("°", ' ', "angles are in radians: 30° are written `pi / 6`"),
    ("…", '0', "in messages it stands for an expression of your own"),
];

/// With more mistakes than this, the rest is not checked: it is no text of the language.
const MOST: usize = 50;

/// A text with look-alikes replaced, character by character, and the mistakes found.
pub(super) fn read(text: &str) -> (String, Vec<Mistake>) {
    let mut reader = Reader {
        characters: text.chars().collect(),
        at: 0,
        line: 1,
        column: 1,
        is_blank: true,
        read: String::with_capacity(text.len()),
        open: Vec::new(),
        mistakes: Vec::new(),
    };
    reader.read_all();
    reader
        .mistakes
        .sort_by_key(|mistake| [mistake.line, mistake.column]);
    (reader.read, reader.mistakes)
}

/// A line and a column of a text.
#[derive(Clone, Copy)]
struct Place {
    line: usize,
    column: usize,
}

/// The state of the check.
struct Reader {
    characters: Vec<char>,
    /// The index of the next character.
    at: usize,
    /// The line of the next character; `column` is its column.
    line: usize,
    column: usize,
    /// Whether only white space stands before it in its line.
    is_blank: bool,
    /// The checked text so far.
    read: String,
    /// The brackets that are open, and their places.
    open: Vec<(char, Place)>,
    mistakes: Vec<Mistake>,
}

impl Reader {
    fn peek(&self, ahead: usize) -> Option<char> {
        self.characters.get(self.at + ahead).copied()
    }

    fn before(&self) -> Option<char> {
        let at = self.at.checked_sub(1)?;
        self.characters.get(at).copied()
    }

    fn place(&self) -> Place {
        Place {
            line: self.line,
            column: self.column,
        }
    }

    fn mistake(&mut self, at: Place, message: impl Into<String>) {
        let mistake = Mistake::of_character(at.line, at.column, message.into());
        self.mistakes.push(mistake);
    }

    /// Goes on by one character, and writes another in its place.
    fn write(&mut self, read: char) {
        let Some(character) = self.peek(0) else { return };
        self.is_blank = character == '\n' || (self.is_blank && character.is_whitespace());
        if let Some(message) = message_if_invisible(character, self.peek(1)) {
            let at = self.place();
            self.mistake(at, message);
            self.read.push(' ');
        } else {
            self.read.push(read);
        }
        self.at += 1;
        if character == '\n' {
            self.line += 1;
            self.column = 1;
        } else {
            self.column += 1;
        }
    }

    /// Goes on by one character, which stays.
    fn copy(&mut self) {
        let character = self.peek(0).unwrap_or(' ');
        self.write(character);
    }

    /// Goes on to the end of the line, and writes blanks.
    fn blank_line(&mut self) {
        while self.peek(0).is_some_and(|c| c != '\n') {
            self.write(' ');
        }
    }

    fn read_all(&mut self) {
        while let Some(character) = self.peek(0) {
            if self.mistakes.len() >= MOST {
                return;
            }
            match character {
                '/' if self.peek(1) == Some('/') => {
                    while self.peek(0).is_some_and(|c| c != '\n') {
                        self.copy();
                    }
                }
                '/' if self.peek(1) == Some('*') => self.comment(),
                '"' => self.string(&['"']),
                '\'' | '′' | '’' | '‘' | '″' | '`' => self.apostrophe(character),
                '#' => self.hash(),
                '%' if self.is_blank => {
                    let at = self.place();
                    self.mistake(at, "a comment begins with `//`");
                    self.blank_line();
                }
                '(' | '[' | '{' => {
                    let at = self.place();
                    if self.open.len() == DEEPEST {
                        self.mistake(at, super::too_deep());
                        return;
                    }
                    self.open.push((character, at));
                    self.copy();
                }
                ')' | ']' | '}' => {
                    self.close(character);
                    self.copy();
                }
                ';' => {
                    // no statement ends inside parentheses
                    while let Some(&('(', at)) = self.open.last() {
                        self.open.pop();
                        self.mistake(at, "this `(` has no `)` before the end of the statement, `;`");
                    }
                    self.copy();
                }
                _ => self.other_character(character),
            }
        }
        while let Some((bracket, at)) = self.open.pop() {
            let message = format!("this `{bracket}` has no `{}`", partner(bracket));
            self.mistake(at, message);
        }
    }

    /// Goes past a comment between `/*` and `*/`, which may be nested.
    fn comment(&mut self) {
        let at = self.place();
        let mut depth = 0;
        loop {
            match (self.peek(0), self.peek(1)) {
                (Some('/'), Some('*')) => depth += 1,
                (Some('*'), Some('/')) => depth -= 1,
                (None, _) => {
                    self.mistake(at, "this comment has no end, `*/`");
                    return;
                }
                _ => {
                    self.copy();
                    continue;
                }
            }
            self.copy();
            self.copy();
            if depth == 0 {
                return;
            }
        }
    }

    /// Goes past a string, from its opening quotation mark on.
    fn string(&mut self, ends: &[char]) {
        let at = self.place();
        let line = self.characters[self.at + 1..].iter().take_while(|&&c| c != '\n');
        let is_closed = line.into_iter().any(|c| ends.contains(c));
        self.write('"');
        loop {
            match self.peek(0) {
                Some('\\') => {
                    self.copy();
                    self.copy();
                }
                Some(end) if ends.contains(&end) => {
                    self.write('"');
                    return;
                }
                other
                    if matches!(other, None | Some('\n'))
                        || (!is_closed && matches!(other, Some(')' | ',' | ';' | '}'))) =>
                {
                    self.mistake(at, "this quotation mark has no partner in its line");
                    // the rest is read as if the string were closed
                    let last = self.read.pop();
                    self.read.push(if last == Some('"') { ' ' } else { '"' });
                    return;
                }
                _ => self.copy(),
            }
        }
    }

    /// An apostrophe: a derivative in other notations, or half of a pair of quotation marks.
    fn apostrophe(&mut self, sign: char) {
        let at = self.place();
        let before: String = self.read.chars().rev().take_while(|&c| is_of_name(c)).collect();
        let name: String = before.chars().rev().collect();
        if sign != '`' && (!name.is_empty() || matches!(self.before(), Some(')' | ']'))) {
            let argument = if name.is_empty() { "…" } else { &name };
            let second = sign == '″' || self.peek(1) == Some(sign);
            let word = if second { "ddot" } else { "dot" };
            self.mistake(
                at,
                format!("a time derivative is written `{word}({argument})`, without `{sign}`"),
            );
            self.write(' ');
            if second && self.peek(0) == Some(sign) {
                self.write(' ');
            }
            return;
        }
        let rest = self.characters[self.at + 1..].iter().take_while(|&&c| c != '\n');
        let has_partner = rest.into_iter().any(|&c| c == sign || (sign == '‘' && c == '’'));
        if has_partner {
            self.mistake(
                at,
                "the name of a file stands in double quotation marks, `\"wind.csv\"`",
            );
            self.string(&[sign, '’']);
        } else {
            self.mistake(at, format!("`{sign}` has no meaning here"));
            self.write(' ');
        }
    }

    /// `#`, which begins a comment in other languages.
    fn hash(&mut self) {
        // `#[doc = "…"]`, or a name such as `r#type`
        if matches!(self.peek(1), Some('[' | '!')) || self.before() == Some('r') {
            self.copy();
            return;
        }
        let at = self.place();
        self.mistake(at, "a comment begins with `//`, documentation with `///`");
        self.blank_line();
    }

    /// A closing bracket.
    fn close(&mut self, bracket: char) {
        let at = self.place();
        let Some(place) = self.open.iter().rposition(|(open, _)| partner(*open) == bracket) else {
            self.mistake(at, format!("this `{bracket}` closes no bracket"));
            return;
        };
        while self.open.len() > place + 1 {
            if let Some((open, from)) = self.open.pop() {
                let message = format!("this `{open}` has no `{}` before the `{bracket}`", partner(open));
                self.mistake(from, message);
            }
        }
        self.open.pop();
    }

    fn other_character(&mut self, character: char) {
        let at = self.place();
        if let Some((_, meant)) = LOOK_ALIKE.iter().find(|(signs, _)| signs.contains(character)) {
            if *meant == '"' {
                self.mistake(at, format!("`{character}` looks like `\"`; expected `\"`"));
                self.string(&['"', '”', '“', '»', '«', '‟', '＂']);
                return;
            }
            self.mistake(
                at,
                format!("`{character}` looks like `{meant}`; expected `{meant}`"),
            );
            match meant {
                '(' | '[' | '{' => self.open.push((*meant, at)),
                ')' | ']' | '}' => self.close(*meant),
                _ => {}
            }
            self.write(*meant);
        } else if let Some((_, read, how)) = WRITTEN.iter().find(|(signs, ..)| signs.contains(character)) {
            self.mistake(at, format!("`{character}` has no meaning here; {how}"));
            self.write(*read);
        } else if let Some(digit) = subscript(character) {
            self.mistake(
                at,
                format!("`{character}` has no meaning here; expected `{digit}`"),
            );
            self.write(digit);
        } else if matches!(character, '\\' | '$' | '@' | '~') {
            self.mistake(
                at,
                format!("`{character}` has no meaning here; a name stands alone, as `theta`"),
            );
            self.write(' ');
        } else if character.is_ascii() || is_of_name(character) || character.is_whitespace() {
            self.copy();
        } else if message_if_invisible(character, self.peek(1)).is_some() {
            self.write(' ');
        } else if matches!(character, '\u{ad}' | '\u{feff}' | '\u{200b}'..='\u{200f}' | '\u{2060}'..='\u{206f}')
        {
            self.mistake(at, message_for_invisible(character));
            let within = self.before().is_some_and(is_of_name) && self.peek(1).is_some_and(is_of_name);
            self.write(if within { '_' } else { ' ' });
        } else {
            let code = u32::from(character);
            self.mistake(at, format!("`{character}` (U+{code:04X}) has no meaning here"));
            self.write(' ');
        }
    }
}

/// The closing bracket for an opening one.
fn partner(open: char) -> char {
    match open {
        '(' => ')',
        '[' => ']',
        _ => '}',
    }
}

/// Whether a name may contain a character after its first. Exceptions are left to the lexer.
fn is_of_name(character: char) -> bool {
    let is_mark = matches!(character, '\u{300}'..='\u{36f}');
    character == '_' || character.is_alphanumeric() || is_mark
}

/// The digit of a subscript.
fn subscript(character: char) -> Option<char> {
    let digit = u32::from(character).checked_sub(u32::from('₀'))?;
    char::from_digit(digit, 10)
}

/// Refuses invisible characters in strings, because names and documentation may be shown anywhere.
pub(super) fn check_literals(tokens: &TokenStream) -> Result<(), Vec<Mistake>> {
    for tree in tokens.clone() {
        match tree {
            TokenTree::Group(group) => check_literals(&group.stream())?,
            TokenTree::Literal(literal) => {
                let span = literal.span();
                let text = match Lit::new(literal) {
                    Lit::Str(text) => LitStr::value(&text),
                    _ => continue,
                };
                let mut characters = text.chars().peekable();
                while let Some(character) = characters.next() {
                    if let Some(message) = message_if_invisible(character, characters.peek().copied()) {
                        return Err(vec![Mistake::of(span, message)]);
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The error for a control character, or for one that changes the direction of a line; `None` for other
/// characters.
fn message_if_invisible(character: char, next: Option<char>) -> Option<String> {
    let is_end_of_line = character == '\r' && next == Some('\n');
    let is_space = matches!(character, '\n' | '\t') || is_end_of_line;
    let hides = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    ((character.is_control() && !is_space) || hides).then(|| message_for_invisible(character))
}

/// The error for an invisible character.
fn message_for_invisible(character: char) -> String {
    let code = u32::from(character);
    format!("the character U+{code:04X}, which is not seen, is out of place here")
}
