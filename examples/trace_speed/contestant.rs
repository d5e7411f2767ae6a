//! The traversals that are compared, each with a workgroup of rays as the stages hand them out.
use crate::embree::Embree;
use gibs::passes::accel::wide::{Simd, Tracer};
use gibs::passes::accel::{AccelView, Hit, Ray, WideView, scalar};

/// Rays that a workgroup traces, as in the stages.
pub const GROUP: usize = 64;

/// One way to trace.
pub enum Contestant<'a> {
    Wide(WideView<'a>, fn() -> Tracer),
    Scalar(AccelView<'a>),
    Embree(&'a Embree),
}

impl Contestant<'_> {
    /// As the table calls it.
    pub fn name(&self) -> String {
        match self {
            Self::Wide(_, make) => match make().simd() {
                Simd::Avx2 => "gibs wide, AVX2".into(),
                Simd::Portable => "gibs wide, portable".into(),
            },
            Self::Scalar(_) => "gibs scalar".into(),
            Self::Embree(embree) => format!("Embree {}", embree.version),
        }
    }

    /// Closest hits of a workgroup's rays.
    pub fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        let pairs = rays.iter().zip(hits);
        match self {
            Self::Wide(view, make) => {
                let mut tracer = make();
                pairs.for_each(|(ray, hit)| *hit = tracer.closest(view, ray, opaque));
            }
            Self::Scalar(view) => {
                pairs.for_each(|(ray, hit)| *hit = scalar::closest(view, ray, opaque))
            }
            Self::Embree(embree) => pairs.for_each(|(ray, hit)| *hit = embree.closest(ray)),
        }
    }

    /// Whether a workgroup's rays hit anything, as a `t` of 0; else it is the ray's `t_max`.
    pub fn any(&self, rays: &[Ray], hits: &mut [Hit]) {
        let found = |ray: &Ray, any| Hit::miss(if any { 0.0 } else { ray.t_max });
        let pairs = rays.iter().zip(hits);
        match self {
            Self::Wide(view, make) => {
                let mut tracer = make();
                pairs.for_each(|(ray, hit)| *hit = found(ray, tracer.any(view, ray, opaque)));
            }
            Self::Scalar(view) => {
                pairs.for_each(|(ray, hit)| *hit = found(ray, scalar::any(view, ray, opaque)))
            }
            Self::Embree(embree) => pairs.for_each(|(ray, hit)| *hit = found(ray, embree.any(ray))),
        }
    }
}

fn opaque(_: u32, _: u32, _: f32, _: f32) -> bool {
    true
}
