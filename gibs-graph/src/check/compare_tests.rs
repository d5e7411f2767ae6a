use super::*;
use crate::{Element, Lists, Ports};
use bytemuck::cast_slice;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

fn held<T: Element>(comparator: Comparator, a: &[T], b: &[T]) -> Comparison {
    let len = a.len().max(b.len()) as u64;
    compare(
        &T::layout(),
        len,
        &comparator,
        cast_slice(a),
        cast_slice(b),
        &[],
    )
}

fn next(x: f32, ulps: u32) -> f32 {
    f32::from_bits(x.to_bits() + ulps)
}

const EXACT: Comparator = Comparator::exact("a test");

#[test]
fn equal_bits_pass_everywhere() {
    let found = held(EXACT, &[1.0_f32, 2.0], &[1.0, 2.0]);
    assert_eq!((found.elements, found.unequal), (2, 0));
    assert!(found.refused.is_empty() && found.worst.is_none());
}

/// One flipped bit of any word is found, and where it is.
#[test]
fn a_flipped_bit_is_found() {
    let a = [7_u32; 100];
    for bit in 0..32 {
        let mut b = a;
        b[61] ^= 1 << bit;
        assert_eq!(held(Comparator::ROUNDING, &a, &b).refused, [61]);
    }
    let (a, mut b) = ([PI; 100], [PI; 100]);
    b[3] = next(PI, 1);
    let found = held(EXACT, &a, &b);
    assert_eq!(found.refused, [3]);
    assert_eq!(found.worst.map(|worst| worst.ulps), Some(1.0));
}

#[test]
fn ulps_are_counted_up_to_the_bound() {
    let four = Comparator::ulps(4, "a test");
    let found = held(four, &[PI, PI], &[next(PI, 4), next(PI, 5)]);
    assert_eq!((found.unequal, found.refused), (2, vec![1]));
    // Across a power of two, the larger ULP counts.
    assert!(held(four, &[next(2.0, 3)], &[2.0]).refused.is_empty());
    assert_eq!(held(four, &[next(2.0, 5)], &[2.0]).refused, [0]);
}

/// What is small beside its neighbours may be off by the rounding of those; alone it may not.
#[test]
fn vectors_are_scaled_by_their_largest_component() {
    let scaled = Comparator::scaled(2, "a test");
    let (a, b) = (Vec3::new(1.0, 1.0e-7, 0.0), Vec3::new(1.0, 2.5e-7, 0.0));
    assert!(held(scaled, &[a], &[b]).refused.is_empty());
    assert_eq!(held(scaled, &[a.y], &[b.y]).refused, [0]);
    let b = Vec3::new(1.0, 5.0e-7, 0.0);
    assert_eq!(held(scaled, &[a], &[b]).refused, [0]);
    // The largest component on either side.
    let found = held(scaled, &[Vec2::new(0.0, 0.0)], &[Vec2::new(0.0, 1.0)]);
    assert_eq!(found.refused, [0]);
}

#[test]
fn an_absolute_bound_is_one() {
    let tenth = Comparator::absolute(0.1, "a test");
    assert_eq!(
        held(tenth, &[0.0_f32, 1.0e6], &[0.09, 1.0e6 + 1.0]).refused,
        [1]
    );
}

#[test]
fn what_is_not_finite_fails_even_on_both_sides() {
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(held(Comparator::ROUNDING, &[x], &[x]).refused, [0], "{x}");
        assert_eq!(held(Comparator::ROUNDING, &[1.0], &[x]).refused, [0]);
        let allowed = Comparator::ROUNDING.with_non_finite();
        assert!(held(allowed, &[x], &[x]).refused.is_empty(), "{x}");
        assert_eq!(held(allowed, &[x], &[1.0]).refused, [0]);
    }
    let allowed = Comparator::ROUNDING.with_non_finite();
    assert_eq!(
        held(allowed, &[f32::INFINITY], &[f32::NEG_INFINITY]).refused,
        [0]
    );
}

/// Memory that neither side has written is no value; that only one has written is a difference.
#[test]
fn a_missing_store_shows() {
    let nothing = f32::from_bits(UNWRITTEN);
    assert!(
        held(Comparator::ROUNDING, &[nothing], &[nothing])
            .refused
            .is_empty()
    );
    let found = held(
        Comparator::ROUNDING.with_non_finite(),
        &[nothing],
        &[f32::NAN],
    );
    assert_eq!(found.refused, [0]);
    assert_eq!(
        found.worst.map(|w| (w.a, w.b)),
        Some(("unwritten".into(), "NaN".into()))
    );
}

#[test]
fn bytes_that_are_missing_are_refused() {
    let found = held(Comparator::ROUNDING, &[1_u32, 2, 3], &[1]);
    assert_eq!((found.elements, found.refused), (3, vec![1, 2]));
    assert_eq!(held(Comparator::ROUNDING, &[1_u32], &[]).refused, [0]);
}

#[test]
fn zeros_of_two_signs_are_apart_only_where_bits_count() {
    assert_eq!(held(EXACT, &[0.0_f32], &[-0.0]).refused, [0]);
    assert!(
        held(Comparator::ROUNDING, &[0.0_f32], &[-0.0])
            .refused
            .is_empty()
    );
}

#[test]
fn a_multiset_forgets_order_and_nothing_else() {
    let any = EXACT.in_any_order();
    assert!(
        held(any, &[1_u32, 2, 2, 3], &[2, 3, 1, 2])
            .refused
            .is_empty()
    );
    assert_eq!(held(any, &[1_u32, 2, 2, 3], &[2, 3, 1, 3]).refused.len(), 1);
}

#[test]
fn order_is_forgotten_within_lists_only() {
    const LISTS: Lists = Lists {
        name: "pairs",
        of: |ports: &Ports<'_>| {
            let starts = ports.get::<u32>("starts");
            starts.iter().map(|&s| s as usize..s as usize + 2).collect()
        },
        room: |len| len,
    };
    let within = EXACT.in_any_order_within(LISTS);
    let (layout, starts) = (u32::layout(), [0_u32, 2]);
    let mut ports = Ports::default();
    ports.push("starts", &layout, cast_slice(&starts));
    let lists = (LISTS.of)(&ports);
    let held = |b: &[u32]| {
        let a: &[u32] = &[1, 2, 3, 4, 5];
        compare(
            &layout,
            a.len() as u64,
            &within,
            cast_slice(a),
            cast_slice(b),
            &lists,
        )
    };
    assert!(held(&[2, 1, 4, 3, 5]).refused.is_empty());
    assert!(!held(&[1, 3, 2, 4, 5]).refused.is_empty());
    assert!(!held(&[1, 2, 3, 5, 4]).refused.is_empty());
    // The last list does not fit.
    let lists = [0..2, 3..6];
    let a: &[u32] = &[1, 2, 3, 4, 5];
    let held = |b: &[u32]| {
        compare(
            &layout,
            a.len() as u64,
            &within,
            cast_slice(a),
            cast_slice(b),
            &lists,
        )
    };
    assert!(held(&[2, 1, 3, 6, 7]).refused.is_empty());
    assert!(!held(&[2, 1, 4, 6, 7]).refused.is_empty());
    // Lists may take the first four of five: of the last list, the one that is there is chance; what is behind is none's.
    let short = EXACT.in_any_order_within(Lists {
        room: |len| len - 1,
        ..LISTS
    });
    let held = |b: &[u32]| {
        let (a, b) = (cast_slice(a), cast_slice(b));
        compare(&layout, 5, &short, a, b, &lists)
    };
    let found = held(&[2, 1, 3, 6, 5]);
    assert!(found.refused.is_empty());
    assert_eq!((found.elements, found.skipped), (4, 1));
    assert_eq!(held(&[2, 1, 3, 6, 7]).refused, [4]);
    assert_eq!(held(&[2, 1, 4, 6, 5]).refused, [2]);
}
