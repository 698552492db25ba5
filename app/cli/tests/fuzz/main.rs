//! The readers of files under mutated input: none may panic, hang or refuse without naming the file, and what is
//! accepted can be used.
//!
//! This binary mirrors no module of `src`: it goes through all that read text of users. The files of `corpus` are
//! mutated, byte by byte and token by token, by a seeded generator. `AGHF_FUZZ_SECONDS` says for how long, 10 s of all
//! formats together unless set, and `AGHF_FUZZ_SEED` with which seed, 1 unless set. `targets.rs` alone knows the
//! library, so that a fuzzer guided by coverage can call the same functions.
//!
//! An input that was found belongs into `corpus`, made small: what is there is tried as it is before any mutation.

mod mutate;
mod targets;

use mutate::Mutator;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use targets::{Outcome, Target};

/// An input that takes longer is taken for a hang: the slowest that are known take a second in a debug build.
const HANG: Duration = Duration::from_secs(120);
/// The number of formats.
const FORMATS: f64 = 9.0;
/// The most inputs that are kept to be mutated further.
const POOL: usize = 2000;

#[test]
fn urdf() {
    fuzz("urdf", targets::urdf);
}

#[test]
fn scenario() {
    fuzz("scenario", targets::scenario);
}

#[test]
fn sweep() {
    fuzz("sweep", targets::sweep);
}

#[test]
fn eval() {
    fuzz("eval", targets::eval);
}

#[test]
fn scene() {
    fuzz("scene", targets::scene);
}

#[test]
fn request() {
    fuzz("request", targets::request);
}

#[test]
fn srdf() {
    fuzz("srdf", targets::srdf);
}

#[test]
fn trajectory() {
    fuzz("trajectory", targets::trajectory);
}

#[test]
fn mesh() {
    fuzz("mesh", targets::mesh);
}

/// A number from the environment.
fn from_environment<T: FromStr>(name: &str, default: T) -> T {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is '{text}', no number")),
        Err(_) => default,
    }
}

/// Tries the corpus of a format and its mutations for an equal part of the time.
fn fuzz(format: &'static str, target: Target) {
    let seconds: f64 = from_environment("AGHF_FUZZ_SECONDS", 10.0);
    let seed: u64 = from_environment("AGHF_FUZZ_SEED", 1);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz").join(format);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    let corpus = corpus(format);
    let current = folder.join("current");
    let tried = Arc::new(AtomicU64::new(0));
    let worker = std::thread::spawn({
        let (current, tried) = (current.clone(), Arc::clone(&tried));
        move || {
            let run = || run(corpus, target, &current, seed, seconds / FORMATS, &tried);
            catch_unwind(AssertUnwindSafe(run))
        }
    });
    let input = || {
        let bytes = std::fs::read(&current).unwrap_or_default();
        format!("{}:\n{}", current.display(), bytes.escape_ascii())
    };
    let mut last = (0, Instant::now());
    while !worker.is_finished() {
        std::thread::sleep(Duration::from_millis(20));
        let now = tried.load(Ordering::Relaxed);
        if now != last.0 {
            last = (now, Instant::now());
        }
        assert!(last.1.elapsed() < HANG, "hangs on {}", input());
    }
    match worker.join().expect("it catches panics") {
        Ok(Ok(Counts { all, accepted })) => println!("{format}: {all} inputs, {accepted} accepted"),
        Ok(Err(problem)) => panic!("{problem} on {}", input()),
        Err(_) => panic!("panics on {}", input()),
    }
}

/// The numbers of inputs.
struct Counts {
    all: u64,
    accepted: u64,
}

/// Tries inputs until the time is over; each is in the file at `current` while it is tried.
fn run(
    mut pool: Vec<Vec<u8>>,
    target: Target,
    current: &Path,
    seed: u64,
    seconds: f64,
    tried: &AtomicU64,
) -> Result<Counts, String> {
    let started = Instant::now();
    let mut mutator = Mutator::new(seed, &pool);
    let (mut seen, mut counts) = (HashSet::new(), Counts { all: 0, accepted: 0 });
    let first = pool.len();
    while counts.all < first as u64 || started.elapsed().as_secs_f64() < seconds {
        let input = match pool.get(counts.all as usize).filter(|_| counts.all < first as u64) {
            Some(input) => input.clone(),
            None => mutator.mutated(&pool, first),
        };
        std::fs::write(current, &input).expect("the folder is writable");
        counts.all += 1;
        let outcome = target(current, &input)?;
        counts.accepted += u64::from(matches!(outcome, Outcome::Accepted));
        // The answer to an input shows how far it came: one with a new answer is worth further mutations.
        let is_new = match outcome {
            Outcome::Accepted => counts.accepted.is_multiple_of(16),
            Outcome::Refused(message) => seen.insert(shape(&message)),
        };
        if is_new && counts.all > first as u64 {
            if pool.len() < POOL {
                pool.push(input);
            } else {
                let place = first + mutator.below(POOL - first);
                pool[place] = input;
            }
        }
        tried.store(counts.all, Ordering::Relaxed);
    }
    Ok(counts)
}

/// A message without what it quotes of the input.
fn shape(message: &str) -> String {
    let unquoted: Vec<_> = message.split(['\'', '`', '"']).step_by(2).collect();
    let letters = |c: &char| !c.is_ascii_digit();
    unquoted.concat().chars().filter(letters).collect()
}

/// The files of the corpus of a format, in the order of their names.
fn corpus(format: &str) -> Vec<Vec<u8>> {
    let folder =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("app/cli/tests/fuzz/corpus").join(format);
    let entries = std::fs::read_dir(&folder).expect("there is a corpus");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    files.iter().map(|file| std::fs::read(file).expect("readable")).collect()
}
