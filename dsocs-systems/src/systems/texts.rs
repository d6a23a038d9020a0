//! The systems that are texts: bodies that turn in space. Each is a file of the folder `texts`, which every command takes by its name.

use crate::entry::{Drawing, Entry, Kind, Parameters, Shipped, Solid, about, along, rotated};

/// The texts, in the order of lists.
pub const TEXTS: [Shipped; 7] = [
    Shipped {
        name: "heavy-top",
        summary: "the heavy top: a body that turns about a fixed point, in gravity",
        kind: Kind::Unconstrained,
        source: "textbooks, e.g. Landau and Lifshitz, Mechanics, section 35, problem 1",
        text: include_str!("texts/heavy-top.dsocs"),
        with: heavy_top,
    },
    Shipped {
        name: "bodies",
        summary: "a chain of eight rigid bodies in space, with ball joints",
        kind: Kind::Holonomic,
        source: "textbooks, e.g. Featherstone, Rigid Body Dynamics Algorithms",
        text: include_str!("texts/bodies.dsocs"),
        with: bodies,
    },
    Shipped {
        name: "quadrotor",
        summary: "a quadrotor that flies to a point by a PD law for place and attitude",
        kind: Kind::Unconstrained,
        source: "Lee, Leok and McClamroch, Geometric tracking control of a quadrotor UAV on SE(3) (2010)",
        text: include_str!("texts/quadrotor.dsocs"),
        with: quadrotor,
    },
    Shipped {
        name: "suslov",
        summary: "Suslov's problem: a body about a point that does not turn about one of its own axes",
        kind: Kind::Nonholonomic,
        source: "Suslov, Theoretical Mechanics (1902); Bloch, Nonholonomic Mechanics and Control",
        text: include_str!("texts/suslov.dsocs"),
        with: suslov,
    },
    Shipped {
        name: "turntable",
        summary: "a ball that rolls on a turntable",
        kind: Kind::Nonholonomic,
        source: "Neimark and Fufaev, Dynamics of Nonholonomic Systems; Lewis and Murray (1995)",
        text: include_str!("texts/turntable.dsocs"),
        with: turntable,
    },
    Shipped {
        name: "coin",
        summary: "a coin that rolls on a table and may lean",
        kind: Kind::Nonholonomic,
        source: "Neimark and Fufaev, Dynamics of Nonholonomic Systems; O'Reilly, The dynamics of rolling disks (1996)",
        text: include_str!("texts/coin.dsocs"),
        with: coin,
    },
    Shipped {
        name: "satellite",
        summary: "a satellite that three reaction wheels turn to its target, under Lyapunov constraints",
        kind: Kind::SecondOrder,
        source: "the Lyapunov constraint is the paper's; the body with wheels: textbooks, e.g. Hughes, Spacecraft Attitude Dynamics",
        text: include_str!("texts/satellite.dsocs"),
        with: satellite,
    },
];

/// A disc on a stem.
fn heavy_top(entry: Entry) -> Entry {
    entry.drawn(|&r: &[f64; 4], _| {
        let stem =
            |from: f64, to: f64| Solid::cylinder(0.008, to - from).moved([0.0, 0.0, f64::midpoint(from, to)]);
        let disc = Solid::cylinder(0.1, 0.03).moved([0.0, 0.0, 0.12]);
        Drawing::new()
            .solid(Solid::ground(0.4))
            .solid(stem(0.0, 0.105).placed([0.0; 3], r))
            .solid(stem(0.135, 0.2).placed([0.0; 3], r))
            .solid(disc.placed([0.0; 3], r))
            .path(rotated(r, [0.0, 0.0, 0.2]))
    })
}

/// Rods between the joints.
fn bodies(entry: Entry) -> Entry {
    // the series of 56 coordinates take long; by then the lowest body has fallen by 0.86 m
    let entry = entry.checked_until(0.5);
    entry.drawn(|q: &[f64; 56], parameters| {
        let half = parameters.get("half_2").abs();
        let (all, _) = q.as_chunks::<7>();
        all.iter()
            .fold(Drawing::new(), |drawing, &[w, x, y, z, at @ ..]| {
                drawing.solid(Solid::cuboid([0.12, 0.12, 1.9 * half]).placed(at, [w, x, y, z]))
            })
    })
}

/// Two beams, four rotors, and the target.
fn quadrotor(entry: Entry) -> Entry {
    entry.drawn(|&[w, x, y, z, at @ ..]: &[f64; 7], parameters: &Parameters| {
        let arm = 0.3;
        let beams = Solid::cuboid([2.0 * arm, 0.03, 0.03]).with(&Solid::cuboid([0.03, 2.0 * arm, 0.03]));
        let target = [0, 1, 2].map(|i| parameters.get(&format!("target_{i}")));
        let drawing = Drawing::new()
            .solid(Solid::ground(4.0).moved([1.0, 0.0, 0.0]))
            .solid(Solid::axes(0.2).moved(target))
            .solid(beams.placed(at, [w, x, y, z]));
        let rotors = [[arm, 0.0], [0.0, arm], [-arm, 0.0], [0.0, -arm]];
        let drawing = rotors.into_iter().fold(drawing, |drawing, [a, b]| {
            let rotor = Solid::cylinder(0.16, 0.02).moved([a, b, 0.05]);
            drawing.solid(rotor.placed(at, [w, x, y, z]))
        });
        drawing.path(at)
    })
}

/// A body with its axes. It does not rotate about the third one.
fn suslov(entry: Entry) -> Entry {
    entry.drawn(|&r: &[f64; 4], _| {
        let body = Solid::cuboid([0.6, 0.9, 1.0]).placed([0.0; 3], r);
        Drawing::new()
            .solid(Solid::axes(1.0).placed([0.0; 3], r))
            .solid(body)
            .path(rotated(r, [0.0, 0.0, 1.0]))
    })
}

/// A ball on the table, and the path of its point of contact.
fn turntable(entry: Entry) -> Entry {
    entry.drawn(|&[w, a, b, c, x, y]: &[f64; 6], parameters| {
        let radius = parameters.get("radius");
        Drawing::new()
            .solid(Solid::table(4.0))
            .solid(Solid::ball(radius).placed([x, y, radius], [w, a, b, c]))
            .path([x, y, 0.0])
    })
}

/// A disc on the ground, and the path of its point of contact.
fn coin(entry: Entry) -> Entry {
    entry.drawn(|&[w, a, b, c, x, y, z]: &[f64; 7], parameters| {
        let radius = parameters.get("radius");
        // the vertical in the plane of the coin, from the third row of the matrix
        let up = [2.0 * (a * c - w * b), 2.0 * (b * c + w * a)];
        let norm = up[0].hypot(up[1]);
        let lowest = [-radius * up[0] / norm, -radius * up[1] / norm, 0.0];
        let [dx, dy, _] = rotated([w, a, b, c], lowest);
        Drawing::new()
            .solid(Solid::ground(4.0))
            .solid(Solid::cylinder(radius, radius / 12.0).placed([x, y, z], [w, a, b, c]))
            .path([x + dx, y + dy, 0.0])
    })
}

/// A body, its axes, and a wheel on each of three sides.
fn satellite(entry: Entry) -> Entry {
    entry.drawn(|&[w, a, b, c, angles @ ..]: &[f64; 7], _| {
        let attitude = [w, a, b, c];
        let edges = [1.0, 1.2, 1.4];
        let body = Solid::cuboid(edges).placed([0.0; 3], attitude);
        let drawing = Drawing::new()
            .solid(Solid::axes(1.4).placed([0.0; 3], attitude))
            .solid(body);
        (0..3).fold(drawing, |drawing, axis| {
            let mut side = [0.0; 3];
            side[axis] = edges[axis] / 2.0 + 0.08;
            let wheel = Solid::cylinder(0.3, 0.1).placed([0.0; 3], along(axis));
            let turned = wheel.placed(side, about(axis, angles[axis]));
            drawing.solid(turned.placed([0.0; 3], attitude))
        })
    })
}
