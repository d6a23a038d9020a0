//! `watch`: runs a text file at every save, and shows the page in a browser that reloads it.

use std::fs;
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;

use super::page::{CONNECTS, POLICY, Page};
use super::run::{RunArguments, run};
use super::{CliError, Program, interrupt};

/// What `watch` takes.
#[derive(Args, Debug)]
pub struct WatchArguments {
    /// What is run
    #[command(flatten)]
    run: RunArguments,
    /// The port of this machine at which the page is shown [default: one that is free]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
}

/// So often the files are looked at, and the page asks whether there is a new one.
const EVERY: Duration = Duration::from_millis(100);

/// A request has so many bytes at most.
const LONGEST_REQUEST: u64 = 8192;

/// The page, and how often it has changed.
#[derive(Default)]
struct Shown {
    version: u64,
    html: String,
}

/// What a file was when it was last looked at: when it was changed, and its length.
type Seen = Option<(SystemTime, u64)>;

/// Runs a text file at every save.
pub fn watch(arguments: &WatchArguments, program: &mut Program) -> Result<(), CliError> {
    let file = arguments.run.system().unwrap_or_default().to_owned();
    let Some(path) = super::file::path(&file) else {
        return Err(CliError::NoFile(file));
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, arguments.port)).map_err(CliError::Port)?;
    let address = listener.local_addr().map_err(CliError::Port)?;
    let shown = Arc::new(Mutex::new(Shown::default()));
    let folder = tempfile::tempdir().map_err(CliError::Port)?;
    let page = folder.path().join("page.html");
    let run_arguments = arguments.run.clone().with_page(page.clone());
    let interrupted = interrupt::watch();
    let entries = program.entries.len();
    let mut seen = Vec::new();
    while !interrupted.load(Ordering::Relaxed) {
        let now = look(
            &path,
            program
                .entries
                .get(entries)
                .map_or_else(Vec::new, |entry| entry.files().map(ToOwned::to_owned).collect()),
        );
        if now == seen {
            thread::sleep(EVERY);
            continue;
        }
        let begun = Instant::now();
        program.forget_beyond(entries);
        let _ = fs::remove_file(&page);
        let result = run(&run_arguments, program);
        let html = match (&result, fs::read_to_string(&page)) {
            (Ok(()), Ok(html)) => html,
            (Err(error), _) => wrong(&file, &error.to_string()),
            (_, Err(error)) => wrong(&file, &error.to_string()),
        };
        let first = publish(&shown, &html);
        match result {
            Ok(()) => eprintln!("{file}: {:.2} s", begun.elapsed().as_secs_f64()),
            Err(error) => eprintln!("error: {error}"),
        }
        if first {
            serve(listener.try_clone().map_err(CliError::Port)?, address, &shown);
            println!("http://{address}");
            let _ = io::stdout().flush();
        }
        // the files that it names are known now
        seen = look(
            &path,
            program
                .entries
                .get(entries)
                .map_or_else(Vec::new, |entry| entry.files().map(ToOwned::to_owned).collect()),
        );
        seen[0] = now.first().copied().flatten();
    }
    Ok(())
}

/// What the text and the files that it names are now.
fn look(path: &Path, files: Vec<String>) -> Vec<Seen> {
    let beside = path.parent().unwrap_or(Path::new(""));
    let files = files.into_iter().map(|file| beside.join(file));
    let all = core::iter::once(path.to_owned()).chain(files);
    all.map(|file: PathBuf| {
        let metadata = fs::metadata(file).ok()?;
        Some((metadata.modified().ok()?, metadata.len()))
    })
    .collect()
}

/// The page of an error.
fn wrong(file: &str, error: &str) -> String {
    let mut page = Page::new(
        file,
        "The text has a mistake; the page comes again when it is saved without it.",
    );
    page.preformatted(&format!("error: {error}"));
    page.finish()
}

/// Shows a page. Returns whether it is the first.
fn publish(shown: &Mutex<Shown>, html: &str) -> bool {
    let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
    shown.version += 1;
    let version = shown.version;
    // asks, and loads what is new
    let script = format!(
        "<script>setInterval(async () => {{ try {{ const answer = await fetch('/version'); \
         if (answer.ok && await answer.text() !== '{version}') location.reload(); }} catch {{}} }}, {});</script>\n</body>",
        EVERY.as_millis()
    );
    shown.html = html
        .replacen(POLICY, &format!("{POLICY}{CONNECTS}"), 1)
        .replacen("</body>", &script, 1);
    version == 1
}

/// Answers requests on a thread.
fn serve(listener: TcpListener, address: SocketAddr, shown: &Arc<Mutex<Shown>>) {
    let shown = Arc::clone(shown);
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let shown = Arc::clone(&shown);
            thread::spawn(move || {
                // whoever asked has gone
                let _ = answer(&stream, address, &shown);
            });
        }
    });
}

/// Answers one request.
fn answer(stream: &TcpStream, address: SocketAddr, shown: &Mutex<Shown>) -> io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(5)))?;
    stream.set_write_timeout(Some(Duration::from_secs(5)))?;
    let mut lines = BufReader::new(stream.take(LONGEST_REQUEST)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    let mut host = None;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            host = Some(value.trim().to_owned());
        }
    }
    // a page of another origin that was led here under its own name reads nothing
    let own = [address.to_string(), format!("localhost:{}", address.port())];
    let is_own = host.is_some_and(|host| own.contains(&host));
    let shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
    let mut words = request.split(' ');
    let (status, kind, body) = match (words.next(), words.next(), is_own) {
        (_, _, false) => (
            "403 Forbidden",
            "text/plain",
            "expected the address that dsocs watch prints".to_owned(),
        ),
        (Some("GET"), Some("/"), true) => ("200 OK", "text/html; charset=utf-8", shown.html.clone()),
        (Some("GET"), Some("/version"), true) => ("200 OK", "text/plain", shown.version.to_string()),
        _ => ("404 Not Found", "text/plain", "there is one page, /".to_owned()),
    };
    drop(shown);
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{body}",
        body.len()
    )
}
