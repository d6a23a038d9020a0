//! `check --orders`: the orders of the parts of the discretization, as tables.

use std::path::Path;

use comfy_table::{Cell, CellAlignment, Color, presets};
use serde_json::{Value, json};

use crate::check::orders::{Order, Orders, Part, Variant, statement_of};
use crate::cli::CliError;
use crate::cli::commands::check::CheckArguments;
use crate::cli::output;
use crate::cli::output::terminal;
use crate::entry::Entry;
use crate::stability::number;

/// The columns of the table over systems and maps.
const COLUMNS: [&str; 8] = [
    "system",
    "map",
    "`L_d`",
    "`D₁L_d + D₂L_d`",
    "`D_K`",
    "`D_V`",
    "follows",
    "seen",
];

/// A system with its orders by one map or several.
struct SystemOrders {
    /// Its name.
    name: String,
    /// The title of its table, in a line.
    title: String,
    /// The step.
    h: f64,
    /// Its declaration.
    declaration: String,
    /// The orders.
    variants: Vec<Variant>,
}

/// Measures the orders of systems.
///
/// # Errors
///
/// [`CliError`] if an option does not fit, the motion of the only system cannot be computed, the file cannot be written, or an order is not seen.
pub fn orders(arguments: &CheckArguments, entries: Vec<&mut Entry>) -> Result<(), CliError> {
    let is_one = entries.len() == 1;
    let mut failed = Vec::new();
    let mut all = Vec::new();
    for entry in entries {
        let motion = arguments.motion(entry)?;
        let settings = motion.settings();
        let measured = if arguments.with_every_map() {
            entry.orders_by_map(&settings)
        } else {
            entry
                .orders(&settings)
                .map(|orders| vec![Variant::declared(orders)])
        };
        match measured {
            Ok(variants) => all.push(SystemOrders {
                name: entry.name().to_owned(),
                title: format!("{} ({}), h = {}", entry.name(), entry.kind(), settings.h),
                h: settings.h,
                declaration: entry.kernel().shape().declaration.to_string(),
                variants,
            }),
            Err(failure) if is_one => return Err(failure.into()),
            Err(failure) => failed.push((entry.name().to_owned(), CliError::from(failure).to_string())),
        }
    }
    let missed = |of: &SystemOrders| of.variants.iter().filter(|variant| !variant.ok()).count();
    let missed: usize = all.iter().map(missed).sum();
    if let Some(path) = arguments.out() {
        write(path, &all, &failed)?;
    }
    let mut text = if arguments.with_every_map() {
        overview(&all)
    } else {
        all.iter().map(table_of_system).collect()
    };
    for (name, failure) in &failed {
        text.extend([name, ": not measured: ", failure, "\n"]);
    }
    terminal::print_figures(&text, missed)
}

/// Writes the values as JSON, or the table as Markdown.
fn write(path: &Path, all: &[SystemOrders], failed: &[(String, String)]) -> Result<(), CliError> {
    if path.extension().is_some_and(|ending| ending == "md") {
        return output::write(path, markdown(all).as_bytes());
    }
    let systems = all.iter().map(|of| {
        let maps = of.variants.iter().map(value).collect::<Vec<_>>();
        json!({"system": of.name, "step": of.h, "maps": maps})
    });
    let failed = failed
        .iter()
        .map(|(name, failure)| json!({"system": name, "failure": failure}));
    let all = json!({ "systems": systems.chain(failed).collect::<Vec<_>>() });
    output::write(path, format!("{all:#}\n").as_bytes())
}

/// An order in a table, to this number of decimals.
fn rounded(order: &Order, decimals: usize) -> String {
    match order {
        Order::Exact => "exact".to_owned(),
        // no minus before a zero
        Order::Power { power, .. } => {
            format!("{:.decimals$}", if power.abs() < 0.005 { 0.0 } else { *power })
        }
        Order::Unknown(_) => "–".to_owned(),
    }
}

/// An order in a table, to two decimals.
fn two_decimals(order: &Order) -> String {
    rounded(order, 2)
}

/// The lowest of the orders of some parts; empty if the system has none of them.
fn lowest(orders: &Orders, parts: &[Part], decimals: usize) -> String {
    let found = parts.iter().filter_map(|part| orders.of(*part));
    let least = found.reduce(|least, order| match (least.number(), order.number()) {
        (Some(x), Some(y)) if y < x => order,
        (Some(_), None) => order,
        _ => least,
    });
    least.map_or_else(String::new, |order| rounded(order, decimals))
}

/// The cells of a row of the table over systems and maps, from the map on.
fn cells(variant: &Variant, decimals: usize) -> [String; 7] {
    let map = variant.map.name.to_owned();
    let Ok(orders) = &variant.orders else {
        let nothing = || "–".to_owned();
        return [
            map,
            nothing(),
            nothing(),
            nothing(),
            nothing(),
            nothing(),
            nothing(),
        ];
    };
    let constraints = [Part::Positions, Part::Velocities, Part::Accelerations];
    [
        map,
        lowest(orders, &[Part::Lagrangian], decimals),
        lowest(orders, &[Part::Forces, Part::ExternalForces], decimals),
        lowest(orders, &constraints, decimals),
        lowest(orders, &[Part::Displacements], decimals),
        match orders.follows.number() {
            Some(number) if number.is_finite() => format!("{number}"),
            _ => two_decimals(&orders.follows),
        },
        rounded(&orders.seen, decimals),
    ]
}

/// The table over systems and maps as Markdown, with one row for the maps of a system that have the same orders, to one decimal.
fn markdown(all: &[SystemOrders]) -> String {
    let mut text = format!("| {} |\n|{}\n", COLUMNS.join(" | "), "---|".repeat(COLUMNS.len()));
    for of in all {
        let mut rows: Vec<(Vec<String>, [String; 6])> = Vec::new();
        for variant in &of.variants {
            let [map, rest @ ..] = cells(variant, 1);
            match rows.iter_mut().find(|(_, others)| *others == rest) {
                Some((maps, _)) => maps.push(map),
                None => rows.push((vec![map], rest)),
            }
        }
        for (maps, rest) in rows {
            let cells = [of.name.clone(), maps.join(", "), rest.join(" | ")];
            text.extend(["| ", &cells.join(" | "), " |\n"]);
        }
    }
    text
}

/// The table over systems and maps, with notes below it.
fn overview(all: &[SystemOrders]) -> String {
    let mut table = terminal::table(presets::UTF8_FULL_CONDENSED);
    table.set_header(COLUMNS.map(|column| column.replace('`', "")));
    let mut remarks: Vec<(&str, Vec<String>)> = Vec::new();
    let mut say = |remark, of: String| match remarks.iter_mut().find(|(text, _)| *text == remark) {
        Some((_, others)) => others.push(of),
        None => remarks.push((remark, vec![of])),
    };
    for of in all {
        for variant in &of.variants {
            let whose = format!("{}, {}", of.name, variant.map.name);
            let [map, numbers @ .., seen] = cells(variant, 2);
            let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
            let mut row = vec![Cell::new(&of.name), Cell::new(map)];
            row.extend(numbers.map(right));
            row.push(right(seen).fg(colour(variant)));
            table.add_row(row);
            match &variant.orders {
                Err(reason) => say(reason.lines().next().unwrap_or_default(), whose),
                Ok(orders) => {
                    if let (false, Some(excuse)) = (orders.holds(), &orders.excuse) {
                        say(excuse, whose);
                    }
                }
            }
        }
    }
    let remarks = remarks
        .into_iter()
        .map(|(remark, of)| format!("{}: {remark}\n", of.join("; ")));
    format!("{table}\n{}", remarks.collect::<String>())
}

/// The colour of a row: green if the orders hold, yellow if they are acceptable, red if not.
fn colour(variant: &Variant) -> Color {
    match &variant.orders {
        Ok(orders) if orders.holds() => Color::Green,
        Ok(orders) if orders.ok() => Color::Yellow,
        Ok(_) => Color::Red,
        Err(_) => Color::Reset,
    }
}

/// The orders of one system, part by part.
fn table_of_system(of: &SystemOrders) -> String {
    let Some(Variant {
        orders: Ok(orders), ..
    }) = of.variants.first()
    else {
        return String::new();
    };
    let mut table = terminal::table(presets::UTF8_FULL_CONDENSED);
    table.set_header([
        "part".to_owned(),
        "against the exact".to_owned(),
        "map".to_owned(),
        "order".to_owned(),
        format!("distance at h = {}", of.h),
    ]);
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    for part in &orders.parts {
        let is_low = orders.lowering.contains(&part.part);
        let map = map_of(part.part, &of.declaration);
        table.add_row([
            Cell::new(part.part.symbol()),
            Cell::new(part.part.meaning()),
            Cell::new(if map.starts_with('|') { "formula" } else { &map }),
            right(two_decimals(&part.order)).fg(if is_low { Color::Yellow } else { Color::Reset }),
            right(match part.order {
                Order::Exact => String::new(),
                _ => number(part.distance),
            }),
        ]);
    }
    let word = match (orders.holds(), orders.ok()) {
        (true, _) => ("ok", Color::Green),
        (false, true) => ("open", Color::Yellow),
        (false, false) => ("FAILED", Color::Red),
    };
    let follows = orders.follows.number().filter(|x| x.is_finite());
    table.add_row([
        Cell::new("the flow"),
        Cell::new("the order that follows"),
        Cell::new(""),
        right(follows.map_or_else(|| two_decimals(&orders.follows), |x| format!("{x}"))),
        Cell::new(""),
    ]);
    let steps = match &orders.seen {
        Order::Power {
            steps: [first, last], ..
        } => {
            format!(", h = {} to {}", number(*first), number(*last))
        }
        _ => String::new(),
    };
    table.add_row([
        Cell::new(""),
        Cell::new(format!("the order seen{steps}")),
        Cell::new(""),
        right(two_decimals(&orders.seen)),
        Cell::new(word.0).fg(word.1),
    ]);
    let states = match orders.states {
        1 => "1 state".to_owned(),
        states => format!("{states} states"),
    };
    // the end of the run is a sum of steps: its rounding is not shown
    let until = number((orders.until * 1e4).round() / 1e4);
    let lines = notes(orders, &of.declaration).into_iter();
    let lines = lines.map(|line| line + "\n");
    format!(
        "{}: contact at {states}, errors to t = {until}\n{table}\n{}",
        of.title,
        lines.collect::<String>(),
    )
}

/// The notes below the table of a system.
fn notes(orders: &Orders, declaration: &str) -> Vec<String> {
    let lowering = orders.lowering.iter();
    let mut notes: Vec<String> = lowering
        .map(|part| lowering_note(*part, orders, declaration))
        .collect();
    notes.extend(orders.parts.iter().filter_map(|part| match &part.order {
        Order::Unknown(reason) => Some(format!(
            "{}, {}: {reason}",
            part.part.symbol(),
            part.part.meaning()
        )),
        _ => None,
    }));
    if let Order::Unknown(reason) = &orders.seen {
        notes.push(format!("the order seen: {reason}"));
    }
    notes.extend(orders.remarks.iter().cloned());
    if !orders.holds() {
        notes.extend(orders.excuse.clone());
    }
    notes
}

/// The map of a part, as it is declared.
fn map_of(part: Part, declaration: &str) -> String {
    let direct = match part {
        Part::Lagrangian | Part::Momenta | Part::Forces => "discrete_lagrangian",
        Part::Accelerations => "discrete_kinematic",
        _ => "",
    };
    if !direct.is_empty() && statement_of(declaration, direct).is_some() {
        return direct.to_owned();
    }
    let Some(statement) = part.statement() else {
        return String::new();
    };
    let given = |statement| statement_of(declaration, statement).map(str::to_owned);
    match given(statement) {
        // the map of C_V is that of C_K unless declared
        None if part == Part::Displacements => given("phi_kinematic").unwrap_or_else(|| "default".to_owned()),
        None => "default".to_owned(),
        Some(map) => map.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

/// A note on a part that lowers the order.
fn lowering_note(part: Part, orders: &Orders, declaration: &str) -> String {
    let order = orders.of(part).map_or_else(String::new, two_decimals);
    let map = map_of(part, declaration);
    let advice = match part {
        Part::Start => {
            return format!(
                "the start q1 = q0 + h v0 lowers the order of the flow: its velocity is of order {order}; `--start second-order` does not"
            );
        }
        Part::Forces | Part::Velocities => "`midpoint` and `trapezoid` are of order 2",
        Part::ExternalForces => {
            "half of each force belongs to either end of a leg, as with `midpoint` and `trapezoid`"
        }
        _ => "the central differences of `paper` are of order 2",
    };
    let statement = part.statement().unwrap_or_default();
    format!(
        "{statement} = {map} lowers the order of the flow: {} ({}) is of order {order}; {advice}",
        part.symbol(),
        part.meaning()
    )
}

/// A map's orders as JSON.
fn value(variant: &Variant) -> Value {
    let orders = match &variant.orders {
        Ok(orders) => orders,
        Err(reason) => return json!({"map": variant.map.name, "failure": reason}),
    };
    let parts = orders.parts.iter().map(|part| {
        json!({
            "part": part.part.symbol(),
            "what": part.part.meaning(),
            "order": encoded(&part.order),
            "distance": part.distance,
        })
    });
    json!({
        "map": variant.map.name,
        "statements": variant.map.statements.iter().map(|(statement, value)| format!("{statement} = {value};")).collect::<Vec<_>>(),
        "parts": parts.collect::<Vec<_>>(),
        "follows": encoded(&orders.follows),
        "seen": encoded(&orders.seen),
        "until": orders.until,
        "states": orders.states,
        "lowering": orders.lowering.iter().map(|part| part.symbol()).collect::<Vec<_>>(),
        "holds": orders.holds(),
        "excuse": orders.excuse,
        "remarks": orders.remarks,
    })
}

/// An order as JSON: its power with the steps of the fit, `"exact"`, or the reason why there is none.
fn encoded(order: &Order) -> Value {
    match order {
        Order::Exact => Value::from("exact"),
        Order::Power { power, steps } => json!({ "power": power, "steps": steps }),
        Order::Unknown(reason) => json!({ "failure": reason }),
    }
}
