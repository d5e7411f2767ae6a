//! Random frames, compiled, against the oracle.
mod common;

use common::frame::record;
use common::oracle::{self, Recorded, Start};
use common::*;
use gibs_graph::{Action, Graph, HazardKind, Kind, Schedule};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Which steps come before which, by the schedule's edges.
fn reachable(schedule: &Schedule) -> Vec<BTreeSet<usize>> {
    let mut before = vec![BTreeSet::new(); schedule.steps.len()];
    for later in 0..before.len() {
        for &(earlier, _, _) in schedule
            .edges
            .iter()
            .filter(|edge| edge.1 as usize == later)
        {
            let all = before[earlier as usize].clone();
            before[later].extend(all);
            before[later].insert(earlier as usize);
        }
    }
    before
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn schedules_agree_with_the_oracle(
        resources in prop::collection::vec(any::<u8>(), 1..9),
        stages in prop::collection::vec((any::<u8>(), any::<[u8; 3]>()), 0..24),
        outputs in any::<u16>(),
    ) {
        let (schedule, starts, stages, outputs) = record(&resources, &stages).compile(outputs);

        // What is live, in the order of insertion; the rest is named as removed.
        let live = oracle::traces(&starts, &stages, &outputs);
        let is_live = |(i, stage): (usize, &Recorded)| live.contains(&i).then(|| stage.label.clone());
        let is_dead = |(i, stage): (usize, &Recorded)| (!live.contains(&i)).then(|| stage.label.clone());
        let ran: Vec<_> = schedule.dispatches().map(|(_, step, _)| step.label.clone()).collect();
        prop_assert_eq!(ran, stages.iter().enumerate().filter_map(is_live).collect::<Vec<_>>());
        prop_assert_eq!(&schedule.removed, &stages.iter().enumerate().filter_map(is_dead).collect::<Vec<_>>());

        // Every conflict is settled, and no barrier could be left out.
        prop_assert_eq!(oracle::unsettled(&schedule), vec![]);
        for i in 0..schedule.steps.len() {
            let mut without = schedule.clone();
            if !std::mem::take(&mut without.steps[i].hazards).is_empty() {
                prop_assert!(!oracle::unsettled(&without).is_empty(), "the barrier before step {} is idle", i);
            }
        }

        // Hazards and edges are conflicts, each listed once, and edges lead from each step to all that it conflicts with.
        let conflicts = oracle::conflicts(&schedule);
        let mut listed = BTreeSet::new();
        for &(earlier, later, resource) in &schedule.edges {
            prop_assert!(listed.insert((earlier, later, resource)));
            prop_assert!(conflicts.contains(&(earlier as usize, later as usize, resource)));
        }
        let before = reachable(&schedule);
        for &(earlier, later, _) in &conflicts {
            prop_assert!(before[later].contains(&earlier), "{} -> {}", earlier, later);
        }
        for (i, step) in schedule.steps.iter().enumerate() {
            let mut listed = BTreeSet::new();
            for hazard in &step.hazards {
                prop_assert!(listed.insert((hazard.resource, hazard.after)));
                prop_assert!(conflicts.contains(&(hazard.after as usize, i, hazard.resource)));
                let does = |step: usize| {
                    let touches = oracle::touches(&schedule.steps[step]);
                    let home = |id: u32| schedule.resources[id as usize].home;
                    let here = touches.into_iter().filter(|touch| {
                        home(touch.0.0) == home(hazard.resource) && !touch.0.1
                    });
                    here.fold((false, false), |all, touch| (all.0 || touch.1, all.1 || touch.2))
                };
                let kind = match (does(hazard.after as usize), does(i)) {
                    ((_, true), (true, _)) => HazardKind::ReadAfterWrite,
                    ((_, true), (false, _)) => HazardKind::WriteAfterWrite,
                    ((_, false), _) => HazardKind::WriteAfterRead,
                };
                prop_assert_eq!(hazard.kind, kind);
            }
        }

        // Nothing is read before it is written.
        prop_assert!(!oracle::reads_unwritten(&schedule));
        // Memory is shared only by what is never in use together, and sharing saves what it says.
        prop_assert_eq!(oracle::collisions(&schedule), vec![]);
        let apart: u64 = schedule.resources.iter().map(|r| r.bytes * r.kind.allocations()).sum();
        prop_assert_eq!(schedule.bytes(true) + schedule.shared_bytes(), apart);

        // Zeroed resources, and only they, are cleared: once, and with nothing but clears between that and the first use.
        for (id, resource) in schedule.resources.iter().enumerate() {
            let clears = |i: &usize| matches!(schedule.steps[*i].action, Action::Clear(r) if r as usize == id);
            let touches =
                |i: &usize| oracle::touches(&schedule.steps[*i]).iter().any(|touch| touch.0.0 as usize == id);
            let steps = 0..schedule.steps.len();
            let cleared: Vec<_> = steps.clone().filter(clears).collect();
            let touched: Vec<_> = steps.filter(|i| touches(i) && !clears(i)).collect();
            match touched.first() {
                Some(&first) if resource.kind == Kind::Zeroed => {
                    prop_assert_eq!(cleared.len(), 1);
                    let between = &schedule.steps[cleared[0].min(first)..first];
                    prop_assert!(cleared[0] < first);
                    prop_assert!(between.iter().all(|step| matches!(step.action, Action::Clear(_))));
                }
                _ => prop_assert!(cleared.is_empty()),
            }
        }
    }

    #[test]
    fn sharing_memory_adds_no_barrier(
        resources in prop::collection::vec(any::<u8>(), 1..9),
        stages in prop::collection::vec((any::<u8>(), any::<[u8; 3]>()), 0..24),
        outputs in any::<u16>(),
    ) {
        let shared = record(&resources, &stages).compile(outputs).0;
        let mut apart = record(&resources, &stages);
        apart.graph.keep_transients();
        let apart = apart.compile(outputs).0;
        prop_assert_eq!(barriers(&shared), barriers(&apart));
        prop_assert_eq!(apart.shared_bytes(), 0);
    }

    #[test]
    fn compiling_is_reproducible(
        resources in prop::collection::vec(any::<u8>(), 1..9),
        stages in prop::collection::vec((any::<u8>(), any::<[u8; 3]>()), 0..24),
        outputs in any::<u16>(),
    ) {
        let first = record(&resources, &stages).compile(outputs).0;
        let second = record(&resources, &stages).compile(outputs).0;
        prop_assert_eq!(first.to_json().unwrap(), second.to_json().unwrap());
    }
}

/// `a` is written, read by two, and overwritten.
fn planted() -> Schedule {
    let mut g = Graph::new("planted");
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "first", &source, a);
    let b = pass_on(&mut g, "read", &a, b);
    let c = pass_on(&mut g, "read again", &a, c);
    let a = pass_on(&mut g, "second", &source, a);
    g.output("a", &a);
    g.output("b", &b);
    g.output("c", &c);
    g.compile(None).unwrap()
}

#[test]
fn the_oracle_finds_a_missing_barrier() {
    let schedule = planted();
    assert_eq!(barriers(&schedule), ".|.|");
    assert_eq!(oracle::unsettled(&schedule), []);
    let a = schedule.resource("a").unwrap();
    let without = |step: usize| {
        let mut schedule = planted();
        schedule.steps[step].hazards.clear();
        oracle::unsettled(&schedule)
    };
    assert_eq!(without(1), [(0, 1, a), (0, 2, a)]);
    assert_eq!(without(3), [(1, 3, a), (2, 3, a)]);
    assert_eq!(without(2), []);
}

/// `a` is dead when `c` is born.
fn chain() -> Schedule {
    let mut g = Graph::new("chain");
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "first", &source, a);
    let b = pass_on(&mut g, "second", &a, b);
    let c = pass_on(&mut g, "third", &b, c);
    let last = g.transient("last", LEN);
    let last = pass_on(&mut g, "fourth", &c, last);
    g.output("last", &last);
    g.compile(None).unwrap()
}

#[test]
fn transients_share_memory_in_turn() {
    let schedule = chain();
    let home = |key: &str| schedule.resources[schedule.resource(key).unwrap() as usize].home;
    assert_eq!(home("a"), home("c"));
    assert_ne!(home("a"), home("b"));
    assert_ne!(home("b"), home("last"), "an output is read after the frame");
    assert_eq!(schedule.shared_bytes(), 4 * LEN);
    assert_eq!(oracle::collisions(&schedule), []);
    // The third stage overwrites what the second one reads: a barrier that sharing makes necessary.
    let mut without = schedule.clone();
    without.steps[2].hazards.clear();
    assert!(!oracle::unsettled(&without).is_empty());
}

/// A large transient shares with one of about its size, smaller or larger, and with no other; small and very large ones with any.
#[test]
fn large_transients_share_with_their_like() {
    let shares = |first: u64, third: u64| {
        let mut g = Graph::new("sizes");
        let source = g.input("source", LEN);
        let lengths = [("a", first), ("b", LEN), ("c", third), ("last", LEN)];
        let [a, b, c, last] = lengths.map(|(name, len)| g.transient(name, len));
        let a = pass_on(&mut g, "first", &source, a);
        let b = pass_on(&mut g, "second", &a, b);
        let c = pass_on(&mut g, "third", &b, c);
        let last = pass_on(&mut g, "fourth", &c, last);
        g.output("last", &last);
        let schedule = g.compile(None).unwrap();
        assert_eq!(oracle::collisions(&schedule), []);
        let of = |key| &schedule.resources[schedule.resource(key).unwrap() as usize];
        of("c").home == of("a").home
    };
    let large = 1 << 20;
    assert!(
        shares(large, large)
            && shares(large, large + large / 4)
            && shares(large + large / 4, large)
    );
    assert!(!shares(large, large + large / 4 + 1) && !shares(2 * large, large));
    assert!(!shares(100, large) && shares(large, 100) && shares(100, 1000));
    // What is larger than caches takes what there is.
    assert!(shares(large, 8 * large) && shares(16 * large, 8 * large));
}

#[test]
fn the_oracle_finds_a_wrong_home() {
    let mut schedule = chain();
    let [a, b] = ["a", "b"].map(|key| schedule.resource(key).unwrap());
    schedule.resources[b as usize].home = schedule.resources[a as usize].home;
    assert!(oracle::collisions(&schedule).contains(&(a, b)));

    let mut schedule = chain();
    let home = schedule.resources[a as usize].home;
    schedule.resources[home as usize].room -= 4;
    assert!(!oracle::collisions(&schedule).is_empty(), "too small");

    let mut schedule = chain();
    let last = schedule.resource("last").unwrap();
    schedule.resources[last as usize].home = home;
    assert!(!oracle::collisions(&schedule).is_empty(), "an output");
}

#[test]
fn the_oracle_finds_a_wrong_order() {
    let mut schedule = chain();
    schedule.steps.swap(0, 1);
    assert!(!oracle::reads_unwritten(&chain()));
    assert!(oracle::reads_unwritten(&schedule));
}

#[test]
fn transients_that_are_kept_share_nothing() {
    let mut g = Graph::new("kept");
    g.keep_transients();
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "first", &source, a);
    let b = pass_on(&mut g, "second", &a, b);
    let c = pass_on(&mut g, "third", &b, c);
    g.output("c", &c);
    let schedule = g.compile(None).unwrap();
    assert_eq!(schedule.shared_bytes(), 0);
    assert!(
        (0..)
            .zip(&schedule.resources)
            .all(|(id, r)| r.home == id && r.room == r.bytes)
    );
}

#[test]
fn the_oracle_follows_traces_across_frames() {
    let stage = |reads: &[usize], reads_before: &[usize], writes: &[usize]| Recorded {
        label: String::new(),
        reads: reads.into(),
        reads_before: reads_before.into(),
        writes: writes.into(),
    };
    // Stage 0 reaches the output through two states against the order of the frame, stage 3 reaches nothing.
    let starts = [Start::Kept, Start::Rotated, Start::Anew, Start::Anew];
    let stages = [
        stage(&[0], &[], &[2]),
        stage(&[], &[1], &[0]),
        stage(&[], &[], &[1]),
        stage(&[2], &[], &[3]),
    ];
    assert_eq!(
        oracle::traces(&starts, &stages, &[2]),
        BTreeSet::from([0, 1, 2])
    );
    assert_eq!(
        oracle::traces(&starts, &stages, &[3]),
        BTreeSet::from([0, 1, 2, 3])
    );
    assert_eq!(oracle::traces(&starts, &stages, &[1]), BTreeSet::from([2]));
}
