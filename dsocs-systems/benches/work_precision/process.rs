//! A Python program that solves a problem in its own process, and answers questions.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The process with its input and output.
pub struct Process {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Process {
    /// Starts a script of this folder, which needs a Python package; an error gives the reason why it cannot.
    pub fn begin(script: &str, package: &str, arguments: &[String]) -> Result<Self, String> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/work_precision/");
        let mut child = Command::new("python3")
            .arg(format!("{folder}{script}"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("python3: {error}"))?;
        let (Some(questions), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipes to python3".to_owned());
        };
        let mut process = Self {
            child,
            questions,
            answers: BufReader::new(answers),
        };
        match process.ask("version").as_deref() {
            Some([_]) => Ok(process),
            _ => Err(format!("`pip install {package}` is needed")),
        }
    }

    /// The numbers in the answer to a question.
    pub fn ask(&mut self, question: &str) -> Option<Vec<f64>> {
        writeln!(self.questions, "{question}").ok()?;
        self.questions.flush().ok()?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer).ok()?;
        answer.split_whitespace().map(|word| word.parse().ok()).collect()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // the process holds nothing that has to be saved
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
