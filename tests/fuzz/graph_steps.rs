//! Stages that pass something from one pool of buffers to another.
use crate::graph_pool::Pool;
use crate::graph_stages::*;
use gibs_graph::glam::Vec4;
use gibs_graph::{Dispatch, DispatchArgs, Graph};

pub fn raise(
    g: &mut Graph,
    label: &str,
    [a, b, ..]: [u8; 4],
    words: &Pool<u32>,
    waves: &mut Pool<Vec4>,
) {
    let (Some(from), Some(to)) = (words.source(a, &[]), waves.target(b, &[])) else {
        return;
    };
    let target = waves.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<raise::Raise>(
        label,
        raise::Inputs {
            source: words.read(from),
            waves: target,
        },
        len,
    );
    waves.put(to, made.waves);
}

pub fn turn(g: &mut Graph, label: &str, [a, b, ..]: [u8; 4], waves: &mut Pool<Vec4>) {
    let Some(to) = waves.target(b, &[]) else {
        return;
    };
    let Some(from) = waves.source(a, &[to]) else {
        return;
    };
    let target = waves.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<turn::Turn>(
        label,
        turn::Inputs {
            waves: waves.read(from),
            turned: target,
        },
        len,
    );
    waves.put(to, made.turned);
}

pub fn lower(
    g: &mut Graph,
    label: &str,
    [a, b, ..]: [u8; 4],
    words: &mut Pool<u32>,
    waves: &Pool<Vec4>,
) {
    let (Some(from), Some(to)) = (waves.source(a, &[]), words.changed(b, &[])) else {
        return;
    };
    let target = words.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<lower::Lower>(
        label,
        lower::Inputs {
            waves: waves.read(from),
            target_: target,
        },
        len,
    );
    words.put(to, made.target_);
}

pub fn pack(
    g: &mut Graph,
    label: &str,
    [a, b, ..]: [u8; 4],
    words: &Pool<u32>,
    rows: &mut Pool<Row>,
) {
    let (Some(from), Some(to)) = (words.source(a, &[]), rows.target(b, &[])) else {
        return;
    };
    let target = rows.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<pack::Pack>(
        label,
        pack::Inputs {
            source: words.read(from),
            rows: target,
        },
        len,
    );
    rows.put(to, made.rows);
}

pub fn unpack(
    g: &mut Graph,
    label: &str,
    [a, b, ..]: [u8; 4],
    words: &mut Pool<u32>,
    rows: &Pool<Row>,
) {
    let (Some(from), Some(to)) = (rows.source(a, &[]), words.target(b, &[])) else {
        return;
    };
    let target = words.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<unpack::Unpack>(
        label,
        unpack::Inputs {
            rows: rows.read(from),
            target_: target,
        },
        len,
    );
    words.put(to, made.target_);
}

pub fn plan(
    g: &mut Graph,
    label: &str,
    [a, ..]: [u8; 4],
    words: &Pool<u32>,
    args: &mut Pool<DispatchArgs>,
) {
    let (Some(from), Some(to)) = (words.source(a, &[]), args.target(0, &[])) else {
        return;
    };
    let target = args.take(to);
    let len = Dispatch::Elements(target.len());
    let made = g.add::<plan::Plan>(
        label,
        plan::Inputs {
            source: words.read(from),
            args: target,
        },
        len,
    );
    args.put(to, made.args);
}

pub fn mark(
    g: &mut Graph,
    label: &str,
    [a, ..]: [u8; 4],
    words: &mut Pool<u32>,
    args: &Pool<DispatchArgs>,
) {
    let (Some(sizes), Some(to)) = (args.source(0, &[]), words.changed(a, &[])) else {
        return;
    };
    let marks = words.take(to);
    let inputs = mark::Inputs {
        args: args.read(sizes),
        marks,
    };
    let made = g.add::<mark::Mark>(label, inputs, Dispatch::Indirect(args.read(sizes)));
    words.put(to, made.marks);
}
