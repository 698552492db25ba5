//! The format of lists, polynomials and numbers in text.

/// Joins words without repetitions, in the order of their first occurrence.
pub(super) fn distinct(words: impl Iterator<Item = String>, between: &str) -> String {
    let mut seen: Vec<String> = Vec::new();
    for word in words {
        if !seen.contains(&word) {
            seen.push(word);
        }
    }
    seen.join(between)
}

/// Formats a polynomial in `N` in the usual notation.
pub(super) fn in_words(coefficients: &[f64]) -> String {
    let mut words = String::new();
    for (power, c) in coefficients.iter().enumerate() {
        let sign = match (power, *c < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let variable = match power {
            0 => String::new(),
            1 => " N".to_owned(),
            _ => format!(" N^{power}"),
        };
        words.push_str(&format!("{sign}{}{variable}", figures(c.abs(), 3)));
    }
    words
}

/// Formats a number with `count` significant figures, in the shorter of the usual notations.
pub(super) fn figures(x: f64, count: usize) -> String {
    let scientific = format!("{x:.*e}", count - 1);
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse().ok());
    match exponent {
        Some(e @ -3..=6) => {
            let e: i32 = e;
            let decimals = (count as i32 - 1 - e).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => scientific,
    }
}
