//! Mutations of texts, on bytes and on tokens.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// The largest input, in bytes.
const MAX_INPUT: usize = 1 << 16;
/// The most mutations of one input.
const MAX_MUTATIONS: usize = 6;

/// Numbers and texts at which readers stumble, beside the words of the corpus itself.
const ODD: [&str; 44] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-6",
    "1e-300",
    "1e-320",
    "1e9",
    "1e154",
    "1e300",
    "1e308",
    "1e309",
    "-1e999",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "null",
    "true",
    "[]",
    "{}",
    "[[]]",
    "\"\"",
    "''",
    "100",
    "256",
    "257",
    "1000000",
    "4294967296",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "0x10",
    "1_000",
    "1.",
    ".5",
    "+1",
    "1 2",
    "\u{feff}",
    "&#0;",
    "\\u0000",
    "\n",
];

/// The number of these that are numbers, which any format may have.
const NUMBERS: usize = 15;

/// Texts that open something, to be nested deeply.
const OPENINGS: [&str; 9] = ["[", "{\"a\":", "<a>", "<robot>", "[a.", "[[", "{a=", "&lt;", "\\"];

/// A seeded source of mutations.
pub struct Mutator {
    rng: ChaCha8Rng,
    words: Vec<Vec<u8>>,
}

impl Mutator {
    /// One whose dictionary has the tokens of these texts.
    pub fn new(seed: u64, corpus: &[Vec<u8>]) -> Self {
        let mut words: Vec<Vec<u8>> = ODD.iter().map(|word| word.as_bytes().to_vec()).collect();
        for text in corpus {
            words.extend(tokens(text).into_iter().map(|token| text[token].to_vec()));
        }
        words.sort();
        words.dedup();
        Self { rng: ChaCha8Rng::seed_from_u64(seed), words }
    }

    /// A number below `end`, which is not zero.
    pub fn below(&mut self, end: usize) -> usize {
        self.rng.random_range(0..end)
    }

    /// A text of the pool, one of its `first` half of the time, after some mutations.
    pub fn mutated(&mut self, pool: &[Vec<u8>], first: usize) -> Vec<u8> {
        let among = if self.below(2) == 0 { first } else { pool.len() };
        let mut text = pool[self.below(among)].clone();
        // One is enough more often than not, for what is refused early shows little.
        for _ in 0..=self.below(MAX_MUTATIONS).saturating_sub(MAX_MUTATIONS / 2) {
            text = self.mutate(text, pool);
            text.truncate(MAX_INPUT);
        }
        text
    }

    fn mutate(&mut self, mut text: Vec<u8>, pool: &[Vec<u8>]) -> Vec<u8> {
        match self.below(20) {
            0 => {
                if let Some(place) = self.place(&text) {
                    text[place] ^= 1 << self.below(8);
                }
            }
            1 => {
                if let Some(place) = self.place(&text) {
                    text[place] = self.rng.random();
                }
            }
            2 => {
                let cut = self.part(&text);
                text.drain(cut);
            }
            3 => {
                let end = self.below(text.len() + 1);
                text.truncate(end);
            }
            4 => {
                let copied = text[self.part(&text)].to_vec();
                let (place, times) = (self.below(text.len() + 1), 1 << self.below(8));
                text.splice(place..place, copied.repeat(times));
            }
            5 => {
                let other = pool[self.below(pool.len())].clone();
                let end = self.below(text.len() + 1);
                text.truncate(end);
                text.extend(&other[self.below(other.len() + 1)..]);
            }
            6 => {
                let opening = OPENINGS[self.below(OPENINGS.len())];
                let (place, times) = (self.below(text.len() + 1), 1 << self.below(14));
                text.splice(place..place, opening.as_bytes().repeat(times));
            }
            7..10 => {
                if let Some(token) = self.token(&text) {
                    let word = self.below(self.words.len());
                    let word = self.words[word].clone();
                    text.splice(token, word);
                }
            }
            10 => {
                if let (Some(one), Some(other)) = (self.token(&text), self.token(&text)) {
                    let word = text[other].to_vec();
                    text.splice(one, word);
                }
            }
            11 => {
                if let Some(token) = self.token(&text) {
                    text.drain(token);
                }
            }
            _ => {
                let mut tokens = tokens(&text);
                tokens.retain(|token| text[token.start].is_ascii_digit());
                if !tokens.is_empty() {
                    let token = tokens.swap_remove(self.below(tokens.len()));
                    let number = ODD[self.below(NUMBERS)].bytes();
                    text.splice(token, number);
                }
            }
        }
        text
    }

    fn place(&mut self, text: &[u8]) -> Option<usize> {
        (!text.is_empty()).then(|| self.below(text.len()))
    }

    /// A part, short most of the time.
    fn part(&mut self, text: &[u8]) -> Range<usize> {
        let from = self.below(text.len() + 1);
        let most = (text.len() - from).min(1 << self.below(10));
        from..from + self.below(most + 1)
    }

    fn token(&mut self, text: &[u8]) -> Option<Range<usize>> {
        let mut tokens = tokens(text);
        (!tokens.is_empty()).then(|| tokens.swap_remove(self.below(tokens.len())))
    }
}

/// Words and numbers, and single marks between them.
fn tokens(text: &[u8]) -> Vec<Range<usize>> {
    let is_word = |b: u8| b.is_ascii_alphanumeric() || b"_.+-*".contains(&b);
    let (mut tokens, mut from) = (Vec::new(), 0);
    while let Some(first) = text.get(from) {
        let rest = text[from..].iter();
        let length = rest.take_while(|b| is_word(**b)).count().max(1);
        if !first.is_ascii_whitespace() {
            tokens.push(from..from + length);
        }
        from += length;
    }
    tokens
}
