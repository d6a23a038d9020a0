//! Names that look alike: letters of two alphabets, and letters with dots above for time derivatives.

/// Letters, and the letters that they look like.
const FOLDED: [(&str, &str); 9] = [
    // the micro sign, the ohm sign, variants of Greek letters
    (
        "\u{b5}\u{2126}\u{3d5}\u{3d1}\u{3f5}\u{3f0}\u{3f1}\u{3d6}",
        "\u{3bc}\u{3a9}\u{3c6}\u{3b8}\u{3b5}\u{3ba}\u{3c1}\u{3c0}",
    ),
    // the angstrom sign
    ("\u{212b}", "\u{c5}"),
    // Cyrillic
    (
        "\u{430}\u{435}\u{43e}\u{440}\u{441}\u{443}\u{445}\u{456}\u{458}\u{455}",
        "aeopcyxijs",
    ),
    (
        "\u{410}\u{412}\u{415}\u{41a}\u{41c}\u{41d}\u{41e}\u{420}\u{421}\u{422}\u{425}",
        "ABEKMHOPCTX",
    ),
    // Greek
    (
        "\u{3bf}\u{3bd}\u{3c5}\u{3b9}\u{3b1}\u{3c1}\u{3c7}\u{3b3}\u{3ba}\u{3c9}",
        "ovuiapxykw",
    ),
    (
        "\u{391}\u{392}\u{395}\u{396}\u{397}\u{399}\u{39a}\u{39c}\u{39d}\u{39f}\u{3a1}\u{3a4}\u{3a5}\u{3a7}",
        "ABEZHIKMNOPTYX",
    ),
    ("\u{2113}", "l"),
    ("\u{131}", "i"),
    ("\u{212f}\u{210e}", "eh"),
];

/// A name with each letter replaced by the one that it looks like.
pub(crate) fn folded(name: &str) -> String {
    let once = |letter: char| {
        let found = FOLDED.iter().find_map(|(letters, others)| {
            let place = letters.chars().position(|other| other == letter)?;
            others.chars().nth(place)
        });
        found.unwrap_or(match letter {
            // full-width forms
            '\u{ff21}'..='\u{ff5a}' => char::from_u32(u32::from(letter) - 0xfee0).unwrap_or(letter),
            other => other,
        })
    };
    // twice, because a variant of a Greek letter may look like a Latin one
    name.chars().map(|letter| once(once(letter))).collect()
}

/// The error for a name that looks like a known one.
pub(crate) fn message(name: &str, known: &str) -> String {
    let mut pairs = name.chars().zip(known.chars());
    let differ = pairs.find(|(one, other)| one != other);
    let letters = differ.map_or_else(String::new, |(one, other)| {
        format!(
            ": `{one}` is U+{:04X} in one and U+{:04X} in the other",
            u32::from(one),
            u32::from(other)
        )
    });
    format!("no name `{name}` is known here; it looks like `{known}`, and has another letter{letters}")
}

/// A name without the dots above its letters, and the derivative that they mean: `dot` or `ddot`.
pub(crate) fn dotted(name: &str) -> Option<(String, &'static str)> {
    /// Letters with dots above, their plain letters, and the derivative.
    const COMPOSED: [(&str, &str, &str); 2] = [
        (
            "\u{227}\u{1e03}\u{10b}\u{1e0b}\u{117}\u{1e1f}\u{121}\u{1e23}\u{1e41}\u{1e45}\u{22f}\u{1e57}\u{1e59}\u{1e61}\u{1e6b}\u{1e87}\u{1e8b}\u{1e8f}\u{17c}",
            "abcdefghmnoprstwxyz",
            "dot",
        ),
        (
            "\u{e4}\u{eb}\u{ef}\u{f6}\u{fc}\u{1e85}\u{1e8d}\u{ff}\u{1e27}",
            "aeiouwxyh",
            "ddot",
        ),
    ];
    let (mut plain, mut word) = (String::new(), None);
    for letter in name.chars() {
        match letter {
            '\u{307}' => word = Some(if word.is_some() { "ddot" } else { "dot" }),
            '\u{308}' => word = Some("ddot"),
            _ => {
                let found = COMPOSED.iter().find_map(|(letters, others, word)| {
                    let place = letters.chars().position(|other| other == letter)?;
                    Some((others.chars().nth(place)?, *word))
                });
                if let Some((_, found)) = found {
                    word = Some(found);
                }
                plain.push(found.map_or(letter, |(letter, _)| letter));
            }
        }
    }
    Some((plain, word?))
}
