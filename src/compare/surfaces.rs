//! Whether two pictures show the same things.
use super::error::CompareError;
use crate::picture::Picture;

/// A pixel shows something else if its depth is this much off, over the truth's: more than what renderers' precision makes of
/// one surface, and less than what lies between most surfaces.
const OTHER_DEPTH: f32 = 0.05;

/// With so large a share of such pixels the pictures are not of one scene and view. Where they are, a pixel on an edge may fall on either
/// side of it: `gibs compare` counts 13 of 36 806 on Sponza a against another renderer, and 768 in a picture of twice the size, where the
/// pixel that is asked lies half a pixel beside the truth's centre.
pub(super) const OTHER_VIEW: f64 = 0.1;

/// How many of the pixels that count show another surface in ours than in the truth, by `depth.Z`; in ours those in the
/// middle of `factor` x `factor` are asked, or next to it. `None` where one of the two has no depth.
pub(super) fn elsewhere(
    ours: &Picture,
    truth: &Picture,
    factor: usize,
    counts: &[bool],
) -> Result<Option<usize>, CompareError> {
    const DEPTH: &str = "depth.Z";
    if !ours.has(DEPTH) || !truth.has(DEPTH) {
        return Ok(None);
    }
    let own = ours.scalar(DEPTH).map_err(CompareError::Ours)?;
    let wanted = truth.scalar(DEPTH).map_err(CompareError::Truth)?;
    let (width, middle) = (truth.width as usize, factor / 2);
    let differs = |i: usize| {
        let (x, y) = (i % width * factor + middle, i / width * factor + middle);
        let own = own[y * ours.width as usize + x];
        let off = (own - wanted[i]).abs() - OTHER_DEPTH * wanted[i].abs();
        // Infinity less itself is no number.
        own != wanted[i] && (off.is_nan() || off > 0.0)
    };
    let counted = (0..counts.len()).filter(|&i| counts[i]);
    Ok(Some(counted.filter(|&i| differs(i)).count()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, depth: impl Fn(u32, u32) -> f32) -> Picture {
        let mut picture = Picture::new(width, width);
        let depths = (0..width * width).map(|i| depth(i % width, i / width));
        picture
            .set_scalar("depth.Z", depths.collect())
            .expect("a value for each pixel");
        picture
    }

    #[test]
    fn pixels_of_other_depths_count_where_the_mask_does() {
        let truth = picture(4, |_, _| 2.0);
        let ours = picture(4, |x, y| match (x, y) {
            (0, _) => 2.09,
            (1, _) => 2.11,
            (2, 0) => f32::NAN,
            (3, 3) => 1.89,
            _ => 2.0,
        });
        let all = elsewhere(&ours, &truth, 1, &[true; 16]);
        assert_eq!(all.expect("depths"), Some(4 + 1 + 1));
        let but_one: Vec<bool> = (0..16).map(|i| i != 1).collect();
        let fewer = elsewhere(&ours, &truth, 1, &but_one);
        assert_eq!(fewer.expect("depths"), Some(5));
        let none = Picture::new(4, 4);
        let unknown = elsewhere(&ours, &none, 1, &[true; 16]);
        assert_eq!(unknown.expect("nothing to read"), None);
    }

    #[test]
    fn the_middle_of_larger_pictures_is_asked() {
        let truth = picture(2, |x, y| (1 + x + 2 * y) as f32);
        let ours = picture(6, |x, y| match (x % 3, y % 3) {
            (1, 1) => (1 + x / 3 + 2 * (y / 3)) as f32,
            _ => 100.0,
        });
        let found = elsewhere(&ours, &truth, 3, &[true; 4]);
        assert_eq!(found.expect("depths"), Some(0));
        // Of an even number that behind the centre.
        let ours = picture(4, |x, y| match (x % 2, y % 2) {
            (1, 1) => (1 + x / 2 + 2 * (y / 2)) as f32,
            _ => 100.0,
        });
        let found = elsewhere(&ours, &truth, 2, &[true; 4]);
        assert_eq!(found.expect("depths"), Some(0));
    }

    #[test]
    fn depths_without_end_are_alike() {
        let sky = picture(2, |_, _| f32::INFINITY);
        let found = elsewhere(&sky, &sky, 1, &[true; 4]);
        assert_eq!(found.expect("depths"), Some(0));
    }
}
