//! The rolling disk against its closed form.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::RollingDisk;

use super::{continuous, is_second, order, start};
use dsocs_tests::motion::distance;

#[test]
fn closed_form() {
    let disk = RollingDisk::default();
    let start = start("rolling-disk");
    let exact = disk.exact(start.0, start.1, 10.0);
    let apart = distance(&continuous(&disk, start, 10.0).0, &exact);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-13, "{apart:e}");
    let steps = [0.2, 0.1, 0.05, 0.025, 0.0125];
    is_second(order(&disk, start, 10.0, &steps, |q| distance(q, &exact)));
}

#[test]
fn the_discrete_circle_has_the_radius_that_is_told() {
    let disk = RollingDisk::default();
    let (q, v) = start("rolling-disk");
    let h = 0.1;
    let mut flow = Flow::new(&disk, h, Start::second_order(q, v)).unwrap();
    // the rates of the first leg, which stay
    let v = flow.leg().d.map(|d| d / h);
    let nodes = flow.until(50.0).unwrap().nodes;
    // the centre is a quarter turn to the left of the heading
    let radius = 0.5 * v[2] / v[3] * (h * v[3] / 2.0) / (h * v[3] / 2.0).sin();
    let centre = [q[0] - radius * q[3].sin(), q[1] + radius * q[3].cos()];
    for node in &nodes {
        let found = (node.q[0] - centre[0]).hypot(node.q[1] - centre[1]);
        assert!((found / radius - 1.0).abs() < 1e-12, "{found} {radius}");
        let rolled = [v[2] * node.t, q[3] + v[3] * node.t];
        assert!((node.q[2] - rolled[0]).abs() < 1e-12 && (node.q[3] - rolled[1]).abs() < 1e-12);
    }
}

#[test]
fn it_goes_straight_without_turning() {
    let disk = RollingDisk::default();
    let (q, v) = ([0.0; 4], [1.0, 0.0, 2.0, 0.0]);
    let exact = [3.0, 0.0, 6.0, 0.0];
    assert!(distance(&disk.exact(q, v, 3.0), &exact) < 1e-15);
    assert!(distance(&continuous(&disk, (q, v), 3.0).0, &exact) < 1e-14);
}
