//! The origin of a page's numbers: version, machine, date, command.

use std::time::{SystemTime, UNIX_EPOCH};

use super::{Cell, table};

/// The table of the origin of a page's numbers. The rows of `more` come first.
pub fn provenance(more: impl IntoIterator<Item = (String, String)>) -> String {
    let own = [
        ("program", format!("dsocs {}", env!("CARGO_PKG_VERSION"))),
        ("command", command()),
        (
            "built as",
            if cfg!(debug_assertions) {
                "debug"
            } else {
                "release"
            }
            .to_owned(),
        ),
        ("machine", machine()),
        ("date", date(SystemTime::now())),
    ];
    let own = own.into_iter().map(|(what, value)| (what.to_owned(), value));
    let rows = more.into_iter().chain(own);
    let rows = rows.map(|(what, value)| vec![Cell::Text(what), Cell::Text(value)]);
    table("Where these numbers come from", &[], rows)
}

/// The command that wrote the page.
fn command() -> String {
    let quoted = |argument: String| {
        let plain = |letter: char| letter.is_alphanumeric() || "-_./=,+:".contains(letter);
        if !argument.is_empty() && argument.chars().all(plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    };
    let program = std::env::args_os().next().unwrap_or_default();
    let program = std::path::Path::new(&program)
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // the command line of a notebook's kernel shows only the path of the notebook
    if std::env::args_os().any(|argument| argument.to_string_lossy().contains("ipykernel")) {
        return "a notebook".to_owned();
    }
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.map(|argument| quoted(argument.to_string_lossy().into_owned()));
    [program]
        .into_iter()
        .chain(arguments)
        .collect::<Vec<_>>()
        .join(" ")
}

/// The machine: processor, threads, operating system.
fn machine() -> String {
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!(
        "{}, {threads} thread{}, {}",
        processor.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        if threads == 1 { "" } else { "s" },
        std::env::consts::OS
    )
}

/// A time as `2026-01-31 12:34 UTC`.
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, minutes) = (seconds / 86400, seconds % 86400 / 60);
    // days are counted from 1 March 0000, in eras of 400 years (H. Hinnant, chrono-compatible low-level date algorithms)
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 {
        from_march + 3
    } else {
        from_march - 9
    };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year}-{month:02}-{day:02} {:02}:{:02} UTC",
        minutes / 60,
        minutes % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates() {
        for (seconds, text) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (1_735_689_599, "2024-12-31 23:59 UTC"),
        ] {
            assert_eq!(date(UNIX_EPOCH + Duration::from_secs(seconds)), text);
        }
    }
}
