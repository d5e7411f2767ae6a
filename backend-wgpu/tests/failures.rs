//! A device that goes away is an error, never the end of the process.
mod common;
mod stages;

use common::{doubling, engine, read, upload};
use gibs_graph::{Backend, BackendError};

/// The device is the engine's, and so is hearing of its loss; whoever waits for a result is told all the same.
#[test]
fn a_lost_device_of_an_engine_gives_no_results() {
    let Some(engine) = engine() else { return };
    let mut run = engine.backend.prepare(doubling(100)).unwrap();
    upload(&mut *run, "numbers", &[1; 100]);
    run.run().unwrap();
    assert_eq!(read(&mut *run, "doubled"), [2; 100]);
    engine.device.destroy();
    let id = run.schedule().resource("numbers").unwrap();
    let _ = run.upload(id, 0, &[0; 400]);
    let _ = run.run();
    match run.read(id) {
        Err(BackendError::Device { .. }) => {}
        other => panic!("{other:?}"),
    }
}
