//! Parts of a sweep for several machines.

use std::str::FromStr;

/// A part of a sweep for one of several machines: its sets `index - 1`, `index - 1 + count` and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// The index of this part, from 1.
    pub index: usize,
    /// The number of parts.
    pub count: usize,
}

impl Shard {
    /// The single part of an undivided sweep.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Returns true if a set belongs to this part.
    #[must_use]
    pub fn has(&self, set: usize) -> bool {
        set % self.count == self.index - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text.split_once('/');
        let shard = parts.and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            (1..=count).contains(&index).then_some(Self { index, count })
        });
        shard.ok_or_else(|| "i/n with 1 <= i <= n is needed, such as 2/8".to_owned())
    }
}
