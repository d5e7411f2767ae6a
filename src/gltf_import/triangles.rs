//! Triangles from corners, and the vertices that they use.
use gltf::json::mesh::Mode;

/// Triangles of a list, strip or fan (glTF 2.0, 3.7.2.1). The degenerate ones that turn a strip around are left out.
pub(super) fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let distinct = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match mode {
        Mode::TriangleStrip => (0..corners.len().saturating_sub(2))
            .map(|i| [corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]])
            .filter(distinct)
            .collect(),
        Mode::TriangleFan => (1..corners.len().saturating_sub(1))
            .map(|i| [corners[i], corners[i + 1], corners[0]])
            .filter(distinct)
            .collect(),
        _ => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
    }
}

/// Which of the accessors' vertices a primitive needs. Primitives often share large accessors and use a part each.
pub(super) enum Vertices {
    /// The first so many.
    All(usize),
    /// Ascending.
    Some(Vec<u32>),
}

impl Vertices {
    /// Finds the vertices in use and renumbers the triangles, at a cost that follows the triangles.
    pub(super) fn used(triangles: &mut [[u32; 3]], count: usize) -> Self {
        if triangles.len().saturating_mul(3) >= count {
            return Self::All(count);
        }
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for corner in triangles.as_flattened_mut() {
            // Every corner is in the list made of the corners.
            *corner = used.partition_point(|&vertex| vertex < *corner) as u32;
        }
        Self::Some(used)
    }

    /// `f` of every vertex, in the order of the triangles' numbers.
    pub(super) fn map<T>(&self, f: impl Fn(usize) -> T) -> Vec<T> {
        match self {
            Self::All(count) => (0..*count).map(f).collect(),
            Self::Some(used) => used.iter().map(|&i| f(i as usize)).collect(),
        }
    }
}
