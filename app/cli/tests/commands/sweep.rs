//! `aghf sweep`: what is in its files after kills, over shards and at the time limit, and what it refuses.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use aghf_cli::sweep::{Results, Row, Shard, Sweep};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// 60 sets of a few milliseconds, some of which miss the goal or fail.
const GRID: &str = r#"
method = "flow"
scenarios = ["pendulum_2_swingup", "pendulum_3_swingup"]
time_limit_s = 600
degree = [5, 6]
k = [1e4, 1e5, 1e7]
s_max = [1e-2, 1e-1, 1, 10, 50]
"#;

/// 60 sets of the direct method, as fast.
const DIRECT: &str = r#"
method = "direct"
scenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]
time_limit_s = 600
degree = [5, 6, 7]
starts = [1, 2, 3, 4, 5]
objective.velocity = [0, 0.5]
"#;

fn write(path: PathBuf, text: &str) -> PathBuf {
    std::fs::write(&path, text).expect("the folder is writable");
    path
}

/// A folder with the sweep file `grid.toml`.
fn folder_with(test: &str, grid: &str) -> PathBuf {
    let folder = empty_folder(test);
    write(folder.join("grid.toml"), grid);
    folder
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A results file without its last column, the time.
fn timeless(path: &Path) -> Vec<String> {
    let text = read(path);
    let lines = text.lines().map(|line| line.rsplit_once(',').expect("columns").0.to_owned());
    lines.collect()
}

/// Runs a sweep to its end and returns its results file.
fn sweep(folder: &Path, arguments: &[&str], results: &str) -> PathBuf {
    let run = aghf(folder, &[&["sweep", "grid.toml"], arguments].concat());
    assert_eq!((run.code, &*run.stderr), (Some(0), ""), "{}", run.stdout);
    folder.join("out/sweeps/grid").join(results)
}

/// Asserts that a sweep with these arguments is refused with all words (between semicolons).
fn assert_refused(folder: &Path, arguments: &[&str], words: &str) {
    let arguments = [&["sweep", "grid.toml"], arguments].concat();
    assert_bad_input(folder, &arguments, words);
}

#[test]
fn a_sweep_that_is_killed_again_and_again_ends_with_the_same_file() {
    let whole = killed("flow", GRID);
    for outcome in ["success", "goal_missed"] {
        assert!(whole.iter().any(|line| line.contains(outcome)), "no {outcome}");
    }
}

#[test]
fn so_does_one_of_the_direct_solve() {
    let whole = killed("direct", DIRECT);
    let good = whole.iter().filter(|line| line.contains(",success,"));
    assert_eq!(good.count(), 60);
}

/// Kills a sweep of 60 sets of pendulums many times, compares its results with those of one that went through, and
/// returns those.
fn killed(test: &str, grid: &str) -> Vec<String> {
    let whole = timeless(&sweep(&folder_with(&format!("{test}_whole"), grid), &["--jobs", "1"], "results.csv"));
    assert_eq!(whole.len(), 61);
    for (i, line) in whole[1..].iter().enumerate() {
        assert!(line.starts_with(&format!("{i},pendulum_")), "{line}");
    }

    let folder = folder_with(&format!("{test}_killed"), grid);
    let results = folder.join("out/sweeps/grid/results.csv");
    let lines = || std::fs::read_to_string(&results).map_or(0, |text| text.matches('\n').count());
    let mut kills = 0;
    for wanted in [0, 1, 2, 9, 20, 33, 34, 47, 59] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_aghf"))
            .current_dir(&folder)
            .args(["sweep", "grid.toml", "--jobs", "2"])
            .stdout(Stdio::null())
            .spawn()
            .expect("it runs");
        let ended = loop {
            if let Some(status) = child.try_wait().expect("it is ours") {
                assert!(status.success());
                break true;
            }
            if lines() >= wanted {
                break false;
            }
            std::thread::sleep(Duration::from_micros(200));
        };
        if !ended {
            child.kill().expect("it is ours");
            kills += usize::from(!child.wait().expect("it is ours").success());
        }
    }
    assert!(kills >= 5, "killed {kills} times only");
    assert_eq!(timeless(&sweep(&folder, &[], "results.csv")), whole);
    let expected = ["ranking.csv", "report.html", "results.csv", "results.json", "sweep.json"];
    // Files that a kill left half written stay beside their places.
    let found = files(&folder.join("out/sweeps/grid"));
    let found: Vec<_> = found.iter().filter(|f| !f.ends_with(".partial")).collect();
    assert_eq!(found, expected);
    whole
}

/// The last line says how many sets were solved, how the others ended, how long it took and where the results are.
#[test]
fn the_last_line_sums_up() {
    let folder = folder_with("summary", GRID);
    let last = |arguments: &[&str]| {
        let run = aghf(&folder, &[&["sweep", "grid.toml"], arguments].concat());
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
        run.stdout.lines().last().expect("lines").to_owned()
    };
    let line = last(&[]);
    let rows = timeless(&folder.join("out/sweeps/grid/results.csv"));
    let count = |outcome: &str| {
        let of = |line: &&String| line.contains(&format!(",{outcome},"));
        rows.iter().filter(of).count()
    };
    let (good, missed) = (count("success"), count("goal_missed"));
    assert!(good > 0 && missed > 0);
    let start = format!("{good} of 60 sets solved, {missed} goal_missed");
    assert!(line.starts_with(&start), "{line}");
    assert!(line.contains(" s; results in out/sweeps/grid"), "{line}");
    let part = last(&["--shard", "1/3", "--out", "part"]);
    assert!(part.contains(" of 20 sets solved"), "{part}");
    assert!(part.ends_with("results in part"), "{part}");
}

#[test]
fn a_torn_end_is_solved_again() {
    let folder = folder_with("torn", GRID);
    let results = sweep(&folder, &[], "results.csv");
    let (text, whole) = (read(&results), timeless(&results));
    let header = text.find('\n').expect("lines") + 1;
    // In the middle of the last row, before its end, in a row in the middle, after and within the header, and nothing.
    for cut in [text.len() - 40, text.len() - 1, text.len() / 2, header, header - 1, 10, 0] {
        write(results.clone(), &text[..cut]);
        sweep(&folder, &[], "results.csv");
        assert_eq!(timeless(&results), whole, "cut at {cut}");
    }
    // Interrupted again after one more row: that row does not stick to the torn one.
    write(results.clone(), &text[..text.len() - 40]);
    let grid = folder.join("grid.toml");
    let grid = Sweep::load(grid.to_str().expect("text")).expect("good");
    let open = || Results::open(&grid, Shard::WHOLE, &folder.join("out/sweeps/grid"));
    let torn = open().expect("good");
    let [missing] = torn.missing()[..] else {
        panic!("one row was torn");
    };
    torn.append(Row::failed(&grid, &missing, "made", 0.5)).expect("writable");
    drop(torn);
    assert_eq!(open().expect("good").missing(), []);
}

#[test]
fn a_wrong_line_is_an_error() {
    let folder = folder_with("wrong_line", GRID);
    let results = sweep(&folder, &[], "results.csv");
    let text = read(&results);
    let second = text.lines().nth(2).expect("60 rows");
    for (from, to, words) in [
        ("set,scenario", "set,scene", "results.csv: line 1: it is not the header"),
        ("\n1,pendulum_2", "\n1,pendulum_3", "line 3: its set 1 is not one of this sweep"),
        ("\n1,pendulum_2", "\n60,pendulum_2", "line 3: its set 60 is not one of this sweep"),
        ("\n1,pendulum_2_swingup,5,10000.0", "\n1,pendulum_2_swingup,5,10001.0", "line 3: its set 1"),
        ("\n1,pendulum_2", "\none,pendulum_2", "line 3: ; invalid digit"),
        ("\n2,", &format!("\n{second}\n2,"), "line 4: set 1 is there already"),
    ] {
        assert!(text.contains(from), "{from}");
        write(results.clone(), &text.replacen(from, to, 1));
        assert_refused(&folder, &[], words);
    }
}

#[test]
fn results_of_another_sweep_are_refused() {
    let small = GRID.replace("1e-2, 1e-1, 1, 10, 50", "1");
    let folder = folder_with("another", &small.replace("pendulum_3_swingup", "mine.json"));
    let robots = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/pendulum_1");
    let scenario = read(&robots.join("pendulum_1_swingup.json"));
    let mine = scenario.replace("\"pendulum_1\"", "\"mine.urdf\"");
    let urdf = read(&robots.join("pendulum_1.urdf"));
    let (mine_path, urdf_path) = (folder.join("mine.json"), folder.join("mine.urdf"));
    write(mine_path.clone(), &mine);
    write(urdf_path.clone(), &urdf);
    let results = sweep(&folder, &[], "results.csv");
    let before = read(&results);
    let refused = |words| assert_refused(&folder, &[], words);

    write(mine_path.clone(), &mine.replace("\"horizon_s\": 2.0", "\"horizon_s\": 2.5"));
    refused("sweep.json: scenarios.1.file.horizon_s: ; another value");
    write(mine_path, &mine);
    write(urdf_path.clone(), &urdf.replacen("<link", "<!-- heavier --><link", 1));
    refused("sweep.json: scenarios.1.robot_sha256: ; another value");
    write(urdf_path, &urdf);
    let grid = read(&folder.join("grid.toml"));
    for (from, to, words) in [
        ("degree = [5, 6]", "degree = [5, 8]", "sweep.json: grid.degree.1"),
        ("1e7]", "1e7, 1e8]", "sweep.json: grid.k"),
        ("= 600", "= 601", "sweep.json: time_limit_s"),
        (", \"mine.json\"", "", "sweep.json: scenarios"),
    ] {
        write(folder.join("grid.toml"), &grid.replace(from, to));
        refused(words);
    }
    write(folder.join("grid.toml"), &grid);
    let identity = results.with_file_name("sweep.json");
    let text = read(&identity);
    write(identity.clone(), "{");
    refused("sweep.json: sweep: it is no JSON");
    std::fs::remove_file(&identity).expect("it is there");
    refused("sweep.json: sweep: it is missing");
    write(identity, &text);
    assert_eq!(read(&sweep(&folder, &[], "results.csv")), before, "nothing was lost");
}

#[test]
fn two_processes_do_not_write_one_file() {
    let folder = folder_with("locked", GRID);
    let path = folder.join("grid.toml");
    let grid = Sweep::load(path.to_str().expect("text")).expect("good");
    let held = Results::open(&grid, Shard::WHOLE, &folder.join("out/sweeps/grid")).expect("free");
    let words = "results.csv: results: another process is at work on it";
    assert_refused(&folder, &[], words);
    assert_refused(&folder, &["--merge"], words);
    drop(held);
    sweep(&folder, &[], "results.csv");
}

/// Solves one of three shards, and returns its results file.
fn shard(folder: &Path, i: usize) -> PathBuf {
    let (part, name) = (format!("{i}/3"), format!("results.shard-{i}-of-3.csv"));
    sweep(folder, &["--shard", &part], &name)
}

#[test]
fn shards_are_joined_to_the_whole() {
    let whole = timeless(&sweep(&folder_with("unspread", GRID), &[], "results.csv"));
    let folder = folder_with("shards", GRID);
    let first = shard(&folder, 1);
    assert_eq!(timeless(&first)[..3], [&whole[0], &whole[1], &whole[4]].map(String::clone));
    shard(&folder, 2);
    let words = "20 of 60 sets are missing, the first is set 2";
    assert_refused(&folder, &["--merge"], words);
    let third = shard(&folder, 3);
    assert_eq!(timeless(&sweep(&folder, &["--merge"], "results.csv")), whole);
    sweep(&folder, &["--merge"], "results.csv"); // once more changes nothing
    let results = folder.join("out/sweeps/grid/results.csv");
    assert_eq!(timeless(&results), whole);

    // A shard again with another value for a set, and a shard of something else.
    let text = read(&third);
    let row = text.lines().nth(1).expect("rows");
    let other = row.replacen("pendulum_2_swingup,5,", "pendulum_2_swingup,7,", 1);
    write(third.clone(), &text.replacen(row, &other, 1));
    let words = "shard-3-of-3.csv: line 2: its set 2 is not one of this sweep";
    assert_refused(&folder, &["--merge"], words);
    let before = row.rsplitn(3, ',').nth(2).expect("columns");
    let other = format!("{before},99999,0.5");
    write(third.clone(), &text.replacen(row, &other, 1));
    let words = "shard-3-of-3.csv: set 2: another file has other values";
    assert_refused(&folder, &["--merge"], words);
    let lone = empty_folder("lone").join("results.shard-1-of-3.csv");
    std::fs::copy(&first, &lone).expect("writable");
    let lone = lone.to_str().expect("text");
    let words = "lone/sweep.json: No such file";
    assert_refused(&folder, &["--merge", lone], words);
    assert_eq!(timeless(&results), whole);
    for bad in ["0/3", "4/3", "1", "a/b", "1/0"] {
        assert_refused(&folder, &["--shard", bad], "1 <= i <= n");
    }
    assert_refused(&folder, &["--jobs", "0"], "jobs: it is 0");
}

#[test]
fn a_set_that_runs_out_of_time_is_a_row() {
    for (test, grid, columns) in [("time", GRID, [3, 9]), ("direct_time", DIRECT, [3, 13])] {
        let folder = folder_with(test, &grid.replace("600", "1e-9"));
        let rows = timeless(&sweep(&folder, &[], "results.csv"));
        assert_eq!(rows.len(), 61);
        // Nothing is measured.
        let [parameters, measured] = columns;
        let reason = ",time_limit,time limit of 0.000000001 s reached";
        for row in &rows[1..] {
            let (before, after) = row.split_once(reason).unwrap_or_else(|| panic!("{row}"));
            assert_eq!(before.matches(',').count(), 1 + parameters, "{row}");
            assert_eq!(after, ",".repeat(measured), "{row}");
        }
    }
}
