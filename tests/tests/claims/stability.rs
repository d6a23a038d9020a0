//! The short form of every hard case stays within its bounds; `dsocs stability` shows the figures.

use dsocs_systems::stability::{CASES, Row};

/// Runs one case.
fn check(number: u8) {
    let case = CASES.iter().find(|case| case.number == number).unwrap();
    let rows = case.run(true, &mut |_| {});
    assert!(!rows.is_empty());
    let missed: Vec<&Row> = rows.iter().filter(|row| !row.ok()).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

macro_rules! cases {
    ($($name:ident: $number:literal;)*) => {
        $(
            #[test]
            fn $name() {
                check($number);
            }
        )*

        #[test]
        fn no_case_is_left_out() {
            let numbers: Vec<u8> = CASES.iter().map(|case| case.number).collect();
            assert_eq!(numbers, [$($number),*]);
        }
    };
}

cases! {
    long_runs: 1;
    small_steps: 2;
    large_turns: 3;
    scales: 4;
    close_roots: 5;
    singular_points: 6;
    stiff_switch: 7;
    backward: 8;
    garbage: 9;
    library_functions: 10;
    beside_a_general_method: 11;
    two_roots: 12;
    chains_at_rest: 13;
    certificates: 14;
    random_scenes: 15;
    friction_on_moving_surfaces: 16;
}
