//! Sweeps: the content of the folder depends on the plan alone, whatever happens to the processes that
//! compute it.

// numbers are compared to the last bit
#![allow(clippy::float_cmp)]

mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};

use dsocs_systems::sweep::{Content, Options, Plan, Sweep, status};
use dsocs_systems::systems;

/// The command with these arguments, without the variables that a scheduler may have set.
fn dsocs(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program::dsocs(folder, arguments);
    for name in [
        "SLURM_ARRAY_TASK_ID",
        "SLURM_PROCID",
        "JOB_COMPLETION_INDEX",
        "PMI_RANK",
    ] {
        command.env_remove(name);
    }
    command
}

/// Standard output and standard error of a command that succeeds.
fn succeeds(command: &mut Command) -> [String; 2] {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().unwrap();
    let [stdout, stderr] = [stdout, stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(status.success(), "{stderr}");
    [stdout, stderr]
}

/// Exit status and standard error of a command that fails.
fn fails(command: &mut Command) -> (i32, String) {
    let output = command.output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!message.contains("panicked"), "{message}");
    (output.status.code().unwrap(), message)
}

/// A folder with a plan.
fn with(plan: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    let out = folder.path().join("sweep");
    (folder, out)
}

/// All tables of a sweep, by name; asserts that only parts have such names.
fn tables(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut tables = BTreeMap::new();
    for table in ["points", "nodes"] {
        for entry in fs::read_dir(out.join(table)).into_iter().flatten() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if !name.starts_with('.') {
                tables.insert(format!("{table}/{name}"), fs::read(path).unwrap());
            }
        }
    }
    tables
}

/// A plan with everything: random points, events, extremes, nodes.
const RICH: &str = r#"
system = "pendulum"
until = 5
part = 5
[sample]
kind = "latin-hypercube"
count = 64
seed = 7
[vary]
theta = { from = -1, to = 1 }
v_psi = { from = 0.1, to = 1, scale = "logarithmic" }
rho = [1, 2, 3]
[keep]
end = ["t", "theta", "lyapunov"]
extremes = ["lyapunov"]
nodes = { every = 10, columns = ["t", "theta"] }
[[event]]
name = "upright"
quantity = "theta"
[[event]]
name = "slow"
quantity = "v_psi"
direction = "falling"
ends = true
"#;

/// A plan whose runs take a while: forty parts.
const LONG: &str = r#"
system = "pendulum"
step = 0.01
until = 20
part = 2
[vary]
theta = { from = -1, to = 1, count = 80 }
[keep]
nodes = { every = 500 }
"#;

#[test]
fn shards_and_threads_do_not_change_a_byte() {
    let mut first = None;
    for shards in [1, 2, 3, 7] {
        for threads in ["1", "2"] {
            let (folder, out) = with(RICH);
            for shard in 1..=shards {
                let share = format!("{shard}/{shards}");
                let arguments = [
                    "sweep",
                    "plan.toml",
                    "--out",
                    "sweep",
                    "--threads",
                    threads,
                    "--shard",
                    &share,
                ];
                succeeds(&mut dsocs(folder.path(), &arguments));
                assert_eq!(status(&out).unwrap().missing.is_empty(), shard == shards);
            }
            let found = tables(&out);
            assert_eq!(found.len(), 2 * 13);
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{shards} shards, {threads} threads");
        }
    }
}

#[test]
fn a_point_is_the_run_that_the_command_line_makes() {
    let (folder, _) = with(
        r#"
        system = "train"
        until = 3
        [vary]
        "pull@1" = [0.5, 2]
        [keep]
        end = ["t", "x", "v_x"]
        "#,
    );
    // the last rows of `dsocs run`, whose numbers read back the same
    let last = |arguments: &[&str]| -> Vec<f64> {
        let [csv, _] = succeeds(&mut dsocs(folder.path(), arguments));
        csv.lines()
            .last()
            .unwrap()
            .split(',')
            .map(|field| field.parse().unwrap())
            .collect()
    };
    let numbers = |plan: &str, names: &[&str]| {
        let out = tempfile::tempdir().unwrap();
        let sweep = Sweep::new(&Plan::read(plan).unwrap(), &systems::all()).unwrap();
        sweep.run(out.path(), &Options::default()).unwrap();
        Content::open(out.path()).unwrap().numbers(names).unwrap()
    };
    for (method, option) in [
        ("", &[][..]),
        ("order = 4", &["--order", "4"]),
        ("tolerance = 1e-9", &["--tolerance", "1e-9"]),
    ] {
        let plan = format!(
            "system = \"pendulum\"\nuntil = 5\n{method}\n[set]\nrho = 3\n[vary]\ntheta = [0.25, 0.5]\nchi = [100, 50]\n[keep]\nend = [\"t\", \"theta\", \"v_psi\", \"energy\", \"lyapunov\"]"
        );
        let found = numbers(
            &plan,
            &["end_t", "end_theta", "end_v_psi", "end_energy", "end_lyapunov"],
        );
        let run = [
            "run", "pendulum", "--until", "5", "--set", "rho=3", "--set", "chi=50", "--q0", "0.25,0",
        ];
        let columns = ["--columns", "t,theta,v_psi,energy,lyapunov"];
        let expected = last(&[&run[..], &columns, option].concat());
        let found: Vec<f64> = found.iter().map(|column| column[1]).collect();
        assert_eq!(found, expected, "{method}");
    }
    // a held input
    fs::write(folder.path().join("held.csv"), "0,2\n1,5\n").unwrap();
    let plan = "system = \"pendulum\"\nuntil = 3\n[input]\nrho = [[0, 2]]\n[vary]\n\"rho@1\" = [3, 5]\n[keep]\nend = [\"theta\", \"dissipation\"]";
    let found = numbers(plan, &["end_theta", "end_dissipation"]);
    let run = [
        "run",
        "pendulum",
        "--until",
        "3",
        "--input",
        "rho=held.csv",
        "--columns",
        "theta",
    ];
    assert_eq!(found[0][1], last(&run)[0]);
    assert!(found[0][0] != found[0][1]);
}

#[test]
fn events_extremes_and_nodes_are_kept() {
    let (folder, out) = with(
        "system = \"planar-pendulum\"\nuntil = 10\n[start]\nq0 = [0.6, -0.8]\nv0 = [0, 0]\n[vary]\ngravity = [9.81, 1]\n[keep]\nend = [\"t\", \"x\"]\nextremes = [\"x\"]\nnodes = { every = 100 }\n\
         [[event]]\nname = \"down\"\nquantity = \"x\"\n[[event]]\nname = \"third\"\nquantity = \"t\"\nvalue = 3.005\nends = true",
    );
    succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "sweep"],
    ));
    let names = [
        "count_down",
        "first_down",
        "end_t",
        "least_x",
        "greatest_x",
        "end_x",
    ];
    let found = Content::open(&out).unwrap().numbers(&names).unwrap();
    // a quarter of the period of a swing of 0.6435 rad
    assert!((found[1][0] - 0.5149).abs() < 1e-3, "{found:?}");
    assert_eq!(found[0][0], 3.0);
    assert!((found[2][0] - 3.005).abs() < 1e-12);
    assert!(
        found[3][0] < -0.59 && found[4][0] <= 0.6 + 1e-12 && found[4][0] > 0.599,
        "{found:?}"
    );
    assert!(found[5][0].abs() < 0.6);
    let nodes = tables(&out)
        .into_keys()
        .filter(|name| name.starts_with("nodes/"))
        .count();
    assert_eq!(nodes, 2);
}

/// Points in lanes: their bytes do not depend on the points in the other lanes, their values agree with those
/// of single runs to rounding, and a failure is a row of the table.
#[test]
fn lanes_do_not_change_with_what_runs_beside() {
    let plan = |part: u64, lanes: &str| {
        format!(
            "system = \"pendulum\"\nstep = 0.05\nuntil = 8\npart = {part}\n{lanes}[vary]\nrho = [1, 2.5]\ntheta = {{ from = -1, to = 1, count = 7 }}\ni = [312.5, 0, 300]\n[keep]\nend = [\"t\", \"theta\", \"v_psi\", \"lyapunov\"]"
        )
    };
    let names = ["rho", "i", "end_t", "end_theta", "end_v_psi", "end_lyapunov"];
    let run = |plan: &str, threads: usize| {
        let out = tempfile::tempdir().unwrap();
        let sweep = Sweep::new(&Plan::read(plan).unwrap(), &systems::all()).unwrap();
        let options = Options {
            threads,
            ..Options::default()
        };
        let report = sweep.run(out.path(), &options).unwrap();
        let content = Content::open(out.path()).unwrap();
        (
            report.failed,
            content.numbers(&names).unwrap(),
            tables(out.path()),
        )
    };
    let mut first = None;
    for (part, threads) in [(42, 1), (5, 2), (1, 1), (17, 2)] {
        let (failed, numbers, _) = run(&plan(part, "lanes = true\n"), threads);
        assert_eq!(failed, 14);
        let bits: Vec<Vec<u64>> = numbers
            .iter()
            .map(|column| column.iter().map(|x| x.to_bits()).collect())
            .collect();
        let first = first.get_or_insert_with(|| bits.clone());
        assert!(*first == bits, "parts of {part}");
    }
    let (_, lanes, bytes) = run(&plan(5, "lanes = true\n"), 1);
    assert!(bytes == run(&plan(5, "lanes = true\n"), 2).2);
    let (_, alone, _) = run(&plan(5, ""), 1);
    for (lanes, alone) in lanes.iter().zip(&alone) {
        for (lane, alone) in lanes.iter().zip(alone) {
            assert_eq!(lane.is_nan(), alone.is_nan());
            assert!(
                lane.is_nan() || (lane - alone).abs() < 1e-6 * (1.0 + alone.abs()),
                "{lane} {alone}"
            );
        }
    }
    for (plan, expected) in [
        (
            "system = \"pendulum\"\nlanes = true\norder = 4\n[vary]\nrho = [1, 2]",
            "order 2",
        ),
        (
            "system = \"pendulum\"\nlanes = true\n[vary]\n\"rho@1\" = [1, 2]",
            "inputs",
        ),
        (
            "system = \"train\"\nlanes = true\n[vary]\nmass = [1, 2]",
            "Entry::in_lanes",
        ),
    ] {
        let refused = Plan::read(plan).and_then(|plan| Sweep::new(&plan, &systems::all()).map(drop));
        let refused = refused.unwrap_err().to_string();
        assert!(
            refused.contains("lanes") && refused.contains(expected),
            "{refused}"
        );
    }
}

#[test]
fn a_run_that_fails_is_a_row() {
    let (folder, out) = with(
        "system = \"particle\"\nuntil = 1\n[start]\nv0 = [0, 0]\n[vary]\nv_x = [0, 0.5]\n[keep]\nend = [\"x\"]",
    );
    let [_, stderr] = succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "sweep"],
    ));
    assert!(stderr.contains("2 points of 2, 1 failed"), "{stderr}");
    let status = status(&out).unwrap();
    assert_eq!(
        status.failed.into_iter().collect::<Vec<_>>(),
        [("no-acceleration".to_owned(), 1)]
    );
    let theta = Content::open(&out).unwrap().numbers(&["end_x"]).unwrap();
    assert!(theta[0][0].is_nan() && theta[0][1].is_finite());
    let [stdout, _] = succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "--status", "--out", "sweep"],
    ));
    assert_eq!(
        stdout,
        "2 points in 2 parts\nmissing: 0\nfailed: 1 point (no-acceleration)\n"
    );
}

#[test]
fn names_that_there_are_not_are_refused_before_anything_begins() {
    for (plan, expected) in [
        (
            "system = \"pendulun\"\n[vary]\ntheta = [1]",
            "did you mean `pendulum`?",
        ),
        ("[vary]\ntheta = [1]", "system: which one?"),
        (
            "system = \"pendulum\"\n[vary]\ntheto = [1]",
            "vary: there is no start or parameter `theto` (did you mean `theta`?)",
        ),
        (
            "system = \"pendulum\"\n[vary]\nv_ps = [1]",
            "did you mean `v_psi`?",
        ),
        (
            "system = \"pendulum\"\n[set]\nrhoo = 1\n[vary]\ntheta = [1]",
            "set.rhoo: there is no parameter `rhoo` (did you mean `rho`?)",
        ),
        (
            "system = \"pendulum\"\n[vary]\n\"rhoo@1\" = [1]",
            "did you mean `rho`?",
        ),
        (
            "system = \"pendulum\"\n[vary]\ntheta = [1]\n[keep]\nend = [\"lyapunow\"]",
            "keep.end: there is no column `lyapunow` (did you mean `lyapunov`?)",
        ),
        (
            "system = \"pendulum\"\n[vary]\ntheta = [1]\n[[event]]\nquantity = \"lyapunow\"",
            "did you mean `lyapunov`?",
        ),
        (
            "system = \"pendulum\"\n[start]\nq0 = [1]\n[vary]\ntheta = [1]",
            "start.q0: 1 numbers, but there are 2 coordinates: theta, psi",
        ),
        (
            "system = \"pendulum\"\nuntil = -1\n[vary]\ntheta = [1]",
            "until: the end lies behind the start",
        ),
    ] {
        let (folder, out) = with(plan);
        let (status, message) = fails(&mut dsocs(
            folder.path(),
            &["sweep", "plan.toml", "--out", "sweep"],
        ));
        assert!(status == 2 && message.contains(expected), "{plan}: {message}");
        assert!(!out.exists());
    }
}

#[test]
fn another_plan_is_refused_in_the_same_folder() {
    let (folder, out) = with("system = \"particle\"\nuntil = 1\n[vary]\nx = [1, 2]");
    let sweep = ["sweep", "plan.toml", "--out", "sweep"];
    let (status, message) = fails(&mut dsocs(
        folder.path(),
        &["sweep", "--status", "--out", "sweep"],
    ));
    assert!(status == 2 && message.contains("holds no sweep"), "{message}");
    succeeds(&mut dsocs(folder.path(), &sweep));
    let before = tables(&out);
    fs::write(
        folder.path().join("plan.toml"),
        "system = \"particle\"\nuntil = 2\n[vary]\nx = [1, 2]",
    )
    .unwrap();
    let (status, message) = fails(&mut dsocs(folder.path(), &sweep));
    assert!(
        status == 2 && message.contains("plan.until is 1.0 there and 2.0 here"),
        "{message}"
    );
    // the same plan, in another notation
    fs::write(
        folder.path().join("plan.toml"),
        "until = \"2/2\" # s\nsystem = \"particle\"\n[vary]\nx = [1.0, 2]",
    )
    .unwrap();
    let [_, stderr] = succeeds(&mut dsocs(folder.path(), &sweep));
    assert!(stderr.contains("0 points of 2"), "{stderr}");
    assert!(before == tables(&out));
}

#[test]
fn a_scheduler_tells_its_tasks() {
    let (folder, out) = with(RICH);
    let sweep = ["sweep", "plan.toml", "--out", "sweep"];
    for (task, last) in [("4", false), ("7", false), ("5", false), ("6", true)] {
        let mut command = dsocs(folder.path(), &sweep);
        command.env("SLURM_ARRAY_TASK_ID", task);
        command
            .env("SLURM_ARRAY_TASK_MIN", "4")
            .env("SLURM_ARRAY_TASK_MAX", "7");
        let [_, stderr] = succeeds(&mut command);
        assert!(stderr.contains("/4, by SLURM_ARRAY_TASK_ID"), "{stderr}");
        assert_eq!(status(&out).unwrap().missing.is_empty(), last);
    }
    let (status, stderr) = fails(dsocs(folder.path(), &sweep).env("JOB_COMPLETION_INDEX", "0"));
    assert!(status == 2 && stderr.contains("--shards"), "{stderr}");
}

/// The existing parts, with the times at which they were written.
fn written(out: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let mut written = BTreeMap::new();
    for entry in fs::read_dir(out.join("points")).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "parquet") {
            let time = fs::metadata(&path).unwrap().modified().unwrap();
            written.insert(path, time);
        }
    }
    written
}

#[test]
fn twenty_kills_change_nothing() {
    let (whole, reference) = with(LONG);
    let sweep = ["sweep", "plan.toml", "--out", "sweep", "--threads", "2"];
    let begun = std::time::Instant::now();
    succeeds(&mut dsocs(whole.path(), &sweep));
    // killed at intervals such that it takes about twenty processes
    let all = begun.elapsed();
    let (folder, out) = with(LONG);
    let (mut kills, mut chance) = (0, 0x2545_F491_4F6C_DD1D_u64);
    while kills < 20 {
        let before = written(&out);
        let mut child = dsocs(folder.path(), &sweep)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        chance ^= chance << 13;
        chance ^= chance >> 7;
        chance ^= chance << 17;
        thread::sleep(all.mul_f64((chance % 1000) as f64 / 1000.0 * 0.15));
        // SIGKILL
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        for (path, time) in before {
            assert_eq!(
                fs::metadata(&path).unwrap().modified().unwrap(),
                time,
                "{} is written twice",
                path.display()
            );
        }
    }
    let before = written(&out);
    assert!(!before.is_empty());
    succeeds(&mut dsocs(folder.path(), &sweep));
    let after = written(&out);
    assert!(before.iter().all(|(path, time)| after[path] == *time));
    assert!(tables(&reference) == tables(&out));
    let left: Vec<_> = fs::read_dir(out.join("points"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 40, "temporary files are gone: {left:?}");
}

#[test]
fn two_processes_on_one_shard_write_the_same() {
    let (folder, out) = with(LONG);
    let sweep = ["sweep", "plan.toml", "--out", "sweep", "--threads", "1"];
    let start = || {
        dsocs(folder.path(), &sweep)
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    for mut child in [start(), start()] {
        assert!(child.wait().unwrap().success());
    }
    let (alone, reference) = with(LONG);
    succeeds(&mut dsocs(alone.path(), &sweep));
    assert!(tables(&reference) == tables(&out));
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_finished() {
    let (folder, out) = with(&LONG.replace("until = 20", "until = 2000"));
    let mut child = dsocs(folder.path(), &["sweep", "plan.toml", "--out", "sweep"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !out.join("points").exists() {
        thread::sleep(Duration::from_millis(10));
    }
    thread::sleep(Duration::from_millis(200));
    assert!(
        Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("the same command goes on from there"), "{stderr}");
    assert!(
        tables(&out).len().is_multiple_of(2),
        "a part is there in both tables"
    );
    child = dsocs(folder.path(), &["sweep", "--status", "--out", "sweep"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

/// A small disk of its own, unmounted at the end; none where mounting is not allowed.
struct Disk(PathBuf);

impl Disk {
    fn new(place: &Path, size: &str) -> Option<Self> {
        fs::create_dir_all(place).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"])
            .arg(place)
            .stderr(Stdio::null())
            .status();
        mounted
            .is_ok_and(|status| status.success())
            .then(|| Self(place.to_owned()))
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_is_told_and_leaves_no_half_part() {
    let (folder, out) = with(LONG);
    let Some(disk) = Disk::new(&out, "128k") else {
        eprintln!("skipped: only root can make a small disk (tmpfs)");
        return;
    };
    let sweep = ["sweep", "plan.toml", "--out", "sweep", "--threads", "2"];
    let (status_of, stderr) = fails(&mut dsocs(folder.path(), &sweep));
    assert_eq!(status_of, 1);
    assert!(
        stderr.contains("No space left on device") && stderr.contains("the same command goes on"),
        "{stderr}"
    );
    let (alone, reference) = with(LONG);
    succeeds(&mut dsocs(alone.path(), &sweep));
    let (all, some) = (tables(&reference), tables(&out));
    assert!(!some.is_empty() && some.len() < all.len());
    assert!(
        some.iter().all(|(name, bytes)| all[name] == *bytes),
        "what is there is whole"
    );
    let larger = Command::new("mount")
        .args(["-o", "remount,size=16m"])
        .arg(&disk.0)
        .status();
    assert!(larger.unwrap().success());
    succeeds(&mut dsocs(folder.path(), &sweep));
    assert!(all == tables(&out));
}

#[test]
fn python_reads_the_folder_in_one_line() {
    let (folder, _) = with(RICH);
    succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "sweep"],
    ));
    for (module, line) in [
        (
            "pyarrow",
            "import pyarrow.parquet as pq; t = pq.read_table('sweep/points'); print(t.num_rows, t['ended_by'].null_count, round(sum(t['theta'].to_pylist()), 9))",
        ),
        (
            "polars",
            "import polars as pl; t = pl.read_parquet('sweep/points/*.parquet'); print(t.height, t['ended_by'].null_count(), round(t['theta'].sum(), 9))",
        ),
        (
            "duckdb",
            "import duckdb; print(*duckdb.sql(\"select count(*), sum(cast(ended_by is null as int)), round(sum(theta), 9) from 'sweep/points/*.parquet'\").fetchall()[0])",
        ),
    ] {
        let python = |text: &str| {
            Command::new("python3")
                .args(["-c", text])
                .current_dir(folder.path())
                .output()
        };
        if !python(&format!("import {module}")).is_ok_and(|output| output.status.success()) {
            eprintln!("skipped: Python has no {module}");
            continue;
        }
        let output = python(line).unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        let theta = Content::open(&folder.path().join("sweep"))
            .unwrap()
            .numbers(&["theta"])
            .unwrap();
        let sum: f64 = theta[0].iter().sum();
        let fields: Vec<&str> = stdout.split_whitespace().collect();
        assert_eq!(
            fields[..2],
            ["64", "0"],
            "{module}: {stdout}{}",
            String::from_utf8_lossy(&output.stderr)
        );
        assert!(
            (fields[2].parse::<f64>().unwrap() - sum).abs() < 1e-8,
            "{module}: {stdout}, {sum}"
        );
    }
}

#[test]
fn a_sweep_is_drawn() {
    let (folder, _) = with(
        "system = \"pendulum\"\nuntil = 5\n[vary]\ntheta = { from = -1, to = 1, count = 5 }\nv_psi = [0.1, 0.2, 0.5]\nrho = { from = 1, to = 100, count = 3, scale = \"logarithmic\" }\n[keep]\nend = [\"lyapunov\"]",
    );
    succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "sweep"],
    ));
    let drawn = |arguments: &[&str]| {
        let [_, stderr] = succeeds(&mut dsocs(
            folder.path(),
            &[&["plot", "sweep", "--out", "x.svg"], arguments].concat(),
        ));
        (fs::read_to_string(folder.path().join("x.svg")).unwrap(), stderr)
    };
    let (map, stderr) = drawn(&["--log"]);
    assert!(stderr.contains("rho = 10"), "{stderr}");
    assert!(
        map.contains("data:image/png;base64,") && map.contains("lyapunov at the end [J]"),
        "{map}"
    );
    assert!(map.contains(">θ [rad]<"), "{map}");
    let (curves, _) = drawn(&["--x", "rho", "--y", "none", "--at", "v_psi=0.19"]);
    assert!(
        !curves.contains("<image") && curves.matches("<circle").count() == 3,
        "{curves}"
    );
    let (status, stderr) = fails(&mut dsocs(
        folder.path(),
        &["plot", "sweep", "--of", "end_lyapunow"],
    ));
    assert!(
        status == 2 && stderr.contains("did you mean `end_lyapunov`?"),
        "{stderr}"
    );
    let (status, stderr) = fails(&mut dsocs(folder.path(), &["plot", "sweep", "--x", "thet"]));
    assert!(
        status == 2 && stderr.contains("did you mean `theta`?"),
        "{stderr}"
    );
}

#[test]
#[ignore = "installs SLURM (Debian, as root) and takes a minute"]
fn the_recipe_for_slurm_runs() {
    let recipes = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes");
    let has = |module: &str| {
        let python = Command::new("python3")
            .args(["-c", &format!("import {module}")])
            .output();
        python.is_ok_and(|output| output.status.success())
    };
    let mut command = Command::new(recipes.join("try-slurm.sh"));
    if has("distributed") && has("dask_jobqueue") {
        command.arg("dask");
    } else {
        eprintln!("skipped: Dask's recipe, since Python has no distributed and dask_jobqueue");
    }
    let done = command.env("DSOCS", env!("CARGO_BIN_EXE_dsocs")).status();
    assert!(done.unwrap().success());
}

/// A pendulum in a text file, with a second run.
const SWING: &str = "//! A pendulum.
parameters {
    /// The length of the rod <b>bold</b> [m<&>]
    length = 1.0,
}
coordinates(
    /// The angle from below [rad]
    theta
);
lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
run { start = ([pi / 4], [0]); step = 0.01; until = 1.0; }
run far { start = ([3], [0]); step = 0.01; until = 0.5; }
";

#[test]
fn a_text_file_is_swept_and_carried_in_every_table() {
    let plan = "system = \"swing.dsocs\"\npart = 2\n[vary]\nlength = { from = 1, to = 2, count = 6 }\n[keep]\nnodes = { every = 50 }";
    let (folder, out) = with(plan);
    fs::write(folder.path().join("swing.dsocs"), SWING).unwrap();
    let sweep = ["sweep", "plan.toml", "--out", "sweep"];
    // one task with the text file, the others without it
    succeeds(&mut dsocs(
        folder.path(),
        &[&sweep[..], &["--shard", "1/3"]].concat(),
    ));
    fs::remove_file(folder.path().join("swing.dsocs")).unwrap();
    let [_, stderr] = succeeds(&mut dsocs(
        folder.path(),
        &[&sweep[..], &["--shard", "2/3"]].concat(),
    ));
    assert!(
        stderr.contains("there is no swing.dsocs; its text in sweep is taken"),
        "{stderr}"
    );
    succeeds(&mut dsocs(folder.path(), &sweep));
    let all = tables(&out);
    assert_eq!(all.len(), 6);
    // all parts in one process, with the text file
    let (whole, elsewhere) = with(plan);
    fs::write(whole.path().join("swing.dsocs"), SWING).unwrap();
    let [_, stderr] = succeeds(&mut dsocs(whole.path(), &sweep));
    assert!(!stderr.contains("is taken"), "{stderr}");
    assert!(all == tables(&elsewhere));
    // the text of the system is in every table and in the folder
    let text = dsocs_systems::sweep::text(&out).unwrap();
    for table in all.keys() {
        assert_eq!(
            dsocs_systems::sweep::text(&out.join(table)).unwrap(),
            text,
            "{table}"
        );
        let [printed, _] = succeeds(&mut dsocs(&out, &["text", table]));
        assert_eq!(printed, text);
    }
    fs::write(folder.path().join("swing.dsocs"), &text).unwrap();
    let [last, _] = succeeds(&mut dsocs(
        folder.path(),
        &["run", "swing.dsocs", "--columns", "theta", "--set", "length=2"],
    ));
    let end = Content::open(&out).unwrap().numbers(&["end_theta"]).unwrap();
    assert_eq!(end[0][5], last.lines().last().unwrap().parse::<f64>().unwrap());
    // in a figure the text is escaped
    succeeds(&mut dsocs(
        folder.path(),
        &["plot", "sweep", "--out", "sweep.svg"],
    ));
    let figure = fs::read_to_string(folder.path().join("sweep.svg")).unwrap();
    assert!(
        figure.contains("[m&lt;&amp;&gt;]") && !figure.contains("<b>") && !figure.contains("[m<"),
        "{figure:.3000}"
    );
    // a changed text is another sweep
    fs::write(folder.path().join("swing.dsocs"), SWING.replace("9.81", "9.8")).unwrap();
    let (_, stderr) = fails(&mut dsocs(folder.path(), &sweep));
    assert!(
        stderr.contains("holds another sweep: line ")
            && stderr.contains(" of text is `")
            && stderr.len() < 600,
        "{stderr}"
    );
    // a named run, and a mistake in the text
    fs::write(folder.path().join("swing.dsocs"), SWING).unwrap();
    fs::write(
        folder.path().join("far.toml"),
        plan.replace("swing.dsocs", "swing.dsocs:far"),
    )
    .unwrap();
    succeeds(&mut dsocs(folder.path(), &["sweep", "far.toml", "--out", "far"]));
    let far = Content::open(&folder.path().join("far")).unwrap();
    assert_eq!(far.numbers(&["end_t"]).unwrap()[0], [0.5; 6]);
    fs::write(
        folder.path().join("swing.dsocs"),
        SWING.replace("theta.cos", "phi.cos"),
    )
    .unwrap();
    let (code, stderr) = fails(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "other"],
    ));
    assert!(
        code == 2 && stderr.contains("no name `phi`") && !folder.path().join("other").exists(),
        "{stderr}"
    );
}

#[test]
fn samples_of_a_swept_text_are_part_of_the_sweep() {
    let (folder, _) = with("system = \"pull.dsocs\"\n[vary]\nx = [0, 1, 2]");
    let text = "parameters { pull = samples(\"pull.csv\") } coordinates(x); lagrangian = dot(x).powi(2) / 2 + pull.at(t) * x; \
                run { start = ([0], [0]); until = 1.0; }";
    fs::write(folder.path().join("pull.dsocs"), text).unwrap();
    fs::write(folder.path().join("pull.csv"), "0,0\n1,1\n").unwrap();
    let sweep = ["sweep", "plan.toml", "--out", "sweep"];
    succeeds(&mut dsocs(folder.path(), &sweep));
    succeeds(&mut dsocs(folder.path(), &sweep));
    fs::write(folder.path().join("pull.csv"), "0,0\n1,2\n").unwrap();
    let (_, stderr) = fails(&mut dsocs(folder.path(), &sweep));
    assert!(stderr.contains("holds another sweep: samples"), "{stderr}");
    // a text from a sweep may not read files
    fs::remove_file(folder.path().join("pull.dsocs")).unwrap();
    let (code, stderr) = fails(&mut dsocs(folder.path(), &sweep));
    assert!(
        code == 2 && stderr.contains("the text names the file `pull.csv`"),
        "{stderr}"
    );
}

#[test]
fn a_foreign_text_is_text() {
    let (folder, out) = with("system = \"swing.dsocs\"\n[vary]\ntheta = [0, 1]");
    fs::write(folder.path().join("swing.dsocs"), SWING).unwrap();
    succeeds(&mut dsocs(
        folder.path(),
        &["sweep", "plan.toml", "--out", "sweep"],
    ));
    fs::remove_file(folder.path().join("swing.dsocs")).unwrap();
    let path = out.join("manifest.json");
    let manifest: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    for (foreign, expected) in [
        // control characters, and expressions that are no numbers in a declaration
        ("//! \u{1b}[31mred\ncoordinates(x); lagrangian = x;", "U+001B"),
        ("coordinates(x); lagrangian = std::process::exit(3);", "error: "),
        (
            "parameters { w = samples(\"/etc/passwd\") } coordinates(x); lagrangian = w.at(x);",
            "names the file `/etc/passwd`",
        ),
        (
            "coordinates(x); lagrangian = sum(0..1000000000, |i| x);",
            "more than 200000 terms",
        ),
    ] {
        let mut whole = manifest.clone();
        whole["text"] = foreign.into();
        fs::write(&path, whole.to_string()).unwrap();
        let (code, stderr) = fails(&mut dsocs(
            folder.path(),
            &["sweep", "plan.toml", "--out", "sweep"],
        ));
        assert!(
            code == 2 && stderr.contains(expected) && !stderr.contains('\u{1b}'),
            "{stderr}"
        );
        let [printed, _] = succeeds(&mut dsocs(folder.path(), &["text", "sweep"]));
        assert!(!printed.contains('\u{1b}'));
    }
    let (code, stderr) = fails(&mut dsocs(folder.path(), &["text", "plan.toml"]));
    assert!(code == 2 && stderr.contains("no system"), "{stderr}");
    fs::write(folder.path().join("no.parquet"), "PAR1").unwrap();
    let (_, stderr) = fails(&mut dsocs(folder.path(), &["text", "no.parquet"]));
    assert!(stderr.contains("cannot read no.parquet"), "{stderr}");
}

/// The lanes of a text give the bits of the compiled system's lanes.
#[test]
fn a_text_is_swept_in_lanes_as_the_compiled_system_is() {
    let plan = |system: &str| {
        format!(
            "system = \"{system}\"\nlanes = true\nstep = 0.05\nuntil = 4\n[start]\nq0 = [0.5, 0]\nv0 = [0, 0.5]\n[vary]\nrho = [1, 2.5]\ntheta = {{ from = -1, to = 1, count = 7 }}\n\
             [keep]\nend = [\"t\", \"theta\", \"v_psi\", \"lyapunov\"]"
        )
    };
    let names = ["rho", "end_t", "end_theta", "end_v_psi", "end_lyapunov"];
    let numbers = |system: &str| {
        let (folder, out) = with(&plan(system));
        let entries = systems::all();
        let pendulum = entries.iter().find(|entry| entry.name() == "pendulum").unwrap();
        fs::write(folder.path().join("wheel.dsocs"), pendulum.text().unwrap()).unwrap();
        succeeds(&mut dsocs(
            folder.path(),
            &["sweep", "plan.toml", "--out", "sweep"],
        ));
        let found = Content::open(&out).unwrap().numbers(&names).unwrap();
        let bits = |column: &Vec<f64>| column.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        found.iter().map(bits).collect::<Vec<_>>()
    };
    let compiled = numbers("pendulum");
    assert_eq!(compiled[0].len(), 14);
    assert_eq!(compiled, numbers("wheel.dsocs"));
}
