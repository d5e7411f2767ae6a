//! Buffers of one type while a graph is recorded.
use gibs_graph::{Buffer, Element, Graph, Initial, Previous, State};

/// A buffer while the graph is recorded.
pub struct Entry<T> {
    /// Name.
    pub name: String,
    /// Its last version; away only while a stage is recorded.
    pub last: Option<Buffer<T>>,
    /// Where it outlives the frame.
    pub state: Option<State<T>>,
    /// Where it is a history.
    pub previous: Option<Previous<T>>,
    /// It may be read.
    pub ready: bool,
    /// Stages may write it.
    pub writable: bool,
}

/// Buffers of one type.
pub struct Pool<T>(pub Vec<Entry<T>>);

impl<T: Element> Pool<T> {
    /// One that fits, by a number.
    pub fn find(&self, pick: u8, fits: impl Fn(usize, &Entry<T>) -> bool) -> Option<usize> {
        let fitting: Vec<usize> = (0..self.0.len()).filter(|&i| fits(i, &self.0[i])).collect();
        (!fitting.is_empty()).then(|| fitting[usize::from(pick) % fitting.len()])
    }

    /// One to read that is none of these.
    pub fn source(&self, pick: u8, but: &[usize]) -> Option<usize> {
        self.find(pick, |i, entry| entry.ready && !but.contains(&i))
    }

    /// One to overwrite.
    pub fn target(&self, pick: u8, but: &[usize]) -> Option<usize> {
        self.find(pick, |i, entry| entry.writable && !but.contains(&i))
    }

    /// One to change.
    pub fn changed(&self, pick: u8, but: &[usize]) -> Option<usize> {
        self.find(pick, |i, entry| {
            entry.writable && entry.ready && !but.contains(&i)
        })
    }

    /// Its last version.
    pub fn read(&self, i: usize) -> &Buffer<T> {
        self.0[i]
            .last
            .as_ref()
            .expect("it is only away while its stage is recorded")
    }

    /// Its last version, to be replaced.
    pub fn take(&mut self, i: usize) -> Buffer<T> {
        self.0[i]
            .last
            .take()
            .expect("it is only away while its stage is recorded")
    }

    /// The next version.
    pub fn put(&mut self, i: usize, next: Buffer<T>) {
        self.0[i].last = Some(next);
        self.0[i].ready = true;
    }

    /// Declares one.
    pub fn add(&mut self, g: &mut Graph, name: String, kind: u8, len: u64) {
        let mut entry = Entry {
            name,
            last: None,
            state: None,
            previous: None,
            ready: true,
            writable: true,
        };
        let name = entry.name.as_str();
        match kind % 7 {
            0 => {
                entry.last = Some(g.input(name, len));
                entry.writable = false;
            }
            1 | 2 => {
                entry.last = Some(g.transient(name, len));
                entry.ready = false;
            }
            3 => entry.last = Some(g.zeroed(name, len)),
            4 | 5 => {
                let initial = if kind.is_multiple_of(2) {
                    Initial::Sequence
                } else {
                    Initial::Zero
                };
                let (state, last) = g.state(name, len, initial);
                (entry.state, entry.last) = (Some(state), Some(last));
            }
            _ => {
                let (state, previous, last) = g.history(name, len, Initial::Zero);
                (entry.state, entry.previous, entry.last) =
                    (Some(state), Some(previous), Some(last));
                entry.ready = false;
            }
        }
        self.0.push(entry);
    }

    /// The last versions that were asked for are outputs; those of states are kept.
    pub fn finish(self, g: &mut Graph, outputs: &mut impl FnMut() -> bool) {
        for entry in self.0 {
            let last = entry.last.expect("every stage gave it back");
            if entry.ready && outputs() {
                g.output(&entry.name, &last);
            }
            if let Some(state) = entry.state {
                g.keep(state, last);
            }
        }
    }
}
