//! The page that `gibs bench` writes, in a browser.
use crate::bench::FEW;
use crate::program::*;
use std::process::Command;

/// Opens the page in a browser without a window, where there is one.
#[test]
fn browsers_have_nothing_to_complain_about() {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&paths)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.is_file());
    let Some(browser) = found else {
        eprintln!("not run: there is no {}", names.join(", "));
        return;
    };
    let folder = Folder::new("browser");
    let (report, picture) = (folder.path("report"), folder.path("page.png"));
    let more = [
        "--elements",
        "depth",
        "--seeds",
        "2",
        "--no-cache",
        "--report",
        &report,
    ];
    succeed(&[&FEW[..], &more].concat());
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .args(["--enable-logging=stderr", "--window-size=1300,4000"])
        .arg(format!("--user-data-dir={}", folder.path("profile")))
        .arg(format!("--screenshot={picture}"))
        .arg(format!("file://{report}/bench.html"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let complaints: Vec<&str> = said
        .lines()
        .filter(|line| line.contains("CONSOLE"))
        .collect();
    assert!(complaints.is_empty(), "{complaints:?}");
    let page = image::open(&picture).unwrap().into_rgb8();
    // Something of many colours, and not the page of an error.
    let colors: std::collections::BTreeSet<[u8; 3]> = page.pixels().map(|p| p.0).collect();
    assert!(colors.len() > 500, "{} colours", colors.len());
}
