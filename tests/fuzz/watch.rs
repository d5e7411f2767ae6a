//! How many cases run, and what is watched while one does: memory and time.
use proptest::test_runner::{Config, RngSeed};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// A configuration for so many cases. `GIBS_FUZZ_CASES=N` makes it N times as many, and those random; without it, the cases
/// are the same in every run, so that a change fails by what it does and not by chance.
pub fn cases(usual: u32) -> Config {
    let times = std::env::var("GIBS_FUZZ_CASES").ok();
    let times = times.map(|n| n.parse::<u32>().expect("GIBS_FUZZ_CASES is a number"));
    Config {
        cases: usual * times.unwrap_or(1).max(1),
        failure_persistence: None,
        max_shrink_iters: 4000,
        max_global_rejects: 1 << 20,
        rng_seed: match times {
            None => RngSeed::Fixed(0x6762_6973),
            Some(_) => RngSeed::Random,
        },
        ..Config::default()
    }
}

/// The largest single allocation that small input may lead to.
const MOST_BYTES: usize = 1 << 30;

/// The longest that a case may take. Far above what is usual, since test machines are shared.
const MOST_TIME: Duration = Duration::from_secs(30);

/// Notes the largest allocation since it was last asked.
struct Watched;

static LARGEST: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: Watched = Watched;

// SAFETY: everything goes to the system's allocator as it comes.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.fetch_max(size, Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(at, layout) }
    }
}

/// Start of the case that runs, in milliseconds since the first one, and 1 more; 0 for none.
static STARTED: AtomicU64 = AtomicU64::new(0);

/// What the case is doing, in words.
static ABOUT: Mutex<String> = Mutex::new(String::new());

/// Says what the case does next, for the message about one that does not end.
pub fn about(what: impl Into<String>) {
    *ABOUT.lock().unwrap_or_else(PoisonError::into_inner) = what.into();
}

/// Runs a case alone in this process, and fails where it asked for more memory than it may. One that does not end
/// cannot fail; it ends the process, and its file is left in the folder for temporary files.
pub fn watched<R>(case: impl FnOnce() -> R) -> R {
    static ALONE: Mutex<()> = Mutex::new(());
    static WATCH: Once = Once::new();
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let epoch = epoch();
    WATCH.call_once(|| drop(std::thread::spawn(watch)));
    STARTED.store(epoch.elapsed().as_millis() as u64 + 1, Relaxed);
    LARGEST.store(0, Relaxed);
    about(std::thread::current().name().unwrap_or_default());
    let done = Done;
    let result = case();
    drop(done);
    let largest = LARGEST.load(Relaxed);
    assert!(
        largest <= MOST_BYTES,
        "it asked for {largest} bytes at once"
    );
    result
}

/// Says that no case runs any more, also where it panicked.
struct Done;

impl Drop for Done {
    fn drop(&mut self) {
        STARTED.store(0, Relaxed);
    }
}

fn epoch() -> Instant {
    static EPOCH: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    *EPOCH.get_or_init(Instant::now)
}

fn watch() {
    loop {
        std::thread::sleep(Duration::from_secs(1));
        let started = STARTED.load(Relaxed);
        let now = epoch().elapsed().as_millis() as u64 + 1;
        if started > 0 && Duration::from_millis(now.saturating_sub(started)) > MOST_TIME {
            let about = ABOUT.lock().unwrap_or_else(PoisonError::into_inner);
            eprintln!(
                "a case of tests/fuzz does not end: {about}; its file, if it has one, is in the folder for temporary files"
            );
            std::process::abort();
        }
    }
}

/// The watch itself works: what is too large is found, what panics frees the way for the next case.
#[test]
fn an_allocation_that_is_too_large_is_found() {
    let huge = || watched(|| drop(Vec::<u8>::with_capacity(MOST_BYTES + 1)));
    let message = std::panic::catch_unwind(huge).expect_err("it is too large");
    let message = message.downcast_ref::<String>().expect("a message");
    assert!(message.contains("bytes at once"), "{message}");
    watched(|| drop(Vec::<u8>::with_capacity(MOST_BYTES / 2)));
}
