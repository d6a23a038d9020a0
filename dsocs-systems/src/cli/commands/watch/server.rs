//! The page of `watch`, shown to browsers of this machine.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use crate::cli::page;

/// The interval at which a page asks whether there is a new one.
const RELOAD_INTERVAL: Duration = Duration::from_millis(100);

/// The largest length of a request, in bytes.
const LONGEST_REQUEST: usize = 8192;

/// The time that a request may take to arrive.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);

/// The largest number of requests answered at once; more are turned away. A browser opens six.
const MOST_REQUESTS: usize = 32;

/// Shows one page at a port of the loopback interface. Other machines cannot reach it; other users of this
/// machine can.
pub struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
}

/// The state that the answering threads share.
struct Shared {
    /// The page, and its number.
    page: Mutex<(u128, Arc<str>)>,
    /// The number of requests being answered.
    busy: AtomicUsize,
    /// The names by which a browser may call this server.
    hosts: [String; 2],
}

impl Server {
    /// Begins to show a page at a port; 0 chooses a free one.
    ///
    /// # Errors
    ///
    /// If the port is taken.
    pub fn start(port: u16, html: &str) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        // the first number differs from those of an earlier program at this port
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let first = since.unwrap_or_default().as_nanos();
        let shared = Arc::new(Shared {
            page: Mutex::new((first, with_reload_script(html, first))),
            busy: AtomicUsize::new(0),
            hosts: [address.to_string(), format!("localhost:{}", address.port())],
        });
        let answering = Arc::clone(&shared);
        thread::Builder::new().spawn(move || {
            for stream in listener.incoming().flatten() {
                answering.busy.fetch_add(1, Ordering::Relaxed);
                // counts down when it is dropped, whether the thread begins or not
                let busy = OpenRequest(Arc::clone(&answering));
                if answering.busy.load(Ordering::Relaxed) <= MOST_REQUESTS {
                    // if the thread cannot be started, the request is dropped
                    let _ = thread::Builder::new().spawn(move || answer(&stream, &busy.0));
                }
            }
        })?;
        Ok(Self { address, shared })
    }

    /// The address of the page.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Shows another page; open pages reload.
    pub fn show(&self, html: &str) {
        let mut page = self.shared.page.lock().unwrap_or_else(PoisonError::into_inner);
        let number = page.0 + 1;
        *page = (number, with_reload_script(html, number));
    }
}

/// A request that is being answered.
struct OpenRequest(Arc<Shared>);

impl Drop for OpenRequest {
    fn drop(&mut self) {
        self.0.busy.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A page with a script that reloads it as soon as the server's number differs.
fn with_reload_script(html: &str, number: u128) -> Arc<str> {
    let script = format!(
        "setInterval(async () => {{ try {{ const answer = await fetch('/number'); \
         if (answer.ok && await answer.text() !== '{number}') location.reload(); }} catch {{}} }}, {});",
        RELOAD_INTERVAL.as_millis()
    );
    page::with_script(html, &script).into()
}

/// Answers one request.
fn answer(mut stream: &TcpStream, shared: &Shared) -> io::Result<()> {
    stream.set_write_timeout(Some(REQUEST_TIMEOUT))?;
    let head = head(stream)?;
    let mut lines = head.lines();
    let request = lines.next().unwrap_or_default();
    let mut fields = lines.filter_map(|line| line.split_once(':'));
    let host = fields.find(|(name, _)| name.eq_ignore_ascii_case("host"));
    let mut words = request.split(' ');
    let (status, kind, body): (_, _, Arc<str>) = match (host, words.next(), words.next()) {
        // a request under another host's name, such as by DNS rebinding, gets nothing
        (Some((_, host)), ..) if !shared.hosts.iter().any(|own| own == host.trim()) => refusal(),
        (None, ..) => refusal(),
        (_, Some("GET"), Some("/")) => {
            let page = shared.page.lock().unwrap_or_else(PoisonError::into_inner);
            ("200 OK", "text/html", Arc::clone(&page.1))
        }
        (_, Some("GET"), Some("/number")) => {
            let page = shared.page.lock().unwrap_or_else(PoisonError::into_inner);
            ("200 OK", "text/plain", page.0.to_string().into())
        }
        _ => (
            "404 Not Found",
            "text/plain",
            "there is one page, /\n".to_owned().into(),
        ),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Referrer-Policy: no-referrer\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())
}

/// The answer to a request that names another host.
fn refusal() -> (&'static str, &'static str, Arc<str>) {
    let explanation = "expected the address that `dsocs watch` prints\n";
    ("403 Forbidden", "text/plain", explanation.into())
}

/// The head of a request, up to its empty line.
fn head(mut stream: &TcpStream) -> io::Result<String> {
    let end = Instant::now() + REQUEST_TIMEOUT;
    let (mut head, mut part) = (Vec::new(), [0; 1024]);
    while !head.ends_with(b"\r\n\r\n") {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || head.len() > LONGEST_REQUEST {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut part)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            count => head.extend_from_slice(part.get(..count).unwrap_or_default()),
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}
