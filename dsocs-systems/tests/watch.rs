//! `dsocs watch`: every save is run and shown, mistakes too, to browsers of this machine only; and a real
//! browser reloads the page.

#![cfg(unix)]

mod chromium;
mod program;

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use chromium::browser;
use program::dsocs;

/// The largest time to wait, however slow the machine is.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until `look` finds something.
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A pendulum with this documentation, by which texts differ.
fn swing(documentation: &str) -> String {
    format!(
        "//! {documentation}
        parameters {{ pull = samples(\"pull.csv\") }}
        coordinates(theta);
        lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos() + pull.at(t) * theta;
        run {{ start = ([pi / 4], [0]); step = 0.01; until = 1.0; }}"
    )
}

/// A running program that watches `swing.dsocs` in a folder.
struct Watching {
    folder: tempfile::TempDir,
    child: Child,
    address: SocketAddr,
}

impl Watching {
    fn begin() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("swing.dsocs"), swing("A pendulum.")).unwrap();
        fs::write(folder.path().join("pull.csv"), "t,pull\n0,0\n1,1\n2,0.5\n4,2\n").unwrap();
        let mut child = dsocs(folder.path(), &["watch", "swing.dsocs"])
            .stdout(Stdio::piped())
            .stderr(File::create(folder.path().join("stderr")).unwrap())
            .spawn()
            .unwrap();
        let mut first = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut first)
            .unwrap();
        let address = first.trim().strip_prefix("http://").unwrap().parse().unwrap();
        Self {
            folder,
            child,
            address,
        }
    }

    fn write(&self, file: &str, text: &str) {
        fs::write(self.folder.path().join(file), text).unwrap();
    }

    /// The output on the terminal.
    fn terminal_output(&self) -> String {
        fs::read_to_string(self.folder.path().join("stderr")).unwrap()
    }

    /// The answer to a request, head and all.
    fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        // a connection that is closed early is an answer, too
        let _ = stream.read_to_string(&mut answer);
        answer
    }

    fn get(&self, path: &str) -> String {
        self.ask(&format!("GET {path} HTTP/1.1\r\nhost: {}\r\n\r\n", self.address))
    }

    /// Waits for a page with these words.
    fn shows(&self, words: &[&str]) -> String {
        until(&format!("{words:?} in {}", self.terminal_output()), || {
            let page = self.get("/");
            words.iter().all(|word| page.contains(word)).then_some(page)
        })
    }

    /// Interrupts the program as Ctrl-C does.
    fn interrupt(&mut self) {
        let id = self.child.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-INT", &id])
                .status()
                .unwrap()
                .success()
        );
        let status = until("it ends", || self.child.try_wait().unwrap());
        assert!(status.success(), "{status}: {}", self.terminal_output());
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        // it may have ended already
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn every_save_is_run_and_shown() {
    let mut watching = Watching::begin();
    let page = watching.shows(&["A pendulum", "<svg"]);
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n") && page.contains("connect-src 'self'"));
    // a mistake is shown with its place above the last page, and printed on the terminal
    let wrong = swing("A mistake.").replace("theta.cos()", "phi.cos()");
    watching.write("swing.dsocs", &wrong);
    let page = watching.shows(&["no name `phi` is known here", "swing.dsocs:4:"]);
    assert!(
        page.contains("<svg") && page.contains("Below is the last page before this error"),
        "{page:.3000}"
    );
    assert!(
        watching
            .terminal_output()
            .contains("error: no name `phi` is known here"),
        "{}",
        watching.terminal_output()
    );
    watching.write("swing.dsocs", &swing("It is better."));
    let page = watching.shows(&["It is better"]);
    assert!(!page.contains("no name"));
    // a file that disappears and comes back under another name, then renamed, as editors do
    let path = |name: &str| watching.folder.path().join(name);
    fs::remove_file(path("swing.dsocs")).unwrap();
    watching.shows(&["cannot read swing.dsocs", "It is better"]);
    watching.write("swing.dsocs~", &swing("Renamed."));
    fs::rename(path("swing.dsocs~"), path("swing.dsocs")).unwrap();
    watching.shows(&["Renamed"]);
    // the samples are watched, too
    let number = watching.get("/number");
    assert_eq!(number, watching.get("/number"));
    watching.write("pull.csv", "t,pull\n0,0\n1,1\n2,0.5\n4,3\n");
    until("samples that change", || {
        (watching.get("/number") != number).then_some(())
    });
    fs::remove_file(path("pull.csv")).unwrap();
    watching.shows(&["cannot read pull.csv"]);
    watching.write("pull.csv", "t,pull\n0,0\n1,1\n2,0.5\n4,4\n");
    until("samples that come again", || {
        (!watching.get("/").contains("cannot read")).then_some(())
    });
    // a run that fails on the way shows the part before
    watching.write(
        "swing.dsocs",
        &swing("It fails.").replace("+ 9.81", "+ (0.5 - t).sqrt() * 9.81"),
    );
    watching.shows(&["It fails", "error: ", "Below is what was computed before"]);
    // two saves of the same length, the second while the first is read
    for round in 0..4 {
        watching.write("swing.dsocs", &swing(&format!("First {round}.")));
        std::thread::sleep(Duration::from_millis(30 * round));
        watching.write("swing.dsocs", &swing(&format!("Later {round}.")));
        watching.shows(&[&format!("Later {round}")]);
    }
    watching.interrupt();
}

#[test]
fn samples_that_are_missing_at_first_are_waited_for() {
    let mut watching = Watching::begin();
    fs::remove_file(watching.folder.path().join("pull.csv")).unwrap();
    watching.write("swing.dsocs", &swing("Without samples."));
    watching.shows(&["cannot read pull.csv"]);
    watching.write("pull.csv", "0,0\n1,1\n");
    watching.shows(&["Without samples", "<svg"]);
    watching.interrupt();
}

#[test]
fn other_machines_and_other_pages_are_told_nothing() {
    let watching = Watching::begin();
    let mut elsewhere = watching.address;
    assert!(elsewhere.ip().is_loopback());
    watching.shows(&["A pendulum"]);
    // on Linux all of 127.0.0.0/8 is this machine, and only 127.0.0.1 has a listener
    elsewhere.set_ip([127, 0, 0, 2].into());
    assert!(TcpStream::connect_timeout(&elsewhere, Duration::from_secs(1)).is_err());
    let port = watching.address.port();
    for host in [
        "evil.example",
        "127.0.0.1",
        "",
        "127.0.0.1:1",
        &format!("evil.example:{port}"),
    ] {
        let answer = watching.ask(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        assert!(
            answer.starts_with("HTTP/1.1 403 ") && !answer.contains("pendulum"),
            "{answer}"
        );
    }
    let answer = watching.ask("GET / HTTP/1.1\r\n\r\n");
    assert!(answer.starts_with("HTTP/1.1 403 "), "{answer}");
    let answer = watching.ask(&format!("GET / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n"));
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    for header in [
        "X-Frame-Options: DENY",
        "nosniff",
        "Cross-Origin-Resource-Policy: same-origin",
    ] {
        assert!(answer.contains(header), "{header}");
    }
    for path in ["/swing.dsocs", "/../swing.dsocs", "/told", "//", "/?", ""] {
        let answer = watching.get(path);
        assert!(answer.starts_with("HTTP/1.1 404 "), "{path}: {answer}");
    }
    let answer = watching.ask(&format!("POST / HTTP/1.1\r\nHost: {}\r\n\r\n", watching.address));
    assert!(answer.starts_with("HTTP/1.1 404 "), "{answer}");
    // a malformed request, and one that never ends
    for request in ["\r\n\r\n", "\u{0}\u{1}\r\n\r\n", &"x".repeat(100_000)] {
        let answer = watching.ask(request);
        assert!(!answer.contains("200 OK"), "{answer}");
    }
    // many silent connections delay the answer to others only briefly
    let silent: Vec<_> = (0..100)
        .map(|_| TcpStream::connect(watching.address).unwrap())
        .collect();
    watching.shows(&["A pendulum"]);
    drop(silent);
}

#[test]
fn what_is_no_text_file_is_refused() {
    let refused = |arguments: &[&str]| {
        let output = dsocs(Path::new("."), arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let stderr = refused(&["watch", "pendulum"]);
    assert!(
        stderr.contains("expected a text file, such as `swing.dsocs`, found `pendulum`"),
        "{stderr}"
    );
    assert!(refused(&["watch"]).contains("expected a text file"));
    let watching = Watching::begin();
    let port = watching.address.port().to_string();
    let stderr = refused(&["watch", "swing.dsocs", "--port", &port]);
    assert!(
        stderr.contains("cannot show a page at a port of this machine"),
        "{stderr}"
    );
}

/// A browser that is controlled through two pipes (Chrome's devtools protocol: messages that end with a zero
/// byte).
struct Driven {
    child: Child,
    to: File,
    from: BufReader<File>,
    last: u64,
}

impl Driven {
    fn begin(browser: &Path, folder: &Path) -> Self {
        let pipes = ["to", "from"].map(|name| folder.join(name));
        for pipe in &pipes {
            assert!(Command::new("mkfifo").arg(pipe).status().unwrap().success());
        }
        let child = Command::new("sh")
            .arg("-c")
            // the shell is replaced by the browser
            .arg("exec \"$0\" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run \
                  --disable-background-networking --remote-debugging-pipe --user-data-dir=\"$3\" 3<\"$1\" 4>\"$2\"")
            .arg(browser)
            .args(&pipes)
            .arg(folder.join("profile"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let to = File::options().write(true).open(&pipes[0]).unwrap();
        let from = BufReader::new(File::open(&pipes[1]).unwrap());
        Self {
            child,
            to,
            from,
            last: 0,
        }
    }

    /// Calls a method in a page, or in the browser itself, and returns the result.
    fn call(&mut self, session: Option<&str>, method: &str, parameters: &Value) -> Value {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if let Some(session) = session {
            message["sessionId"] = session.into();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut answer = Vec::new();
            self.from.read_until(0, &mut answer).unwrap();
            assert_eq!(answer.pop(), Some(0), "the browser has ended");
            let answer: Value = serde_json::from_slice(&answer).unwrap();
            if answer["id"] == self.last {
                // a page that reloads has no answer
                let error = answer["error"]["message"].as_str().unwrap_or_default();
                let reloads = error.contains("navigated") || error.contains("Cannot find context");
                assert!(answer["error"].is_null() || reloads, "{answer}");
                return answer["result"].clone();
            }
        }
    }
}

impl Drop for Driven {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_browser_reloads_the_page() {
    let Some(browser) = browser() else {
        eprintln!("SKIPPED: no Chromium on this machine, so no page was opened (`apt-get install chromium`)");
        return;
    };
    let watching = Watching::begin();
    watching.shows(&["A pendulum"]);
    let folder = tempfile::tempdir().unwrap();
    let mut driven = Driven::begin(&browser, folder.path());
    let url = format!("http://{}/", watching.address);
    let page = driven.call(None, "Target.createTarget", &json!({"url": url}));
    let session = driven.call(
        None,
        "Target.attachToTarget",
        &json!({"targetId": page["targetId"], "flatten": true}),
    );
    let session = session["sessionId"].as_str().unwrap().to_owned();
    let evaluate = |driven: &mut Driven, script: &str| {
        let asked = json!({"expression": script, "returnByValue": true});
        let found = driven.call(Some(&session), "Runtime.evaluate", &asked);
        found["result"]["value"].clone()
    };
    // the page reloads by itself
    let shows = |driven: &mut Driven, words: &[&str]| {
        until(&format!("{words:?}"), || {
            let text = evaluate(driven, "document.body ? document.body.innerText : ''");
            let text = text.as_str().unwrap_or_default();
            words.iter().all(|word| text.contains(word)).then_some(())
        });
    };
    let drawn = "[...document.querySelectorAll('svg.figure')].filter(figure => figure.getBoundingClientRect().height > 60).length";
    shows(&mut driven, &["A pendulum"]);
    let has_drawn = |driven: &mut Driven| {
        until("a figure", || {
            (evaluate(driven, drawn).as_u64() > Some(0)).then_some(())
        });
    };
    has_drawn(&mut driven);
    watching.write("swing.dsocs", &swing("An <b>edited</b> one."));
    shows(&mut driven, &["An <b>edited</b> one"]);
    watching.write(
        "swing.dsocs",
        &swing("A mistake.").replace("theta.cos()", "phi.cos()"),
    );
    shows(
        &mut driven,
        &[
            "no name `phi` is known here",
            "Below is the last page",
            "An <b>edited</b> one",
        ],
    );
    has_drawn(&mut driven);
    watching.write("swing.dsocs", &swing("Without a mistake."));
    shows(&mut driven, &["Without a mistake"]);
    // the slider still works, and the page requests nothing but its number
    let moved = "(() => { const slider = document.getElementById('time'); slider.value = slider.max; \
                 slider.dispatchEvent(new Event('input', { bubbles: true })); return slider.getAttribute('aria-valuetext'); })()";
    let time = evaluate(&mut driven, moved);
    assert!(
        time.as_str().is_some_and(|time| time.starts_with("t = 1")),
        "{time}"
    );
    let asked = "[...new Set(performance.getEntriesByType('resource').map(entry => entry.name))].join()";
    until("it asks", || {
        (evaluate(&mut driven, asked) == format!("{url}number")).then_some(())
    });
}
