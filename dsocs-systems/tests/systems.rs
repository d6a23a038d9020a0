//! The systems of this crate against their exact solutions, independent references and closed forms; and the
//! names in their declarations.

mod chain {
    use dsocs_core::System;
    use dsocs_systems::PlanarChain2;

    #[test]
    fn angles_and_parameters_have_names() {
        let angles = PlanarChain2::COORDINATES;
        let angles = angles.each_ref().map(|angle| (&*angle.name, angle.unit()));
        assert_eq!(angles, [("theta_0", Some("rad")), ("theta_1", Some("rad"))]);
        let names: Vec<_> = PlanarChain2::PARAMETERS
            .iter()
            .map(|parameter| &*parameter.name)
            .collect();
        assert_eq!(
            names,
            ["masses_0", "masses_1", "lengths_0", "lengths_1", "gravity"]
        );
        let mut chain = PlanarChain2::default();
        *chain.parameter_mut(3).unwrap() = 7.0;
        assert_eq!((chain.lengths, chain.parameter(3)), ([0.5, 7.0], Some(7.0)));
    }
}

mod pendulum {
    use dsocs_core::__private::Declaration;

    use dsocs_core::Point;
    use dsocs_systems::InertiaWheelPendulum;

    #[test]
    fn the_lyapunov_function_starts_where_the_reference_says() {
        let v = InertiaWheelPendulum::default().lyapunov([0.5, 0.0], [0.0, 0.5]);
        assert!((v - 14_770.162_450_804_23).abs() < 1e-9, "{v}");
    }

    #[test]
    fn the_proper_branch_meets_the_declared_constraint() {
        let pendulum = InertiaWheelPendulum::default();
        for state in [
            [0.5, 0.0, 1.0, 1.0],
            [-0.3, 20.0, 40.0, -2.5],
            [0.01, -70.0, -3.0, 0.7],
        ] {
            let [theta, psi, p1, p2] = state;
            let [theta_rate, psi_rate, p1_rate, p2_rate] = pendulum.proper_branch(state);
            let a = pendulum.velocity([p1_rate, p2_rate]);
            let point = Point {
                t: 0.0,
                q: [theta, psi],
                v: [theta_rate, psi_rate],
                a,
            };
            let rows = Declaration::of(&pendulum).continuous(point.any(), &[]);
            let back = pendulum.momentum(point.v);
            assert!((back[0] - p1).abs() < 1e-12 && (back[1] - p2).abs() < 1e-12);
            assert!(rows.iter().all(|row| row.abs() < 1e-8), "{rows:?}");
        }
    }
}

mod particle {
    use dsocs_systems::{Constant, CurvedParticle};

    #[test]
    fn the_exact_solution_is_the_papers() {
        for t in [0.0, 0.3, 7.0, 123.4, 500.0] {
            let (q, v) = CurvedParticle::default().exact([0.0, 0.0], [1.0, 1.0], t);
            let phase = 2f64.sqrt() * t - std::f64::consts::FRAC_PI_4;
            let x = phase.cos() - 0.5f64.sqrt();
            let y = phase.sin() + 0.5f64.sqrt();
            assert!((q[0] - x).abs() < 1e-12 && (q[1] - y).abs() < 1e-12, "{t}");
            let speed = 2f64.sqrt();
            assert!((v[0] + speed * phase.sin()).abs() < 1e-12 && (v[1] - speed * phase.cos()).abs() < 1e-12);
        }
    }

    #[test]
    fn a_small_curvature_is_nearly_a_straight_line() {
        let at = |curvature| CurvedParticle {
            mass: 1.0,
            curvature: Constant(curvature),
        };
        let (straight, _) = at(0.0).exact([1.0, 2.0], [3.0, 4.0], 5.0);
        assert!((straight[0] - 16.0).abs() < 1e-14 && (straight[1] - 22.0).abs() < 1e-14);
        // the sagitta of the arc: κ s² / 2 with the length s = 25
        let (bent, _) = at(1e-12).exact([1.0, 2.0], [3.0, 4.0], 5.0);
        let sagitta = 1e-12 * 625.0 / 2.0;
        assert!((bent[0] - straight[0] + 0.8 * sagitta).abs() < 1e-14);
        assert!((bent[1] - straight[1] - 0.6 * sagitta).abs() < 1e-14);
    }
}

mod reference {
    use dsocs_systems::InertiaWheelPendulum;
    use dsocs_systems::reference::{Reference, ReferenceError};

    #[test]
    fn the_reference_is_accurate() -> Result<(), ReferenceError> {
        let pendulum = InertiaWheelPendulum::default();
        let reference = Reference::new(&pendulum, [0.5, 0.0], [0.0, 0.5], 0.1, 20_000)?;
        let value = reference.lyapunov(&pendulum, 20_000).unwrap_or(f64::NAN);
        // from Taylor series of order 70 in 200-bit arithmetic
        assert!((value - 195.472_779_467_478_1).abs() < 1e-8, "{value}");
        assert!((reference.states[10][0] + 4.421_440_434_001_807_5e-1).abs() < 1e-12);
        assert_eq!(reference.lyapunov(&pendulum, 20_001), None);
        Ok(())
    }
}

mod experiment {
    use dsocs_systems::experiment::{ErrorRow, StartRule, fit};

    #[test]
    fn a_power_law_has_its_exponent_as_slope() {
        let rows: Vec<_> = [0.1, 0.05, 0.01]
            .map(|h: f64| ErrorRow {
                h,
                start: StartRule::Paper,
                max_error: 3.0 * h.powf(1.5),
            })
            .to_vec();
        let (slope, intercept) = fit(&rows, StartRule::Paper);
        assert!((slope - 1.5).abs() < 1e-12 && (intercept - 3f64.ln()).abs() < 1e-12);
    }
}

mod texts {
    use std::ops::ControlFlow;

    use dsocs_core::Quantity;
    use dsocs_systems::Entry;
    use dsocs_systems::entry::{Beginning, Method, Plan, Shape, rotated};
    use dsocs_systems::systems::{quaternion_top, texts::TEXTS};

    /// The entry of the text of this name.
    fn entry(name: &str) -> Entry {
        let mut all = TEXTS.iter();
        all.find(|shipped| shipped.name == name)
            .unwrap()
            .entry(&[])
            .unwrap()
    }

    /// A node of a run.
    struct Node {
        t: f64,
        q: Vec<f64>,
        v: Vec<f64>,
        force: Vec<f64>,
        energy: f64,
        observed: Vec<f64>,
    }

    /// The nodes of a run from the entry's start to `until`.
    fn nodes(entry: &Entry, h: f64, until: f64, method: Method) -> Vec<Node> {
        let [q0, v0] = entry.default_start().unwrap().clone();
        let beginning = Beginning::SecondOrder { q0, v0 };
        let beginning = if entry.projects() {
            Beginning::Projected(Box::new(beginning))
        } else {
            beginning
        };
        let plan = Plan {
            h,
            until,
            method,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        let mut nodes = Vec::new();
        let count = entry.kernel().shape().observables.len();
        let mut take = |row: &dsocs_systems::entry::Row<'_>| {
            let mut observed = vec![0.0; count];
            row.declaration.observe(row.node.point(), &mut observed);
            let node = row.node;
            nodes.push(Node {
                t: node.t,
                q: node.q.to_vec(),
                v: node.v.to_vec(),
                force: node.force.to_vec(),
                energy: node.energy,
                observed,
            });
            ControlFlow::Continue(())
        };
        entry.run(&plan, &beginning, &mut take).unwrap();
        nodes
    }

    /// Every text of the library has the kind that its list entry states, a meaning and a unit for each
    /// quantity, and a drawing with a body in space.
    #[test]
    fn what_they_say_is_complete_and_they_are_drawn() {
        for shipped in TEXTS {
            let mut entry = shipped.entry(&[]).unwrap();
            entry.verify().unwrap();
            let name = shipped.name;
            assert_eq!(
                entry.kind(),
                shipped.kind,
                "{name}: what a list says without reading the text"
            );
            assert_eq!(
                entry.checked_end() < entry.default_until(),
                name == "bodies",
                "{name}"
            );
            let description = entry.description().clone();
            let texts = [
                &description.coordinates,
                &description.parameters,
                &description.observables,
            ];
            for quantity in texts.into_iter().flatten() {
                let Quantity { name: of, .. } = quantity;
                assert!(
                    !quantity.meaning().is_empty() && quantity.unit().is_some(),
                    "{name}: {of}"
                );
            }
            let [q0, _] = entry.default_start().unwrap().clone();
            let drawing = entry.drawing().unwrap()(&q0);
            assert!(
                drawing
                    .shapes()
                    .iter()
                    .any(|shape| matches!(shape, Shape::Solid(_))),
                "{name}"
            );
            // declarations are short: without comments, parameters, the run and the names of coordinates
            let lines = shipped.text.lines().map(str::trim);
            let declared = lines
                .skip_while(|line| !line.starts_with(')'))
                .skip(1)
                .take_while(|line| !line.starts_with("run {"));
            let count = declared.filter(|line| !line.starts_with("//")).count();
            assert!(count <= 17, "{name}: {count}");
        }
    }

    #[test]
    fn the_top_is_that_of_a_quaternion_under_a_constraint() {
        let series = Method::Tolerance(1e-14);
        let ends = [entry("heavy-top"), quaternion_top::entry()].map(|entry| {
            let nodes = nodes(&entry, 0.5, 3.0, series);
            nodes.last().unwrap().q.clone()
        });
        let sign = (ends[0][0] * ends[1][0]).signum();
        for (one, other) in ends[0].iter().zip(&ends[1]) {
            assert!((one - sign * other).abs() < 1e-9, "{ends:?}");
        }
        // the momenta about the vertical and the axis, and the energy: at nodes their error is of second
        // order, and does not grow
        let top = entry("heavy-top");
        let worst = |h: f64| {
            let nodes = nodes(&top, h, 5.0, Method::Step);
            let kept = |node: &Node| [node.observed[3], 0.02 * node.v[3], node.energy];
            let first = kept(&nodes[0]);
            let apart = |node: &Node| [0, 1, 2].map(|i| (kept(node)[i] - first[i]).abs());
            let all = nodes.iter().map(apart);
            all.fold([0.0_f64; 3], |most, apart| {
                [0, 1, 2].map(|i| most[i].max(apart[i]))
            })
        };
        let [coarse, fine] = [0.002, 0.001].map(worst);
        for i in 0..3 {
            assert!(
                coarse[i] < 1e-2 && (coarse[i] / fine[i]).log2() > 1.9,
                "{coarse:?} {fine:?}"
            );
        }
    }

    #[test]
    fn the_ball_goes_round_a_circle_at_two_sevenths_of_the_tables_rate() {
        let entry = entry("turntable");
        let nodes = nodes(&entry, 0.5, 40.0, Method::Tolerance(1e-14));
        let ([x, y], [u, v]) = ([4, 5].map(|i| nodes[0].q[i]), [4, 5].map(|i| nodes[0].v[i]));
        let k = 2.0 / 7.0 * 2.0;
        for node in &nodes {
            let (sin, cos) = (k * node.t).sin_cos();
            let known = [
                x + (sin * u + (cos - 1.0) * v) / k,
                y + ((1.0 - cos) * u + sin * v) / k,
            ];
            for (found, known) in node.q[4..].iter().zip(known) {
                assert!((found - known).abs() < 1e-10, "{}: {found} {known}", node.t);
            }
            assert!((node.observed[0] - nodes[0].observed[0]).abs() < 1e-12);
        }
    }

    #[test]
    fn the_satellite_comes_to_its_target_by_torques_inside_it() {
        let entry = entry("satellite");
        let nodes = nodes(&entry, 0.02, 20.0, Method::Step);
        for pair in nodes.windows(2) {
            assert!(pair[1].observed[0] < pair[0].observed[0], "{}", pair[1].t);
        }
        let last = nodes.last().unwrap();
        assert!((last.q[0].abs() - 1.0).abs() < 1e-6 && last.observed[0] < 1e-6);
        // by a series, since the momentum at a node is that of the motion to second order only
        let nodes = self::nodes(&entry, 1.0, 20.0, Method::Tolerance(1e-13));
        for node in &nodes {
            for i in 1..4 {
                assert!(
                    (node.observed[i] - nodes[0].observed[i]).abs() < 1e-11,
                    "{:?}",
                    node.observed
                );
            }
            // no external torque acts on the body
            assert!(
                node.force[..4].iter().all(|torque| torque.abs() < 1e-12),
                "{:?}",
                node.force
            );
        }
        assert!(nodes[1].force[4..].iter().all(|torque| torque.abs() > 1e-3));
    }

    #[test]
    fn the_quadrotor_flies_to_its_point() {
        let nodes = nodes(&entry("quadrotor"), 0.005, 6.0, Method::Step);
        let last = nodes.last().unwrap();
        for (place, target) in last.q[4..].iter().zip([2.0, 1.0, 1.5]) {
            assert!((place - target).abs() < 0.01, "{:?}", last.q);
        }
        assert!(last.v.iter().all(|v| v.abs() < 0.02), "{:?}", last.v);
        assert!((last.observed[0] - 0.8 * 9.81).abs() < 0.02);
    }

    #[test]
    fn the_coin_stays_on_the_table_and_bodies_at_their_joints() {
        let coin = entry("coin");
        let height = |h: f64| {
            let nodes = nodes(&coin, h, 2.0, Method::Step);
            let off = nodes.iter().map(|node| {
                let [w, x, y, z] = [0, 1, 2, 3].map(|i| node.q[i]);
                let third = [0.0, 1.0].map(|axis| rotated([w, x, y, z], [1.0 - axis, axis, 0.0])[2]);
                node.q[6] - 0.6 * third[0].hypot(third[1])
            });
            off.fold(0.0_f64, |most, off| most.max(off.abs()))
        };
        let heights = [0.01, 0.005].map(height);
        assert!(
            heights[0] < 1e-3 && (heights[0] / heights[1]).log2() > 1.9,
            "{heights:?}"
        );
        let nodes = nodes(&entry("bodies"), 0.005, 1.0, Method::Step);
        for node in &nodes {
            let mut joint = [0.0; 3];
            let (bodies, _) = node.q.as_chunks::<7>();
            for &[w, x, y, z, at @ ..] in bodies {
                let half = rotated([w, x, y, z], [0.0, 0.0, -0.225]);
                for i in 0..3 {
                    assert!((at[i] - half[i] - joint[i]).abs() < 1e-13, "{}", node.t);
                }
                joint = [0, 1, 2].map(|i| at[i] + half[i]);
            }
            assert!((node.energy - nodes[0].energy).abs() < 2e-2, "{}", node.energy);
        }
    }

    #[test]
    fn suslovs_body_does_not_turn_about_its_axis() {
        for node in nodes(&entry("suslov"), 0.02, 30.0, Method::Step) {
            assert!(node.v[3].abs() < 1e-12, "{}", node.t);
            assert!(node.force[1..3].iter().all(|torque| torque.abs() < 1e-12));
        }
    }
}
