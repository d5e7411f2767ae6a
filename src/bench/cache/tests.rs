use super::*;
use crate::backends::{self, Choice};
use crate::builtin;
use glam::{DVec3, Vec3};

struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str) -> Self {
        let name = format!("gibs-truths-{name}-{}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&self.0).expect("the folder");
        entries.map(|e| e.expect("an entry").path()).collect()
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const OPTIONS: ReferenceOptions = ReferenceOptions {
    size: [8, 6],
    samples: 2,
    seed: 1,
    emitters: true,
};

#[test]
fn equal_content_has_one_key_and_any_change_another() {
    let backend = backends::open(Choice::Cpu).expect("cpu");
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let key = |scene: &Scene, view: &View, options: &ReferenceOptions| {
        Key::of(backend.as_ref(), scene, view, options).expect("a key")
    };
    let usual = key(&scene, &view, &OPTIONS);
    // Built anew, under another name, and shown brighter, it is the same.
    let (mut again, mut brighter) = builtin::by_name("cornell").expect("built in");
    again.name = "another".into();
    brighter.exposure *= 2.0;
    assert_eq!(key(&again, &brighter, &OPTIONS), usual);

    let mut keys = vec![usual.hash];
    let mut differs = |what: &str, key: Key| {
        assert!(!keys.contains(&key.hash), "{what} does not count");
        keys.push(key.hash);
    };
    let mut moved = view.clone();
    moved.camera.position += DVec3::new(1e-9, 0.0, 0.0);
    differs("the camera", key(&scene, &moved, &OPTIONS));
    let mut wider = view.clone();
    wider.camera.vfov *= 1.0 + 1e-12;
    differs("the angle", key(&scene, &wider, &OPTIONS));
    let mut sunny = view.clone();
    sunny.environment = gibs_passes::scene::Environment::Constant(Vec3::splat(0.5));
    differs("the sky", key(&scene, &sunny, &OPTIONS));
    let mut painted = scene.clone();
    painted.materials[0].base_color.x *= 0.99;
    differs("a colour", key(&painted, &view, &OPTIONS));
    let mut bent = scene.clone();
    bent.meshes[0].positions[0].x += 1e-3;
    differs("a vertex", key(&bent, &view, &OPTIONS));
    for (what, options) in [
        (
            "the size",
            ReferenceOptions {
                size: [6, 8],
                ..OPTIONS
            },
        ),
        (
            "the samples",
            ReferenceOptions {
                samples: 3,
                ..OPTIONS
            },
        ),
        ("the seed", ReferenceOptions { seed: 2, ..OPTIONS }),
        (
            "emitter samples",
            ReferenceOptions {
                emitters: false,
                ..OPTIONS
            },
        ),
    ] {
        differs(what, key(&scene, &view, &options));
    }
}

#[test]
fn what_is_there_is_found_and_what_is_broken_is_replaced() {
    let folder = Temporary::new("broken");
    let cache = TruthCache::new(&folder.0);
    let backend = backends::open(Choice::Cpu).expect("cpu");
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let get = || {
        let done = cache.reference(backend.as_ref(), &scene, &view, &OPTIONS, |_, _| {});
        done.expect("a reference")
    };
    let first = get();
    assert!(
        !first.found && first.warning.is_none(),
        "{:?}",
        first.warning
    );
    let files = folder.files();
    let [file] = files.as_slice() else {
        panic!("one file, and nothing temporary: {files:?}");
    };
    let second = get();
    assert!(second.found && second.picture == first.picture);

    let whole = std::fs::read(file).expect("the file");
    let mut flipped = whole.clone();
    let last = flipped.len() - 20;
    flipped[last] ^= 4;
    let mut foreign = Picture::new(8, 6);
    foreign.set_scalar("E.R", vec![1.0; 48]).expect("a channel");
    let other = folder.0.join("other.exr");
    foreign.write_exr(&other).expect("written");
    let other = std::fs::read(other).expect("read");
    for broken in [
        &whole[..whole.len() / 2],
        &whole[..0],
        b"not a picture",
        &flipped,
        &other,
    ] {
        std::fs::write(file, broken).expect("written");
        let anew = get();
        let warning = anew.warning.expect("a warning");
        assert!(
            !anew.found && warning.contains("rendered anew"),
            "{warning}"
        );
        assert!(anew.picture == first.picture);
        assert!(get().found, "what replaces it is whole");
    }

    // Reading a pipe would wait for somebody to write.
    std::fs::remove_file(file).expect("removed");
    let made = std::process::Command::new("mkfifo").arg(file).status();
    assert!(made.expect("mkfifo").success());
    let warning = get().warning.expect("a warning");
    assert!(warning.contains("not a plain file"), "{warning}");
    assert_eq!(warning.matches(".exr").count(), 1, "{warning}");
}

#[test]
fn a_folder_that_takes_nothing_is_a_warning() {
    let folder = Temporary::new("file");
    std::fs::write(&folder.0, "a file").expect("written");
    let backend = backends::open(Choice::Cpu).expect("cpu");
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let cache = TruthCache::new(&folder.0);
    let done = cache.reference(backend.as_ref(), &scene, &view, &OPTIONS, |_, _| {});
    let warning = done.expect("a reference").warning.expect("a warning");
    assert!(warning.contains("--no-cache"), "{warning}");
    let _ = std::fs::remove_file(&folder.0);
}
