//! Words that begin statements in other languages.

/// Words that begin statements in other languages, and what to write instead.
const FOREIGN_STATEMENTS: [(&str, &str); 22] = [
    ("fn", "a function is written `let f = |x| …;`"),
    ("def", "a function is written `let f = |x| …;`"),
    ("function", "a function is written `let f = |x| …;`"),
    (
        "for",
        "there are no loops: a sum is written `sum(0..n, |i| …)`, entries of a list `each(0..n, |i| …)`",
    ),
    (
        "while",
        "there are no loops: a sum is written `sum(0..n, |i| …)`, entries of a list `each(0..n, |i| …)`",
    ),
    (
        "loop",
        "there are no loops: a sum is written `sum(0..n, |i| …)`, entries of a list `each(0..n, |i| …)`",
    ),
    ("match", "a choice is written `if … { … } else { … }`"),
    (
        "return",
        "what a system does is said by `coordinates`, `lagrangian` and the other statements",
    ),
    ("import", "functions and `pi` are known without it"),
    ("from", "functions and `pi` are known without it"),
    ("using", "functions and `pi` are known without it"),
    ("include", "functions and `pi` are known without it"),
    ("struct", "parameters are written `parameters { mass = 1.0 }`"),
    ("param", "parameters are written `parameters { mass = 1.0 }`"),
    ("parameter", "parameters are written `parameters { mass = 1.0 }`"),
    ("params", "parameters are written `parameters { mass = 1.0 }`"),
    ("static", "a number is written `const n = 3;`"),
    ("var", "a name is given by `let x = …;`"),
    ("float", "a name is given by `let x = …;`"),
    ("double", "a name is given by `let x = …;`"),
    ("real", "a name is given by `let x = …;`"),
    ("coordinate", "coordinates are written `coordinates(x, y);`"),
];

/// The hint for a word that begins a statement in another language.
pub(crate) fn foreign_statement_hint(word: &str) -> Option<&'static str> {
    let found = FOREIGN_STATEMENTS.iter().find(|(known, _)| *known == word);
    found.map(|(_, hint)| *hint)
}
