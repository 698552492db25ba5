//! Pages: where it is written, served and compared.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};

const SWING: &str = "pendulum_1_swingup";

#[test]
fn no_page_is_left_beside_another_motion() {
    let folder = empty_folder("report_stale");
    let solve = ["solve", SWING, "--out", "here"];
    let run = aghf(&folder, &solve);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("wrote here/report.html"),
        "{}",
        run.stdout
    );
    assert!(files(&folder).contains("here/report.html"));
    let run = aghf(&folder, &[&solve[..], &["--force", "--no-report"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!run.stdout.contains("report.html"), "{}", run.stdout);
    let left = ["here/summary.json", "here/trajectory.csv"];
    assert_eq!(files(&folder), left.map(str::to_owned).into());
}

#[test]
fn the_page_is_served_to_this_machine_and_nothing_else_is() {
    let folder = empty_folder("report_served");
    assert_bad_input(
        &folder,
        &["view", "nowhere"],
        "nowhere: page; written by `aghf solve`",
    );
    let run = aghf(&folder, &["solve", SWING, "--out", "here"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let mut server = Command::new(env!("CARGO_BIN_EXE_aghf"))
        .current_dir(&folder)
        .args(["view", "here", "--serve"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it runs");
    let mut line = String::new();
    let stdout = server.stdout.take().expect("it is piped");
    BufReader::new(stdout)
        .read_line(&mut line)
        .expect("it prints text");
    let address = line
        .trim()
        .rsplit_once("http://")
        .map(|(_, address)| address.trim_end_matches('/'));
    let address = address.unwrap_or_else(|| panic!("no address: {line}"));
    assert!(address.starts_with("127.0.0.1:"), "{address}");
    let ask = |request: &str| {
        let mut stream = TcpStream::connect(address).expect("it listens");
        write!(stream, "{request} HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("it reads");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("it answers");
        answer
    };
    let page = std::fs::read_to_string(folder.join("here/report.html")).expect("it is there");
    let found = ask("GET /");
    let others = [
        ask("GET /summary.json"),
        ask("GET /../here/summary.json"),
        ask("POST /"),
    ];
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    assert!(found.starts_with("HTTP/1.1 200 OK\r\n"), "{:.60}", found);
    assert!(found.ends_with(&page));
    let statuses = others.map(|answer| answer.split(' ').nth(1).map(str::to_owned));
    assert_eq!(statuses, ["404", "404", "405"].map(|s| Some(s.to_owned())));
}

#[test]
fn two_motions_are_on_one_page() {
    let folder = empty_folder("report_compared");
    for (out, method) in [("direct", "direct"), ("flowed", "flow")] {
        let run = aghf(
            &folder,
            &[
                "solve",
                SWING,
                "--method",
                method,
                "--out",
                out,
                "--no-report",
            ],
        );
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let compare = [
        "compare",
        "direct",
        "flowed/summary.json",
        "-o",
        "both.html",
    ];
    let run = aghf(&folder, &compare);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let page = std::fs::read_to_string(folder.join("both.html")).expect("it is there");
    for words in ["\"direct\"", "\"flow\"", "aghf solve flowed/summary.json"] {
        assert!(page.contains(words), "{words}");
    }
    assert_bad_input(&folder, &compare, "both.html; it exists already");
    std::fs::create_dir(folder.join("empty")).expect("writable");
    assert_bad_input(
        &folder,
        &["compare", "direct", "empty", "-o", "other.html"],
        "empty: summary; summary.json",
    );
}
