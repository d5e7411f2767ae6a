//! Time to the first frame: processes that begin with empty caches of compiled shaders, then with filled ones.
use gibs::backends::Choice;
use serde::Deserialize;
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Where drivers and the program keep compiled shaders: Mesa, NVIDIA's driver, and gibs itself.
const CACHES: [&str; 3] = [
    "MESA_SHADER_CACHE_DIR",
    "__GL_SHADER_DISK_CACHE_PATH",
    "XDG_CACHE_HOME",
];

/// Times to first frame of a backend, seconds from the start of the process, a value per repeat.
#[derive(Default)]
pub struct Starts {
    /// With empty caches.
    pub cold: Vec<f64>,
    /// With the caches that the cold process left behind.
    pub warm: Vec<f64>,
}

/// What `gibs render --json` says, as far as it matters here.
#[derive(Deserialize)]
struct Summary {
    seconds_to_first_frame: f64,
}

/// A folder that goes away again.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // It lies in the system's folder for such things; leaving it is no failure.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The program that was built together with this one.
///
/// # Errors
/// It is not there.
pub fn program() -> Result<PathBuf, Box<dyn Error>> {
    let name = format!("gibs{}", std::env::consts::EXE_SUFFIX);
    let own = std::env::current_exe()?;
    // Examples lie in a folder beside the program.
    let mut places = own
        .ancestors()
        .skip(1)
        .take(2)
        .map(|folder| folder.join(&name));
    places
        .find(|path| path.is_file())
        .ok_or_else(|| "gibs is not built: run `cargo build --release`, or give --program".into())
}

/// Seconds that the program takes to do nothing: the median of five times.
///
/// # Errors
/// It cannot be run.
pub fn process(program: &Path) -> Result<f64, Box<dyn Error>> {
    let mut seconds = Vec::new();
    for _ in 0..5 {
        let start = Instant::now();
        let done = Command::new(program).arg("--version").output();
        done.map_err(|error| {
            format!(
                "cannot run {}: {error}; give another --program",
                program.display()
            )
        })?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(super::median(&seconds))
}

/// Runs the program with these arguments once cold and once warm for each backend and repeat; backends take turns.
/// `process` is what starting the process takes, which the program itself cannot see.
///
/// # Errors
/// Why a process failed.
pub fn measure(
    program: &Path,
    arguments: &[OsString],
    backends: &[Choice],
    repeats: u32,
    process: f64,
) -> Result<Vec<Starts>, Box<dyn Error>> {
    let folder =
        Folder(std::env::temp_dir().join(format!("gibs-backends-speed-{}", std::process::id())));
    let mut all: Vec<Starts> = backends.iter().map(|_| Starts::default()).collect();
    for repeat in 0..repeats as usize {
        for turn in 0..all.len() {
            let i = (turn + repeat) % all.len();
            let caches = folder.0.join(format!("{repeat}-{i}"));
            fs::create_dir_all(&caches)
                .map_err(|e| format!("cannot make {}: {e}; set TMPDIR", caches.display()))?;
            all[i]
                .cold
                .push(process + render(program, arguments, backends[i], &caches)?);
            all[i]
                .warm
                .push(process + render(program, arguments, backends[i], &caches)?);
        }
    }
    Ok(all)
}

/// Seconds that a process needs for its first frame, with all caches in a folder.
fn render(
    program: &Path,
    arguments: &[OsString],
    backend: Choice,
    caches: &Path,
) -> Result<f64, Box<dyn Error>> {
    let mut command = Command::new(program);
    command.arg("render").args(arguments).args([
        "--frames",
        "1",
        "--json",
        "--backend",
        &backend.to_string(),
    ]);
    command.arg("--out").arg(caches.join("picture.exr"));
    command
        .env_remove("MESA_SHADER_CACHE_DISABLE")
        .envs(CACHES.map(|name| (name, caches)));
    let output = command.output()?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let error = text
            .lines()
            .rfind(|line| line.starts_with("error"))
            .unwrap_or("it did not say why");
        return Err(format!("{} on {backend}: {error}", program.display()).into());
    }
    let summary: Summary = serde_json::from_slice(&output.stdout)?;
    Ok(summary.seconds_to_first_frame)
}
