//! Ways to break a sound input: its JSON, or its bytes.
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Map, Value, json};

/// A change of a JSON document at one of its values.
#[derive(Clone, Debug)]
pub enum JsonEdit {
    /// Another value.
    Set(Index, Value),
    /// The value of another place.
    Copy(Index, Index),
    /// The entry goes.
    Remove(Index),
    /// A list's last element comes so many times more; another value becomes a list of itself.
    Repeat(Index, u8),
    /// An object gets a key that it does not know.
    Add(Index, Value),
}

/// Numbers at which sizes, offsets and conversions break, and small ones.
fn number() -> impl Strategy<Value = Value> {
    let edges = vec![
        json!(0),
        json!(-1),
        json!(255),
        json!(256),
        json!(65_535),
        json!(65_536),
        json!(i32::MAX),
        json!(i32::MIN),
        json!(u32::MAX),
        json!(1_u64 << 32),
        json!(i64::MAX),
        json!(i64::MIN),
        json!(u64::MAX),
        json!(-0.0),
        json!(0.5),
        json!(1e-45),
        json!(5e-324),
        json!(3.4e38),
        json!(3.5e38),
        json!(-1e39),
        json!(1e15),
        json!(1e308),
        json!(5120),
        json!(5121),
        json!(5123),
        json!(5125),
        json!(5126),
    ];
    prop_oneof![
        3 => select(edges),
        3 => (0_u32..12).prop_map(|n| json!(n)),
        1 => (-2.0_f64..2.0).prop_map(|x| json!(x)),
        1 => any::<i64>().prop_map(|n| json!(n)),
    ]
}

fn value() -> impl Strategy<Value = Value> {
    let others = vec![
        json!(null),
        json!(true),
        json!([]),
        json!({}),
        json!(""),
        json!("\u{0}"),
        json!("../.."),
        json!("/"),
        json!("data:,"),
        json!("data:;base64,AAAA"),
        json!("SCALAR"),
        json!("VEC2"),
        json!("VEC3"),
        json!("VEC4"),
        json!("MAT2"),
        json!("MAT4"),
        json!("LINEAR"),
        json!("STEP"),
        json!("CUBICSPLINE"),
        json!("scale"),
        json!("weights"),
        json!("BLEND"),
        json!("MASK"),
        json!("spot"),
        json!("orthographic"),
        json!([[[[]]]]),
        json!("x".repeat(5000)),
        json!([0, 0, 0]),
        json!([1e30, -1e30, 0]),
        json!([0, 0, 0, 0]),
    ];
    prop_oneof![4 => number(), 1 => select(others)]
}

pub fn json_edits() -> impl Strategy<Value = Vec<JsonEdit>> {
    let edit = prop_oneof![
        6 => (any::<Index>(), value()).prop_map(|(at, value)| JsonEdit::Set(at, value)),
        2 => (any::<Index>(), any::<Index>()).prop_map(|(at, from)| JsonEdit::Copy(at, from)),
        2 => any::<Index>().prop_map(JsonEdit::Remove),
        1 => (any::<Index>(), any::<u8>()).prop_map(|(at, n)| JsonEdit::Repeat(at, n)),
        1 => (any::<Index>(), value()).prop_map(|(at, value)| JsonEdit::Add(at, value)),
    ];
    vec(edit, 1..4)
}

/// JSON pointers of all values.
fn places(value: &Value, path: &str, out: &mut Vec<String>) {
    out.push(path.to_owned());
    match value {
        Value::Array(list) => (list.iter().enumerate())
            .for_each(|(i, value)| places(value, &format!("{path}/{i}"), out)),
        Value::Object(map) => map.iter().for_each(|(key, value)| {
            let key = key.replace('~', "~0").replace('/', "~1");
            places(value, &format!("{path}/{key}"), out);
        }),
        _ => {}
    }
}

/// Breaks a document.
pub fn edit_json(document: &mut Value, edits: &[JsonEdit]) {
    for edit in edits {
        let mut all = Vec::new();
        places(document, "", &mut all);
        let place = |at: &Index| at.get(&all).clone();
        match edit {
            JsonEdit::Set(at, value) => set(document, &place(at), value.clone()),
            JsonEdit::Copy(at, from) => {
                let value = document.pointer(&place(from)).cloned().unwrap_or_default();
                set(document, &place(at), value);
            }
            JsonEdit::Remove(at) => remove(document, &place(at)),
            JsonEdit::Repeat(at, n) => {
                let Some(found) = document.pointer_mut(&place(at)) else {
                    continue;
                };
                match found {
                    Value::Array(list) => {
                        let last = list.last().cloned().unwrap_or_default();
                        list.extend(std::iter::repeat_n(last, usize::from(*n)));
                    }
                    other => *other = json!([other.clone(), other.clone()]),
                }
            }
            JsonEdit::Add(at, value) => {
                let Some(found) = document.pointer_mut(&place(at)) else {
                    continue;
                };
                match found {
                    Value::Object(map) => drop(map.insert("added".into(), value.clone())),
                    other => {
                        *other = Value::Object(Map::from_iter([("added".into(), value.clone())]))
                    }
                }
            }
        }
    }
}

fn set(document: &mut Value, place: &str, value: Value) {
    if let Some(found) = document.pointer_mut(place) {
        *found = value;
    }
}

fn remove(document: &mut Value, place: &str) {
    let Some((parent, key)) = place.rsplit_once('/') else {
        return;
    };
    match document.pointer_mut(parent) {
        Some(Value::Object(map)) => drop(map.remove(&key.replace("~1", "/").replace("~0", "~"))),
        Some(Value::Array(list)) => {
            if let Some(i) = key.parse().ok().filter(|&i: &usize| i < list.len()) {
                list.remove(i);
            }
        }
        _ => {}
    }
}

/// A change of bytes.
#[derive(Clone, Debug)]
pub enum ByteEdit {
    /// One bit.
    Flip(Index, u8),
    /// One byte.
    Set(Index, u8),
    /// Four bytes.
    Word(Index, u32),
    /// The end goes.
    Cut(Index),
    /// Some bytes go.
    Remove(Index, u8),
    /// Some bytes come.
    Insert(Index, Vec<u8>),
    /// Bytes of another place come over these.
    Copy(Index, Index, u8),
}

pub fn byte_edits() -> impl Strategy<Value = Vec<ByteEdit>> {
    let words = vec![
        0,
        1,
        0x7fff_ffff,
        0x8000_0000,
        u32::MAX,
        0x7f80_0000,
        0x7fc0_0000,
        0x0100_0000,
        0xffff,
    ];
    let edit = prop_oneof![
        4 => (any::<Index>(), 0_u8..8).prop_map(|(at, bit)| ByteEdit::Flip(at, bit)),
        2 => (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| ByteEdit::Set(at, byte)),
        2 => (any::<Index>(), select(words)).prop_map(|(at, word)| ByteEdit::Word(at, word)),
        1 => any::<Index>().prop_map(ByteEdit::Cut),
        1 => (any::<Index>(), any::<u8>()).prop_map(|(at, n)| ByteEdit::Remove(at, n)),
        1 => (any::<Index>(), vec(any::<u8>(), 1..9)).prop_map(|(at, bytes)| ByteEdit::Insert(at, bytes)),
        1 => (any::<Index>(), any::<Index>(), any::<u8>()).prop_map(|(at, from, n)| ByteEdit::Copy(at, from, n)),
    ];
    vec(edit, 1..6)
}

/// Breaks bytes.
pub fn edit_bytes(bytes: &mut Vec<u8>, edits: &[ByteEdit]) {
    for edit in edits {
        if bytes.is_empty() {
            return;
        }
        let len = bytes.len();
        match edit {
            ByteEdit::Flip(at, bit) => bytes[at.index(len)] ^= 1 << bit,
            ByteEdit::Set(at, byte) => bytes[at.index(len)] = *byte,
            ByteEdit::Word(at, word) => {
                let at = at.index(len);
                for (byte, new) in bytes[at..].iter_mut().zip(word.to_le_bytes()) {
                    *byte = new;
                }
            }
            ByteEdit::Cut(at) => bytes.truncate(at.index(len)),
            ByteEdit::Remove(at, n) => {
                let at = at.index(len);
                bytes.drain(at..(at + usize::from(*n)).min(len));
            }
            ByteEdit::Insert(at, new) => {
                let at = at.index(len);
                bytes.splice(at..at, new.iter().copied());
            }
            ByteEdit::Copy(at, from, n) => {
                let (at, from) = (at.index(len), from.index(len));
                let n = usize::from(*n).min(len - at).min(len - from);
                bytes.copy_within(from..from + n, at);
            }
        }
    }
}

/// The edits do what they say; a document stays JSON whatever happens to it.
#[test]
fn edits_change_documents_and_bytes() {
    let whole = json!({"a": [1, {"b/c": 2}], "d": null});
    let mut found = Vec::new();
    places(&whole, "", &mut found);
    assert_eq!(found, ["", "/a", "/a/0", "/a/1", "/a/1/b~1c", "/d"]);
    let mut broken = whole.clone();
    remove(&mut broken, "/a/1/b~1c");
    remove(&mut broken, "/a/0");
    set(&mut broken, "/d", json!(3));
    assert_eq!(broken, json!({"a": [{}], "d": 3}));
    let mut bytes = vec![0; 8];
    edit_bytes(&mut bytes, &[ByteEdit::Word(anywhere(), 0x0101_0101)]);
    assert!(bytes.contains(&1));
    edit_bytes(
        &mut bytes,
        &[
            ByteEdit::Insert(anywhere(), vec![7; 3]),
            ByteEdit::Flip(anywhere(), 0),
        ],
    );
    assert_eq!(bytes.len(), 11);
    edit_bytes(&mut bytes, &[ByteEdit::Cut(anywhere())]);
    assert!(bytes.len() < 11);
}

/// Some index.
fn anywhere() -> Index {
    let tree = any::<Index>().new_tree(&mut TestRunner::deterministic());
    tree.expect("an index").current()
}
