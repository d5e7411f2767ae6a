//! Names that come near one that there is not.
use std::collections::BTreeSet;

/// Names that are said at most.
const MOST: usize = 3;

/// Shares of pairs of letters from which on a name is near.
const NEAR: f64 = 0.4;

/// The names that have most pairs of letters in common with what was asked for, the nearest first; none where none is near.
pub(crate) fn near<'a>(asked: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let wanted = pairs(asked);
    let distinct: BTreeSet<&str> = names.into_iter().collect();
    let mut found: Vec<(f64, &str)> = distinct
        .into_iter()
        .map(|name| {
            let has = pairs(name);
            let common = wanted.intersection(&has).count() as f64;
            let all = (wanted.len() + has.len()).max(1) as f64;
            (2.0 * common / all, name)
        })
        .filter(|(share, _)| *share >= NEAR)
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let nearest = found.into_iter().take(MOST);
    nearest.map(|(_, name)| name.to_owned()).collect()
}

/// Neighbouring letters and digits, in whatever case: `gap_fill`, `gap-fill` and `GapFill` have the same.
fn pairs(name: &str) -> BTreeSet<[char; 2]> {
    let plain: Vec<char> = name
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    plain.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::near;

    #[test]
    fn names_that_are_spelled_otherwise_are_near() {
        let names = [
            "GapFill",
            "gap_fill",
            "TraceClosest",
            "trace_any",
            "Compose",
        ];
        assert_eq!(near("gap-fil", names), ["GapFill", "gap_fill"]);
        assert_eq!(near("TraceClosets", names)[0], "TraceClosest");
        assert!(near("Nonsense", names).is_empty());
        assert!(near("", names).is_empty());
    }
}
