//! The reader of captures: broken archives, broken members, broken descriptions.
use crate::archive::{Members, data, pack, shared, unpack, with_header};
use crate::edits::{byte_edits, edit_bytes, edit_json, json_edits};
use crate::file::Folder;
use crate::replays::run;
use crate::watch::{cases, watched};
use gibs::builtin;
use gibs::check::{Capture, Participant, Plan, record};
use gibs_backend_cpu::{CpuBackend, Options};
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// The scalar kernels.
pub fn scalar() -> CpuBackend {
    let options = Options {
        scalar: true,
        ..Options::default()
    };
    CpuBackend::new(options).expect("threads start")
}

/// One capture of every stage that small frames run.
pub fn captures() -> &'static [Capture] {
    static CAPTURES: OnceLock<Vec<Capture>> = OnceLock::new();
    CAPTURES.get_or_init(|| {
        let scene = builtin::by_name("cornell").expect("built in");
        let plan = Plan {
            size: [12, 8],
            frames: vec![0, 1],
            surfels: 64,
            rays: 64,
            all: true,
        };
        let oracle = scalar();
        let mut cases = gibs::check::cases(&[("cornell", &scene)], &plan, &oracle).expect("frames");
        let (mut seen, mut captures) = (BTreeSet::new(), Vec::new());
        for case in &mut cases {
            let frame = *case.frames.last().expect("it has frames");
            let wanted =
                |_: &str, dispatch: &gibs::graph::DispatchStep| seen.insert(dispatch.stage);
            let made = record(
                case,
                Participant::named("cpu-scalar", &oracle),
                frame,
                wanted,
            );
            captures.extend(made.expect("it runs"));
        }
        captures
    })
}

/// The file of each capture.
fn files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| {
        let folder = Folder::new();
        let file = folder.0.join("capture.npz");
        let write = |capture: &Capture| {
            capture.write(&file).expect("written");
            std::fs::read(&file).expect("it is there")
        };
        captures().iter().map(write).collect()
    })
}

/// Reads a file; what is read is run, what is refused is refused by name.
fn read(bytes: &[u8]) -> Result<Capture, String> {
    let folder = Folder::new();
    let path = folder.write("broken.npz", bytes);
    match Capture::read(&path) {
        Ok(capture) => {
            run(&capture);
            Ok(capture)
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains("broken.npz"), "{text}");
            Err(text)
        }
    }
}

fn member<'a>(members: &'a mut Members, name: &str) -> &'a mut Vec<u8> {
    let found = members.iter_mut().find(|(found, _)| found == name);
    &mut found.unwrap_or_else(|| panic!("no {name}")).1
}

/// The archive with another description.
fn described(mut members: Members, change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let json = member(&mut members, "capture.json");
    let mut root: Value = serde_json::from_slice(json).expect("it is JSON");
    change(&mut root);
    *json = root.to_string().into_bytes();
    pack(&members)
}

/// The members of a capture of this stage.
fn members_of(stage: &str) -> Members {
    let found = captures().iter().position(|capture| capture.stage == stage);
    unpack(&files()[found.expect("some frame runs it")])
}

#[test]
fn every_whole_capture_is_read_and_run() {
    assert!(captures().len() > 30, "{} stages", captures().len());
    for (capture, file) in captures().iter().zip(files()) {
        assert_eq!(&read(file).expect("it is sound"), capture);
        assert_eq!(&read(&pack(&unpack(file))).expect("it is sound"), capture);
    }
}

proptest! {
    #![proptest_config(cases(600))]

    #[test]
    fn a_damaged_archive_is_read_or_refused(which: Index, edits in byte_edits()) {
        let mut bytes = which.get::<Vec<u8>>(files()).clone();
        edit_bytes(&mut bytes, &edits);
        watched(|| drop(read(&bytes)));
    }

    #[test]
    fn a_broken_description_is_read_or_refused(which: Index, edits in json_edits()) {
        let bytes = described(unpack(which.get::<Vec<u8>>(files())), |root| edit_json(root, &edits));
        watched(|| drop(read(&bytes)));
    }

    #[test]
    fn a_damaged_member_is_read_or_refused(which: Index, at: Index, edits in byte_edits(), head: bool) {
        let mut members = unpack(which.get::<Vec<u8>>(files()));
        let at = at.index(members.len());
        let content = &mut members[at].1;
        if head {
            // Most of a member is data, of which any is sound; this aims at the header.
            let mut start = content[..content.len().min(128)].to_vec();
            let rest = content.split_off(start.len());
            edit_bytes(&mut start, &edits);
            *content = [start, rest].concat();
        } else {
            edit_bytes(content, &edits);
        }
        let bytes = pack(&members);
        watched(|| drop(read(&bytes)));
    }

    #[test]
    fn exchanged_members_are_read_or_refused(which: Index, other: Index, from: Index, to: Index) {
        let mut members = unpack(which.get::<Vec<u8>>(files()));
        let others = unpack(other.get::<Vec<u8>>(files()));
        let to = to.index(members.len());
        members[to].1 = from.get(&others).1.clone();
        let bytes = pack(&members);
        watched(|| drop(read(&bytes)));
    }
}

/// A parser of Python's literals reads headers. It recurses, and it tries some alternatives again and again.
#[test]
fn a_header_of_nested_brackets_is_refused() {
    let sound = members_of("Integrate");
    let array = sound
        .iter()
        .position(|(name, _)| name.starts_with("before/"))
        .expect("an input");
    for text in [
        "(".repeat(60_000),
        "[".repeat(60_000),
        "{".repeat(40),
        format!("{}{}", "[".repeat(40), "]".repeat(40)),
    ] {
        let mut members = sound.clone();
        members[array].1 = with_header(&text, data(&sound[array].1));
        let refused = watched(|| read(&pack(&members))).expect_err("no header");
        assert!(refused.contains("header"), "{refused}");
    }
}

/// Version 2 of the format has 32 bits for the length of a header.
#[test]
fn a_header_that_says_that_it_is_4_gib_long_is_refused() {
    let mut members = members_of("Integrate");
    let (_, npy) = members
        .iter_mut()
        .find(|(name, _)| name.starts_with("before/"))
        .expect("an input");
    npy.splice(6..10, [2, 0, 0xff, 0xff, 0xff, 0xff]);
    let refused = watched(|| read(&pack(&members))).expect_err("no header");
    assert!(refused.contains("header"), "{refused}");
}

/// On the CPU, the two would be a slice and a place that is written, of one memory.
#[test]
fn a_buffer_that_is_read_and_written_through_two_ports_is_refused() {
    let bytes = described(members_of("ScanBlocks"), |root| {
        let written = root["results"][0]["buffers"][0].clone();
        for binding in root["bindings"].as_array_mut().expect("a list") {
            binding["buffer"] = written.clone();
        }
    });
    read(&bytes).expect_err("one buffer has two roles");
}

#[test]
fn a_port_that_is_bound_twice_is_refused() {
    let bytes = described(members_of("Integrate"), |root| {
        let bindings = root["bindings"].as_array_mut().expect("a list");
        bindings.push(bindings[0].clone());
    });
    read(&bytes).expect_err("a port has one buffer");
}

#[test]
fn a_dispatch_that_takes_its_size_from_too_small_a_buffer_is_refused() {
    let bytes = described(members_of("Integrate"), |root| {
        let buffers = root["buffers"].as_array_mut().expect("a list");
        let id = buffers.len();
        buffers.push(json!({"key": "tiny", "element": {"Scalar": "U32"}, "len": 1, "image": null}));
        root["size"] = json!({"indirect": id});
    });
    let mut members = unpack(&bytes);
    members.push((
        "before/tiny.npy".into(),
        with_header(
            "{'descr': '<u4', 'fortran_order': False, 'shape': (1,), }\n",
            &[1, 0, 0, 0],
        ),
    ));
    read(&pack(&members)).expect_err("four bytes are no sizes");
}

/// The product of counts and strides does not fit into 32 bits.
#[test]
fn an_element_of_four_gibibytes_is_refused() {
    let bytes = described(members_of("Integrate"), |root| {
        let inner = json!({"Array": {"element": {"Scalar": "U32"}, "count": 65536, "stride": 4}});
        root["buffers"][0]["element"] =
            json!({"Array": {"element": inner, "count": 65536, "stride": 65536 * 4}});
    });
    let refused = read(&bytes).expect_err("no buffer has such elements");
    assert!(refused.contains("impossible type"), "{refused}");
}

/// Every buffer and every result is read into memory, so a description that names one again and again costs any amount.
#[test]
fn a_description_that_names_one_member_twice_is_refused() {
    let again = |list: &'static str| {
        described(members_of("Integrate"), |root| {
            let list = root[list].as_array_mut().expect("a list");
            list.push(list[0].clone());
        })
    };
    for list in ["buffers", "results"] {
        let refused = read(&again(list)).expect_err("twice is too often");
        assert!(refused.contains("twice"), "{refused}");
    }
    let bytes = described(members_of("Integrate"), |root| {
        let buffers = root["results"][0]["buffers"]
            .as_array_mut()
            .expect("a list");
        buffers.push(buffers[0].clone());
    });
    read(&bytes).expect_err("a result has a buffer once");
}

/// Two names for one place in the archive: what is unpacked would be any multiple of the file.
#[test]
fn an_archive_whose_members_share_bytes_is_refused() {
    let bytes = shared(&members_of("Integrate"));
    let refused = read(&bytes).expect_err("two members are one");
    assert!(refused.contains("same place"), "{refused}");
}

/// The layout of their triangles once lacked a field, so that such a file could be written and not read.
#[test]
fn captures_of_tracing_are_read_from_their_files() {
    for stage in ["TraceClosest", "TraceAny"] {
        let capture = read(&pack(&members_of(stage))).expect("it is sound");
        let packets = capture
            .buffers
            .iter()
            .find(|b| b.key == "scene_wide_packets");
        assert_eq!(packets.map(|b| b.element.size()), Some(320));
    }
}
