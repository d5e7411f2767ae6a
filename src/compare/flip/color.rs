//! The colour spaces of FLIP.
use std::sync::LazyLock;

use glam::{DMat3, DVec3, Mat3, Vec3};

/// Chromaticities x, y of the sRGB primaries and of the white point D65 (IEC 61966-2-1).
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
const WHITE: [f64; 2] = [0.3127, 0.3290];

/// Linear RGB to XYZ over the white point's XYZ (so white is 1, 1, 1), and back.
static MATRICES: LazyLock<(Mat3, Mat3)> = LazyLock::new(|| {
    let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let white = xyz(WHITE);
    let primaries = DMat3::from_cols(xyz(PRIMARIES[0]), xyz(PRIMARIES[1]), xyz(PRIMARIES[2]));
    let intensities = primaries.inverse() * white;
    let to_xyz = primaries * DMat3::from_diagonal(intensities);
    let relative = DMat3::from_diagonal(white.recip()) * to_xyz;
    (relative.as_mat3(), relative.inverse().as_mat3())
});

/// Linear RGB to the opponent space YyCxCz.
pub fn to_opponent(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = MATRICES.0 * Vec3::from_array(rgb);
    [
        116.0 * xyz.y - 16.0,
        500.0 * (xyz.x - xyz.y),
        200.0 * (xyz.y - xyz.z),
    ]
}

/// The inverse of [`to_opponent`].
pub fn from_opponent([yy, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (yy + 16.0) / 116.0;
    (MATRICES.1 * Vec3::new(y + cx / 500.0, y, y - cz / 200.0)).to_array()
}

/// Linear RGB to CIE L*a*b* with Hunt's adjustment: differences of chroma fade as the colour
/// darkens.
pub fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let curve = |t: f32| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = (MATRICES.0 * Vec3::from_array(rgb)).to_array().map(curve);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// The HyAB distance: city block in lightness, Euclidean in chroma (Abasi, Amani Tehran and
/// Fairchild, "Distance metrics for very large color differences", 2020).
pub fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}
