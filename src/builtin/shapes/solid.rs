//! Boxes and rooms.
use super::Shape;
use glam::Vec3;

/// The six faces of a box as corner numbers; bit 0 is x, bit 1 is y, bit 2 is z. Order: -x, +x, -y, +y, -z, +z.
const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

fn corner(low: Vec3, high: Vec3, number: usize) -> Vec3 {
    let pick = |axis: usize| {
        if number >> axis & 1 == 1 {
            high[axis]
        } else {
            low[axis]
        }
    };
    Vec3::new(pick(0), pick(1), pick(2))
}

/// A closed box.
pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Shape {
    let mut shape = Shape::default();
    for face in FACES {
        shape.polygon(&face.map(|i| corner(low, high, i)));
    }
    shape
}

/// A closed box whose edges and corners are cut off at 45 degrees, `bevel` wide on each face.
pub(crate) fn bevelled(low: Vec3, high: Vec3, bevel: f32) -> Shape {
    let middle = (low + high) / 2.0;
    // Three vertices for each corner: vertex `axis` lies on the face across that axis.
    let point = |number: usize, axis: usize| {
        let p = corner(low, high, number);
        let inward = (middle - p).signum() * bevel;
        p + inward * (Vec3::ONE - Vec3::AXES[axis])
    };
    let mut shape = Shape::default();
    for (i, face) in FACES.iter().enumerate() {
        shape.polygon(&face.map(|number| point(number, i / 2)));
    }
    for number in 0..8_usize {
        let odd = number.count_ones() % 2 == 1;
        let [a, b] = if odd { [1, 2] } else { [2, 1] };
        shape.polygon(&[point(number, 0), point(number, a), point(number, b)]);
        for axis in 0..3 {
            let next = number | 1 << axis;
            if next != number {
                let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                let quad = [
                    point(number, p),
                    point(number, q),
                    point(next, q),
                    point(next, p),
                ];
                let flipped = [quad[3], quad[2], quad[1], quad[0]];
                shape.polygon(if odd { &flipped } else { &quad });
            }
        }
    }
    shape
}

/// An opening in the +z side of a [`shell`]: least and greatest x and y.
pub(crate) type Opening = [[f32; 2]; 2];

/// A closed solid between an outer box and an inner one: the inside is a room. Returns the outside with the reveals of
/// the opening, and the six inner faces in the order -x, +x, -y (floor), +y (ceiling), -z, +z.
pub(crate) fn shell(
    inner: [Vec3; 2],
    outer: [Vec3; 2],
    opening: Option<Opening>,
) -> (Shape, [Shape; 6]) {
    let mut outside = Shape::default();
    let mut inside: [Shape; 6] = Default::default();
    for (i, face) in FACES.iter().enumerate() {
        let mut inner_face = face.map(|n| corner(inner[0], inner[1], n));
        let outer_face = face.map(|n| corner(outer[0], outer[1], n));
        inner_face.reverse();
        match opening {
            Some([[x0, x1], [y0, y1]]) if i == 5 => {
                // Counter-clockwise seen from outside (+z).
                let hole = |z: f32| {
                    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Vec3::new(x, y, z))
                };
                let (near, far) = (hole(inner[1].z), hole(outer[1].z));
                inner_face.reverse();
                for k in 0..4 {
                    let l = (k + 1) % 4;
                    inside[i].polygon(&[inner_face[l], inner_face[k], near[k], near[l]]);
                    outside.polygon(&[outer_face[k], outer_face[l], far[l], far[k]]);
                    outside.polygon(&[near[l], near[k], far[k], far[l]]);
                }
            }
            _ => {
                inside[i].polygon(&inner_face);
                outside.polygon(&outer_face);
            }
        }
    }
    (outside, inside)
}
