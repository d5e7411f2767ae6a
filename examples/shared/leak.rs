//! How much light leaks into the dark part of a sealed scene.
use gibs::Renderer;
use gibs::builtin::SealedCase;
use gibs::graph::Backend;
use gibs::passes::frame::Settings;
use gibs::picture::{Picture, PictureError};
use gibs::renderer::RenderError;

/// How the two sides are rendered.
pub struct Work<'a> {
    /// Settings of the surfel frame.
    pub settings: &'a Settings,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frames on each side.
    pub frames: u32,
    /// Seed.
    pub seed: u32,
}

/// What was seen on the two sides of a sealed scene.
pub struct Leak {
    /// Mean of E on the bright side, over channels and pixels, W/m^2.
    pub bright_mean: f64,
    /// The same on the dark side, over that of the bright side.
    pub mean: f64,
    /// The value that one pixel in a hundred of the dark side exceeds, over the mean of the bright side.
    pub p99: f64,
    /// The brightest pixel of the dark side, over the mean of the bright side.
    pub most: f64,
    /// The bright side.
    pub bright: Picture,
    /// The dark side.
    pub dark: Picture,
}

/// Fills the bright side with surfels, then moves to the dark side, and compares what is there.
pub fn measure(
    backend: &dyn Backend,
    case: &SealedCase,
    work: &Work<'_>,
) -> Result<Leak, RenderError> {
    let (scene, bright, dark) = (case.make)();
    let mut renderer = Renderer::new(
        backend,
        &scene,
        &bright,
        work.size,
        work.settings,
        work.seed,
    )?;
    let look = |renderer: &mut Renderer| -> Result<Picture, RenderError> {
        for _ in 0..work.frames {
            renderer.frame()?;
        }
        renderer.picture()
    };
    let bright = look(&mut renderer)?;
    renderer.set_camera(dark.camera);
    let dark = look(&mut renderer)?;
    let lit = levels(&bright)?;
    let mut unlit = levels(&dark)?;
    unlit.sort_by(f64::total_cmp);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let bright_mean = mean(&lit);
    let over = |value: f64| value / bright_mean.max(f64::MIN_POSITIVE);
    let at = |share: f64| {
        let index = (unlit.len() as f64 * share).ceil() as usize;
        unlit.get(index.saturating_sub(1)).copied().unwrap_or(0.0)
    };
    Ok(Leak {
        bright_mean,
        mean: over(mean(&unlit)),
        p99: over(at(0.99)),
        most: over(at(1.0)),
        bright,
        dark,
    })
}

/// Mean of the three channels of E at each pixel that sees a surface, W/m^2.
pub fn levels(picture: &Picture) -> Result<Vec<f64>, PictureError> {
    let mask = picture.scalar("mask.A")?;
    let [r, g, b] = picture.rgb("E")?;
    let level = |i: usize| (f64::from(r[i]) + f64::from(g[i]) + f64::from(b[i])) / 3.0;
    Ok((0..mask.len())
        .filter(|&i| mask[i] > 0.0)
        .map(level)
        .collect())
}
