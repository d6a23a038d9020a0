//! The known name that is nearest to an unknown one.

/// `; did you mean …?` with the nearest of the candidates, or nothing if none is near.
pub(crate) fn did_you_mean<'c>(found: &str, candidates: impl IntoIterator<Item = &'c str>) -> String {
    nearest(found, candidates)
        .map(|name| format!("; did you mean `{name}`?"))
        .unwrap_or_default()
}

/// Longer names are not compared: they are no misspellings, and comparing them takes time.
const LONGEST: usize = 200;

/// The nearest of the candidates, if one is within a third of the letters.
pub(crate) fn nearest<'c>(found: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let length = found.chars().count();
    if length > LONGEST {
        return None;
    }
    let limit = length.max(3) / 3;
    candidates
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(found, name), name))
        // a name of one letter is one edit away from every other one
        .filter(|&(distance, name)| distance <= limit && distance < name.chars().count())
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}
