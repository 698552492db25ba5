//! Pages: where it is written, served and compared.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

const SWING: &str = "pendulum_1_swingup";

#[test]
fn no_page_is_left_beside_another_motion() {
    let folder = empty_folder("report_stale");
    let solve = ["solve", SWING, "--out", "here"];
    let run = aghf(&folder, &solve);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("report.html in here"), "{}", run.stdout);
    assert!(files(&folder).contains("here/report.html"));
    let run = aghf(&folder, &[&solve[..], &["--force", "--no-report"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!run.stdout.contains("report.html"), "{}", run.stdout);
    let left = ["here/summary.json", "here/trajectory.csv"];
    assert_eq!(files(&folder), left.map(str::to_owned).into());
}

/// Serves the page in a folder; returns the process and its address.
fn served(folder: &Path) -> (Child, String) {
    let mut server = Command::new(env!("CARGO_BIN_EXE_aghf"))
        .current_dir(folder)
        .args(["view", "here", "--serve"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it runs");
    let mut line = String::new();
    let stdout = server.stdout.take().expect("it is piped");
    BufReader::new(stdout).read_line(&mut line).expect("it prints text");
    let address = line.trim().rsplit_once("http://").map(|(_, address)| address.trim_end_matches('/'));
    let address = address.unwrap_or_else(|| panic!("no address: {line}"));
    (server, address.to_owned())
}

#[test]
fn the_page_is_served_to_this_machine_and_nothing_else_is() {
    let folder = empty_folder("report_served");
    assert_bad_input(&folder, &["view", "nowhere"], "nowhere: page; written by `aghf solve`");
    let run = aghf(&folder, &["solve", SWING, "--out", "here"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let (mut server, address) = served(&folder);
    let address = &*address;
    assert!(address.starts_with("127.0.0.1:"), "{address}");
    // A client that does not end its request keeps nobody waiting.
    let mut slow = TcpStream::connect(address).expect("it listens");
    let mut sender = slow.try_clone().expect("it is open");
    let (stop, stopped) = std::sync::mpsc::channel::<()>();
    let sends = std::thread::spawn(move || {
        let mut next = "GET / HTTP/1.1\r\n";
        while stopped.recv_timeout(Duration::from_millis(20)) == Err(RecvTimeoutError::Timeout) {
            // A server that gives up has closed it.
            let _ = sender.write_all(next.as_bytes());
            next = "X: y\r\n";
        }
    });
    let ask_as = |request: &str, host: &str| {
        let mut stream = TcpStream::connect(address).expect("it listens");
        write!(stream, "{request} HTTP/1.1\r\n{host}\r\n\r\n").expect("it reads");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("it answers");
        answer
    };
    let ask = |request: &str| ask_as(request, &format!("Host: {address}"));
    let page = std::fs::read_to_string(folder.join("here/report.html")).expect("it is there");
    let found = ask("GET /");
    let others = [ask("GET /summary.json"), ask("GET /../here/summary.json"), ask("POST /")];
    let port = address.rsplit(':').next().expect("it has a port");
    let own = [&format!("host: LOCALHOST:{port}"), "Host:127.0.0.1"].map(|host| ask_as("GET /", host));
    let foreign = [
        &format!("Host: evil.example:{port}"),
        &format!("Host: localhost.evil.example:{port}"),
        "Host: 127.0.0.1.evil.example",
        "Host:",
        "Accept: */*",
        "X-Host: localhost",
    ];
    let foreign = foreign.map(|host| ask_as("GET /", host));
    slow.set_nonblocking(true).expect("it is open");
    let not_yet = slow.read(&mut [0; 1]).map_err(|e| e.kind());
    drop(stop);
    sends.join().expect("it ends");
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    assert_eq!(not_yet, Err(ErrorKind::WouldBlock));
    assert!(found.starts_with("HTTP/1.1 200 OK\r\n"), "{:.60}", found);
    assert!(found.ends_with(&page));
    let statuses = others.map(|answer| answer.split(' ').nth(1).map(str::to_owned));
    assert_eq!(statuses, ["404", "404", "405"].map(|s| Some(s.to_owned())));
    assert!(own.iter().all(|answer| answer.ends_with(&page)));
    for answer in foreign {
        assert!(answer.starts_with("HTTP/1.1 421 "), "{answer:.60}");
        assert!(!answer.contains("<html"), "{answer:.60}");
    }
}

#[test]
fn two_motions_are_on_one_page() {
    let folder = empty_folder("report_compared");
    for (out, method) in [("direct", "direct"), ("flowed", "flow")] {
        let run = aghf(&folder, &["solve", SWING, "--method", method, "--out", out, "--no-report"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let compare = ["compare", "direct", "flowed/summary.json", "-o", "both.html"];
    let run = aghf(&folder, &compare);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let page = std::fs::read_to_string(folder.join("both.html")).expect("it is there");
    for words in ["\"direct\"", "\"flow\"", "aghf solve flowed/summary.json"] {
        assert!(page.contains(words), "{words}");
    }
    assert_bad_input(&folder, &compare, "both.html; it exists already");
    std::fs::create_dir(folder.join("empty")).expect("writable");
    assert_bad_input(&folder, &["compare", "direct", "empty", "-o", "other.html"], "empty: summary; summary.json");
}
