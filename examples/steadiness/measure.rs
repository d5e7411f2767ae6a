//! How steady the light is when nothing changes, and how soon it is gone when its source is.
use gibs::Renderer;
use gibs::passes::scene::{Environment, Scene};
use gibs::picture::luminance;
use gibs::renderer::RenderError;
use gibs::view::View;
use glam::Vec3;

/// What is measured, in frames.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// Until it counts as converged.
    pub settle: u32,
    /// Pairs of frames whose difference is flicker.
    pub watch: u32,
    /// After the light went out.
    pub dark: u32,
    /// Until what then remains counts as the end.
    pub end: u32,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Steadiness {
    /// Relative change of a pixel's E from frame to frame: its mean, and its 99th percentile.
    pub flicker: [f64; 2],
    /// Mean luminance of E while the light shone and long after it went out, W/m^2.
    pub means: [f64; 2],
    /// Share of what the light had added that is still there, for each frame after it went out.
    pub left: Vec<f64>,
}

impl Steadiness {
    /// Frames after which no more than a share is left, and stays away.
    pub fn gone(&self, share: f64) -> Option<usize> {
        // What is no number is not gone.
        let is_gone = |left: f64| left.abs() <= share;
        let last_above = self.left.iter().rposition(|&left| !is_gone(left));
        let frames = last_above.map_or(0, |frame| frame + 1);
        (frames < self.left.len()).then_some(frames + 1)
    }
}

/// The same scene and view without the light that is put out: the sun if there is one, else every emitter, the sky and
/// all lights.
pub fn without_light(scene: &Scene, view: &View) -> (Scene, View) {
    let (mut scene, mut view) = (scene.clone(), view.clone());
    if view.sun.take().is_none() {
        for material in &mut scene.materials {
            material.emission = Vec3::ZERO;
        }
        scene.lights.clear();
        view.environment = Environment::default();
    }
    (scene, view)
}

/// Renders on, with the same settings throughout.
pub fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    view: &View,
    frames: Frames,
) -> Result<Steadiness, RenderError> {
    for _ in 0..frames.settle {
        renderer.frame()?;
    }
    let mut before = irradiance(renderer)?;
    let mut changes = Vec::new();
    for _ in 0..frames.watch {
        renderer.frame()?;
        let now = irradiance(renderer)?;
        // Relative to the larger one, or to a hundredth of the picture where it is darker than that.
        let floor = 0.01 * mean(&now);
        let pairs = before.iter().zip(&now);
        changes.extend(
            pairs.map(|(a, b)| (a - b).abs() / a.max(*b).max(floor).max(f64::MIN_POSITIVE)),
        );
        before = now;
    }
    changes.sort_by(f64::total_cmp);
    let p99 = changes.get(changes.len() * 99 / 100).copied();
    let flicker = [mean(&changes), p99.unwrap_or(0.0)];

    let lit = mean(&before);
    let (dark_scene, dark_view) = without_light(scene, view);
    renderer.set_scene(&dark_scene, &dark_view)?;
    let mut means = Vec::new();
    for _ in 0..frames.dark {
        renderer.frame()?;
        means.push(mean(&irradiance(renderer)?));
    }
    for _ in 0..frames.end {
        renderer.frame()?;
    }
    let end = mean(&irradiance(renderer)?);
    let left = means.iter().map(|now| (now - end) / (lit - end)).collect();
    Ok(Steadiness {
        flicker,
        means: [lit, end],
        left,
    })
}

/// Luminance of E at every pixel that sees a surface.
fn irradiance(renderer: &mut Renderer) -> Result<Vec<f64>, RenderError> {
    let picture = renderer.picture()?;
    let (e, mask) = (picture.rgb("E")?, picture.scalar("mask.A")?);
    let seen = (0..mask.len()).filter(|&i| mask[i] > 0.0);
    Ok(seen
        .map(|i| luminance([e[0][i], e[1][i], e[2][i]]))
        .collect())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
