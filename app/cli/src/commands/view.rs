//! `aghf view`.

use super::{print, tell};
use aghf::error::{Error, Result};
use clap::Args;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// The pages in a folder, that of a success first.
const PAGES: [&str; 2] = ["report.html", "report.failed.html"];
/// The longest request, bytes, and the longest time for reading it.
const MAX_REQUEST: u64 = 1 << 14;
const MAX_WAIT: Duration = Duration::from_secs(5);

/// Opens the page of a motion, a sweep or another experiment in a browser.
///
/// Without a browser, or with --serve, the page is served to the browsers of this machine until Ctrl-C, under the names
/// 127.0.0.1 and localhost alone, and its address is printed.
#[derive(Debug, Args)]
pub(super) struct View {
    /// Folder of a solve, a sweep or another experiment, or the path of a page.
    path: PathBuf,
    /// Serves the page at http://127.0.0.1:PORT/ [default of PORT: a free one].
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0")]
    serve: Option<u16>,
}

impl View {
    pub(super) fn run(self) -> Result<ExitCode> {
        let page = page_at(&self.path)?;
        if let Some(port) = self.serve {
            return serve(&page, port);
        }
        if let Err(reason) = open_in_browser(&page) {
            tell(&format!("aghf: no browser was opened: {reason}"));
            return serve(&page, 0);
        }
        print(&format!("opened {}", page.display()))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Finds the page in a folder or at a path.
fn page_at(path: &Path) -> Result<PathBuf> {
    if path.is_file() {
        return Ok(path.to_owned());
    }
    let pages = PAGES.map(|name| path.join(name));
    let [success, failure] = &pages;
    pages.iter().find(|page| page.is_file()).cloned().ok_or_else(|| {
        let condition = format!(
            "there is neither '{}' nor '{}', which are written by `aghf solve` and `sweep`",
            success.display(),
            failure.display()
        );
        Error::input(path.display().to_string(), "page", condition)
    })
}

/// Opens the page in the browser of the desktop; the error gives the reason of a failure.
fn open_in_browser(page: &Path) -> std::result::Result<(), String> {
    // On Linux without a desktop, `open` might start a text browser in this terminal.
    let desktops = ["DISPLAY", "WAYLAND_DISPLAY"];
    if cfg!(target_os = "linux") && desktops.iter().all(|name| std::env::var_os(name).is_none()) {
        return Err("there is no desktop".to_owned());
    }
    let page = std::path::absolute(page).map_err(|e| e.to_string())?;
    open::that(page).map_err(|e| e.to_string())
}

/// Serves the page to this machine only until the program is stopped.
fn serve(page: &Path, port: u16) -> Result<ExitCode> {
    let refused = |e| Error::io(format!("127.0.0.1:{port}"), e);
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
    let address = listener.local_addr().map_err(refused)?;
    print(&format!("serving {} at http://{address}/", page.display()))?;
    for stream in listener.incoming() {
        // A client that sends nothing does not keep others waiting.
        let page = page.to_owned();
        let in_thread = |stream| {
            let answer = move || complain(answer(stream, &page));
            std::thread::Builder::new().spawn(answer).map(|_| ())
        };
        complain(stream.and_then(in_thread));
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints the failure of a request, such as that of a client that disconnects.
fn complain(answered: std::io::Result<()>) {
    if let Err(error) = answered {
        tell(&format!("aghf: a request failed: {error}"));
    }
}

/// Returns true for a header with a name of this machine as the host. A page of another site whose name leads to this
/// machine would read the motion otherwise.
fn is_own_host(header: &str) -> bool {
    let Some((name, host)) = header.split_once(':') else {
        return false;
    };
    let host = host.trim();
    let host = host.rsplit_once(':').map_or(host, |(host, _)| host);
    let own = ["127.0.0.1", "localhost"];
    name.eq_ignore_ascii_case("host") && own.iter().any(|own| host.eq_ignore_ascii_case(own))
}

/// Answers one request to this machine: the page, reread for each request to `/`, and nothing else.
fn answer(mut stream: TcpStream, page: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(MAX_WAIT))?;
    stream.set_write_timeout(Some(MAX_WAIT))?;
    let mut lines = BufReader::new(stream.try_clone()?.take(MAX_REQUEST)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    let mut is_own = false;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        is_own |= is_own_host(&line);
    }
    let mut words = request.split(' ');
    let (status, body) = match (words.next(), words.next()) {
        _ if !is_own => ("421 Misdirected Request", b"the host is neither 127.0.0.1 nor localhost".to_vec()),
        (Some("GET" | "HEAD"), Some("/")) => ("200 OK", std::fs::read(page)?),
        (Some("GET" | "HEAD"), _) => ("404 Not Found", b"there is only /".to_vec()),
        _ => ("405 Method Not Allowed", Vec::new()),
    };
    let kind = if status.starts_with("200") { "text/html" } else { "text/plain" };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n\
        Cache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    if !request.starts_with("HEAD") {
        stream.write_all(&body)?;
    }
    stream.flush()
}
