//! Irradiance at points that a program asks for.
use crate::channels::read_output;
use crate::gi::Gi;
use crate::renderer::RenderError;
use gibs_graph::Executable;
use gibs_passes::accel::MAX_COORDINATE;
use gibs_passes::data::{Gathered, SurfacePoint};
use gibs_passes::frame::upload;
use gibs_passes::shared::{batch, octahedral, surface};
use glam::{DVec3, Vec3, Vec4};

/// Light that arrives at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// From surfaces and the sky, W/m^2; what the surfels there hold, made up by the cell's average.
    pub indirect: Vec3,
    /// From the sun and the lights, W/m^2.
    pub direct: Vec3,
    /// How much of the indirect light surfels at the point itself know, 0 to 1; with 0, none are near.
    pub confidence: f32,
}

pub(crate) fn irradiance(
    exec: &mut dyn Executable,
    gi: &Gi,
    points: &[DVec3],
    normals: &[Vec3],
) -> Result<Vec<Irradiance>, RenderError> {
    let refuse = |problem: &str| RenderError::Queries {
        points: points.len(),
        normals: normals.len(),
        problem: problem.into(),
    };
    gi.check(exec)?;
    if points.len() != normals.len() {
        return Err(refuse("give a normal for each point"));
    }
    let usable = |p: &DVec3| p.is_finite() && p.abs().max_element() <= f64::from(MAX_COORDINATE);
    if let Some(i) = points.iter().position(|p| !usable(p)) {
        return Err(refuse(&format!(
            "point {i} is {}; give finite coordinates of at most {MAX_COORDINATE:e}",
            points[i]
        )));
    }
    if let Some(i) = normals.iter().position(|n| direction(*n).is_none()) {
        return Err(refuse(&format!(
            "normal {i} is {}; give a finite one that has a length",
            normals[i]
        )));
    }
    let schedule = exec.schedule().clone();
    let room = schedule
        .resource("query_points")
        .map_or(0, |id| schedule.resources[id as usize].len as usize);
    if room == 0 {
        return Err(refuse(
            "the frame has no stage for it; set `queries` to the most points at a time",
        ));
    }
    let steps: Vec<usize> = schedule
        .dispatches()
        .filter(|(_, step, _)| step.group() == "query")
        .map(|(i, ..)| i)
        .collect();
    if !gi.has_begun() && !points.is_empty() {
        return Err(refuse(
            "no frame has run yet since the start or the last change; run one first",
        ));
    }
    let answers = ask(exec, gi, &steps, room, points, normals);
    // The next frame asks nothing, whatever became of these.
    let emptied = upload(exec, "query_batch", &[batch::args(0)]);
    let answers = answers?;
    emptied?;
    Ok(answers)
}

fn ask(
    exec: &mut dyn Executable,
    gi: &Gi,
    steps: &[usize],
    room: usize,
    points: &[DVec3],
    normals: &[Vec3],
) -> Result<Vec<Irradiance>, RenderError> {
    let mut answers = Vec::with_capacity(points.len());
    for (points, normals) in points.chunks(room).zip(normals.chunks(room)) {
        let asked: Vec<SurfacePoint> = points
            .iter()
            .zip(normals)
            .map(|(p, n)| asked(*p - gi.scene().origin, *n))
            .collect();
        upload(exec, "query_points", &asked)?;
        upload(exec, "query_batch", &[batch::args(asked.len() as u32)])?;
        for &step in steps {
            exec.run_step(step)?;
        }
        let gathered: Vec<Gathered> = read_output(exec, "query_gathered")?;
        let direct: Vec<Vec4> = match exec.schedule().output("query_direct") {
            Some(_) => read_output(exec, "query_direct")?,
            None => Vec::new(), // a scene without lights
        };
        let direct = direct
            .iter()
            .map(|d| d.truncate())
            .chain(std::iter::repeat(Vec3::ZERO));
        answers.extend(
            gathered
                .iter()
                .zip(direct)
                .take(asked.len())
                .map(|(g, direct)| Irradiance {
                    indirect: g.irradiance + g.average * (1.0 - g.weight),
                    direct,
                    confidence: g.weight,
                }),
        );
    }
    Ok(answers)
}

/// The direction of a normal of any length.
fn direction(normal: Vec3) -> Option<Vec3> {
    let largest = normal.abs().max_element();
    // The squares of very long and very short ones leave the range of floats.
    (normal.is_finite() && largest > 0.0).then(|| (normal / largest).normalize())
}

fn asked(position: DVec3, normal: Vec3) -> SurfacePoint {
    let position = position.as_vec3();
    let packed = octahedral::pack(direction(normal).unwrap_or(Vec3::Z));
    SurfacePoint {
        position,
        offset: position.abs().max_element() * surface::OFFSET,
        geometric_normal: packed,
        shading_normal: packed,
        transform_id: 0,
        ..surface::MISS
    }
}
