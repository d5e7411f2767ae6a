//! The program, run as its users run it.
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder of one test's own, gone when the test is over.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gibs-cli-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// One that the program has made, gone likewise.
    pub fn at(path: &str) -> Self {
        Self(path.into())
    }

    pub fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    pub fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).unwrap();
        self.path(name)
    }

    pub fn read(&self, name: &str) -> String {
        let path = self.0.join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn gibs(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gibs"))
        .args(args)
        .output()
        .unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Standard output of a run that succeeds.
pub fn succeed(args: &[&str]) -> String {
    let output = gibs(args);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{args:?}: {}",
        stderr(&output)
    );
    stdout(&output)
}

pub fn json(args: &[&str]) -> Value {
    let text = succeed(args);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{args:?}: {error} in {text}"))
}

/// A run that must be refused as bad usage or bad input, with every one of `parts` in its message.
pub fn refused(args: &[&str], parts: &[&str]) {
    let output = gibs(args);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert_eq!(
        stdout(&output),
        "",
        "{args:?} prints results although it failed"
    );
    assert!(message.starts_with("error: "), "{args:?}: {message}");
    assert!(!message.contains("panicked"), "{args:?}: {message}");
    for part in parts {
        assert!(
            message.contains(part),
            "{args:?}: `{part}` is not in: {message}"
        );
    }
}

/// A small render of the Cornell box on the CPU.
pub fn render(out: &str, more: &[&str]) -> Output {
    let args = [
        "render",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "64x64",
        "--frames",
        "2",
        "--out",
        out,
    ];
    gibs(&[&args, more].concat())
}
