//! What the systems of this crate say of themselves: names, exact solutions, references and closed forms beside the declarations.

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
