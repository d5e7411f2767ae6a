//! Holes: pixels whose surface has been in view for some frames and which surfels hardly cover.
use crate::{RenderError, Renderer};
use gibs_passes::data::{Camera, SurfacePoint};
use gibs_passes::shared::{octahedral, surface};
use glam::{Vec3, Vec4};
use serde::Serialize;

/// Summed weight of surfels below which a pixel is a hole. Where it is below 1, the average of the grid's cell makes up
/// for what is missing: at a half, a pixel's light is as much its cell's as its own.
pub const COVERED: f32 = 0.5;

/// Frames after which a surface in view should be covered. At half resolution gap filling has looked at every pixel
/// after four, the amply covered included, each time with one birth per tile; eight let it look twice.
pub const SETTLES: u32 = 8;

/// Cosine of the angle between normals up to which two pixels see the same surface.
const SAME_NORMAL: f32 = 0.7;

/// Pixels of a frame, by how long their surfaces have been in view and whether they are covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct HoleRow {
    /// Pixels that see a surface.
    pub surfaces: u32,
    /// Of those, holes.
    pub holes: u32,
    /// Pixels whose surface has been in view for [`SETTLES`] frames or more.
    pub settled: u32,
    /// Of those, holes.
    pub settled_holes: u32,
}

impl HoleRow {
    /// Holes over all surfaces.
    pub fn share(&self) -> f64 {
        f64::from(self.holes) / f64::from(self.surfaces.max(1))
    }

    /// Holes over surfaces that have been in view for [`SETTLES`] frames.
    pub fn settled_share(&self) -> f64 {
        f64::from(self.settled_holes) / f64::from(self.settled.max(1))
    }
}

/// Follows surfaces from frame to frame, and counts holes.
///
/// The surface of a pixel was in view the frame before if one of the four pixels around the place that it projects to
/// there saw the same node, a plane through it within the width of a pixel, and about the same normal. It has then been in
/// view one frame longer than the oldest of those.
#[derive(Debug, Default)]
pub struct Holes {
    before: Option<Seen>,
}

#[derive(Debug)]
struct Seen {
    camera: Camera,
    points: Vec<SurfacePoint>,
    /// Frames that each pixel's surface has been in view, this one included; 0 for the sky.
    ages: Vec<u32>,
}

impl Holes {
    /// Counts the holes of the last frame of a renderer.
    ///
    /// # Errors
    /// As [`Renderer::output`].
    pub fn frame(&mut self, renderer: &mut Renderer) -> Result<HoleRow, RenderError> {
        let points: Vec<SurfacePoint> = renderer.output("points")?;
        let irradiance: Vec<Vec4> = renderer.output("irradiance")?;
        let camera = renderer.device_camera();
        let weights: Vec<f32> = irradiance.iter().map(|e| e.w).collect();
        Ok(self.count(camera, points, &weights))
    }

    pub(super) fn count(
        &mut self,
        camera: Camera,
        points: Vec<SurfacePoint>,
        weights: &[f32],
    ) -> HoleRow {
        let before = self.before.take();
        let age = |point: &SurfacePoint| match surface::is_surface(point) {
            true => 1 + before.as_ref().map_or(0, |before| before.age_of(point)),
            false => 0,
        };
        let ages: Vec<u32> = points.iter().map(age).collect();
        let mut row = HoleRow::default();
        for (&age, &weight) in ages.iter().zip(weights) {
            let hole = u32::from(weight < COVERED);
            let settled = u32::from(age >= SETTLES);
            if age > 0 {
                row.surfaces += 1;
                row.holes += hole;
                row.settled += settled;
                row.settled_holes += hole * settled;
            }
        }
        self.before = Some(Seen {
            camera,
            points,
            ages,
        });
        row
    }
}

impl Seen {
    /// Frames that a point's surface was in view up to this one; 0 where it was not.
    fn age_of(&self, point: &SurfacePoint) -> u32 {
        let Some([x, y]) = project(&self.camera, point.position) else {
            return 0;
        };
        let [width, height] = [self.camera.width, self.camera.height];
        let [left, top] = [x - 0.5, y - 0.5].map(f32::floor);
        let mut age = 0;
        for [dx, dy] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let [x, y] = [left + dx, top + dy];
            if x < 0.0 || y < 0.0 || x >= width as f32 || y >= height as f32 {
                continue;
            }
            let i = y as usize * width as usize + x as usize;
            if self.is_same(&self.points[i], point) {
                age = age.max(self.ages[i]);
            }
        }
        age
    }

    fn is_same(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        if !surface::is_surface(a) || a.transform_id != b.transform_id {
            return false;
        }
        let normals = [a, b].map(|p| octahedral::unpack(p.geometric_normal));
        let pixel = self.camera.pixel_angle * (b.position - self.camera.eye).length();
        let apart = (a.position - b.position).dot(normals[1]).abs();
        apart <= pixel && normals[0].dot(normals[1]) >= SAME_NORMAL
    }
}

/// Where a point of the device's space projects to, pixels from the top left; `None` behind the eye.
fn project(camera: &Camera, point: Vec3) -> Option<[f32; 2]> {
    let to = point - camera.eye;
    let depth = to.dot(camera.forward);
    let across = to.dot(camera.right) / camera.right.length_squared() / depth;
    let upwards = to.dot(camera.up) / camera.up.length_squared() / depth;
    let place = [
        (across + 1.0) * 0.5 * camera.width as f32,
        (1.0 - upwards) * 0.5 * camera.height as f32,
    ];
    (depth > 0.0 && place.iter().all(|c| c.is_finite())).then_some(place)
}
