//! The discrete motion of the particle agrees with the reference, row by row, within double precision.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::CurvedParticle;
use dsocs_tests::data::Table;

/// The largest deviation allowed up to a time, by the README beside the reference data.
type Tolerances = [(f64, f64); 4];

fn compare(h: f64, file: &str, tolerances: Tolerances) {
    let table = Table::read(file);
    let particle = CurvedParticle::default();
    let mut flow = Flow::new(&particle, h, Start::paper([0.0, 0.0], [1.0, 1.0])).unwrap();
    let trajectory = flow.until(500.0).unwrap();
    let rows = table
        .indices("k")
        .into_iter()
        .zip(table.numbers("t"))
        .zip(table.pairs(["x", "y"]));
    let mut worst = [0.0_f64; 4];
    for ((k, t), q) in rows {
        let node = &trajectory.nodes[usize::try_from(k).unwrap()];
        assert!(
            (node.t - t).abs() <= 1e-13 * t,
            "node {k} is at {} instead of {t}",
            node.t
        );
        let deviation = (node.q[0] - q[0]).abs().max((node.q[1] - q[1]).abs());
        let band = tolerances
            .iter()
            .position(|(until, _)| t <= until + 1e-9)
            .unwrap();
        assert!(
            deviation <= tolerances[band].1,
            "h = {h}, t = {t}: {deviation:e} from the reference"
        );
        worst[band] = worst[band].max(deviation);
    }
    println!("h = {h}: largest deviations {worst:?}");
}

#[test]
fn with_the_step_0_1() {
    compare(
        0.1,
        "particle_discrete_h0.1.csv",
        [(1.0, 1e-14), (10.0, 5e-13), (100.0, 5e-11), (500.0, 1e-9)],
    );
}

#[test]
fn with_the_step_0_01() {
    compare(
        0.01,
        "particle_discrete_h0.01.csv",
        [(1.0, 1e-12), (10.0, 5e-11), (100.0, 3e-9), (500.0, 4e-8)],
    );
}
