//! The pages of the program in a real browser: no error, no request, every figure within the page, and a
//! slider that works.
//!
//! Skipped with a message where there is no Chromium (`apt-get install chromium` on Debian).

mod chromium;
mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use chromium::browser;

/// The largest size of a page, in bytes.
const MOST: u64 = 1_000_000;

/// The script that inspects pages. Each page is in a frame of a given width, whose document the script can
/// read.
const PROBE: &str = include_str!("browser.js");

/// The findings of the script for each page in a frame of its width, in pixels.
fn look(browser: &Path, pages: &[(&Path, u32)]) -> Vec<Value> {
    let folder = tempfile::tempdir().unwrap();
    let frames = pages.iter().map(|(page, width)| {
        let text = fs::read_to_string(page).unwrap();
        let quoted = text.replace('&', "&amp;").replace('"', "&quot;");
        format!("<iframe style=\"border:0;display:block;width:{width}px;height:3000px\" srcdoc=\"{quoted}\"></iframe>\n")
    });
    let frames: String = frames.collect();
    let harness = folder.path().join("harness.html");
    // the script comes first, so that it observes every frame from the beginning
    let html = format!(
        "<!DOCTYPE html><html><body style=\"margin:0\"><pre id=\"found\"></pre><script>{PROBE}</script>{frames}</body></html>"
    );
    fs::write(&harness, html).unwrap();
    let dom_file = fs::File::create(folder.path().join("dom")).unwrap();
    let mut child = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--hide-scrollbars",
        ])
        .args([
            "--no-first-run",
            "--disable-background-networking",
            "--virtual-time-budget=5000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("profile").display()
        ))
        .arg("--window-size=1300,3000")
        .arg(format!("file://{}", harness.display()))
        .stdout(dom_file)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("the browser does not answer");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let dom = fs::read_to_string(folder.path().join("dom")).unwrap();
    let found = dom
        .split_once("<pre id=\"found\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    let Some((found, _)) = found else {
        panic!("no answer: {dom:.400}")
    };
    let found = found
        .replace("&quot;", "\"")
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    serde_json::from_str(&found).unwrap_or_else(|error| panic!("{error}: {found:.400}"))
}

/// Runs the command with these arguments in this folder.
fn dsocs(folder: &Path, arguments: &[&str]) {
    let output = program::dsocs(folder, arguments).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    assert!(output.stdout.len() < 500, "rows were not asked for");
}

/// Asserts the properties that every page has at every width.
fn sound(found: &Value, page: &str, width: u32) {
    let entries = |key: &str| {
        found[key]
            .as_array()
            .unwrap_or_else(|| panic!("{page}, {width}: {found}"))
    };
    assert!(
        entries("errors").is_empty(),
        "{page}, {width}: {:?}",
        entries("errors")
    );
    assert!(
        entries("requests").is_empty(),
        "{page}, {width}: {:?}",
        entries("requests")
    );
    assert!(!entries("figures").is_empty(), "{page}, {width}");
    for figure in entries("figures") {
        let name = &figure["name"];
        let [left, right, height] = ["left", "right", "height"].map(|key| figure[key].as_f64().unwrap());
        assert!(
            left >= 0.0 && right <= f64::from(width) + 0.5 && right - left > 100.0 && height > 60.0,
            "{page}, {width}, {name}: {left} to {right}, {height} high"
        );
        assert!(
            name.as_str().is_some_and(|name| name.len() > 3),
            "{page}: a figure without a name"
        );
        assert!(figure["marks"].as_u64().unwrap() > 3, "{page}, {name} is empty");
    }
    assert!(
        found["wide"].as_f64().unwrap() <= f64::from(width),
        "{page} is wider than {width}: {}",
        found["wide"]
    );
    assert_eq!(found["unnamed"], 0, "{page}: what takes the keyboard has a name");
}

#[test]
fn pages_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    dsocs(
        folder,
        &[
            "run",
            "pendulum",
            "--until",
            "20",
            "--certify",
            "--report",
            "pendulum.html",
        ],
    );
    dsocs(
        folder,
        &["run", "particle", "--until", "50", "--report", "particle.html"],
    );
    dsocs(folder, &["run", "chain", "--report", "chain.html"]);
    dsocs(
        folder,
        &[
            "report",
            "particle",
            "turntable",
            "--cases",
            "4",
            "--out",
            "report.html",
        ],
    );
    let report = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(
        report.contains("turntable at some moments of its run")
            && !report.contains("particle at some moments"),
        "bodies in space are seen"
    );
    let pages = ["pendulum", "particle", "chain", "report"];
    for page in pages {
        let path = folder.join(format!("{page}.html"));
        let bytes = fs::metadata(&path).unwrap().len();
        assert!(bytes < MOST, "{page}: {bytes} bytes");
        // the parts of a page that need no script
        let text = fs::read_to_string(&path).unwrap();
        let (before, _) = text.split_once("<script").unwrap();
        assert!(
            before.contains("<svg") && before.contains("<td") && before.contains("machine"),
            "{page}"
        );
    }
    let Some(browser) = browser() else {
        eprintln!("SKIPPED: no Chromium on this machine, so no page was opened (`apt-get install chromium`)");
        return;
    };
    let paths = pages.map(|page| folder.join(format!("{page}.html")));
    let widths = [400, 1200];
    let asked: Vec<(&Path, u32)> = paths
        .iter()
        .flat_map(|path| widths.map(|width| (path.as_path(), width)))
        .collect();
    let answers = look(&browser, &asked);
    assert_eq!(answers.len(), asked.len());
    for ((path, width), found) in asked.into_iter().zip(&answers) {
        let page = path.file_name().unwrap().to_str().unwrap();
        sound(found, page, width);
        if page == "report.html" {
            assert_eq!(found["switched"], true, "the switch shows the other problem");
        } else {
            // whether the picture changes at the middle and at the end of the slider
            assert_eq!(found["moved"], serde_json::json!([true, true]), "{page}, {width}");
            let time = found["time"].as_str().unwrap();
            assert!(time.starts_with("t = ") && time != "t = 0 s", "{page}: {time}");
        }
        let tip = found["tip"].as_str();
        assert!(
            tip.is_some_and(|tip| tip.contains(char::is_numeric)),
            "{page}: {tip:?}"
        );
    }
}
