//! Fuzzing: arbitrary bytes as a text file. Reading ends in a message or in a system, which takes ten steps
//! or gives an error.

#![no_main]

use dsocs_core::text::{Text, TextError};
use dsocs_core::{AnyFlow, AnyStart, Kernel};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let text = match Text::parse("fuzzed", text) {
        Ok(text) => text,
        Err(error) => {
            let own_mistake = matches!(error, TextError::Panic | TextError::Tape(_));
            assert!(!own_mistake && !error.to_string().is_empty(), "{error}");
            return;
        }
    };
    let kernel: &dyn Kernel = &text.system;
    let zeros = vec![0.0; kernel.shape().coordinates.len()];
    let run = text.runs.first();
    let start = run.and_then(|run| run.start.clone()).unwrap_or([zeros.clone(), zeros]);
    let h = run.and_then(|run| run.step).unwrap_or(0.01);
    let start = AnyStart::second_order(&start[0], &start[1]);
    if let Ok(mut flow) = AnyFlow::new(&text.system, h, &start) {
        for _ in 0..10 {
            if flow.run_mut().advance().is_err() {
                break;
            }
        }
    }
});
