//! What a terminal shows while a profile is measured.
use crate::profile::Progress;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// A table on a terminal that changes with every frame; nothing in a pipe.
pub struct Live {
    lines: MultiProgress,
    title: ProgressBar,
    groups: Vec<ProgressBar>,
}

impl Live {
    pub fn new(backend: &str) -> Self {
        let lines = MultiProgress::new();
        let title = lines.add(ProgressBar::new(0));
        if let Ok(style) =
            ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} {eta} {msg}")
        {
            title.set_style(style);
        }
        title.set_prefix(backend.to_owned());
        Self {
            lines,
            title,
            groups: Vec::new(),
        }
    }

    pub fn show(&mut self, progress: &Progress) {
        self.title.set_length(progress.of.into());
        self.title.set_position(progress.done.into());
        self.title.set_message(match progress.frame_ms {
            Some(ms) => format!("{ms:.2} ms"),
            None => "warming up".into(),
        });
        let measured = progress.groups.iter().filter(|group| group.ms.is_some());
        for (index, group) in measured.enumerate() {
            if self.groups.len() <= index {
                let bar = self.lines.add(ProgressBar::new(1000));
                if let Ok(style) = ProgressStyle::with_template("  {prefix:12} {wide_bar} {msg}") {
                    bar.set_style(style);
                }
                bar.set_prefix(group.name.clone());
                self.groups.push(bar);
            }
            let (ms, share) = (group.ms.as_ref().map_or(0.0, |ms| ms.median), group.share);
            self.groups[index].set_position((share * 1000.0) as u64);
            self.groups[index].set_message(format!("{ms:>9.3} ms {:>5.1} %", share * 100.0));
        }
    }

    pub fn clear(&self) {
        for bar in self.groups.iter().chain([&self.title]) {
            bar.finish_and_clear();
        }
    }
}
