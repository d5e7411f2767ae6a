//! What is read back after a frame.
use super::{RenderError, Renderer};
use crate::Counters;
use crate::channels::{find_output, read_output, set, surface_channels};
use crate::debug::DebugPicture;
use crate::picture::Picture;
use crate::query::Irradiance;
use gibs_graph::{DispatchArgs, Element};
use gibs_passes::data::{ClampedLight, SurfacePoint, SurfelCounters};
use gibs_passes::shared::surface;
use glam::{DVec3, Vec3, Vec4};

impl Renderer {
    /// As [`Gi::irradiance`](crate::Gi::irradiance), after the last frame.
    ///
    /// # Errors
    /// As [`Gi::irradiance`](crate::Gi::irradiance).
    pub fn irradiance(
        &mut self,
        points: &[DVec3],
        normals: &[Vec3],
    ) -> Result<Vec<Irradiance>, RenderError> {
        self.gi.irradiance(self.exec.as_mut(), points, normals)
    }

    /// What happened to the surfels up to the last frame. Waits for it.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`], [`RenderError::Backend`].
    pub fn counters(&mut self) -> Result<Counters, RenderError> {
        let surfels: SurfelCounters = self.only("counters")?;
        let has = |name| self.gi.schedule().output(name).is_some();
        let (slot_errors, clamped) = (has("slot_errors"), has("clamped"));
        let mut continued = 0;
        for depth in 1.. {
            let name = format!("rays_{depth}");
            if self.gi.schedule().output(&name).is_none() {
                break;
            }
            continued += self.only::<DispatchArgs>(&name)?.count;
        }
        Ok(Counters {
            live: surfels.live,
            born: surfels.born,
            recycled: surfels.recycled,
            starved: surfels.starved,
            crowded: self.only("crowded")?,
            overflow: self.only("overflow")?,
            rays: self.only::<DispatchArgs>("rays")?.count,
            continued,
            slot_errors: match slot_errors {
                true => Some(self.only("slot_errors")?),
                false => None,
            },
            clamped: match clamped {
                true => Some(self.only::<ClampedLight>("clamped")?.into()),
                false => None,
            },
        })
    }

    /// The one element of an output.
    fn only<T: Element + Default>(&mut self, name: &str) -> Result<T, RenderError> {
        Ok(self.output(name)?.first().copied().unwrap_or_default())
    }

    /// The picture after the last frame: the final image in `R G B`, the channels of a truth, and the values of the debug
    /// view, if there is one, as `debug.NAME`.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`] before the first frame and between a change and the next one, [`RenderError::Backend`].
    pub fn picture(&mut self) -> Result<Picture, RenderError> {
        let points: Vec<SurfacePoint> = self.output("points")?;
        let direct = match self.gi.schedule().output("direct") {
            Some(_) => self.output("direct")?,
            None => vec![Vec4::ZERO; points.len()],
        };
        let irradiance: Vec<Vec4> = self.output("irradiance")?;
        let color: Vec<Vec4> = self.output("color")?;
        let mut picture =
            surface_channels(&points, self.gi.size(), &self.view, self.gi.scene().origin)?;
        set(&mut picture, "", color.iter().map(|c| c.truncate()))?;
        set(&mut picture, "E", irradiance.iter().map(|e| e.truncate()))?;
        set(&mut picture, "direct", direct.iter().map(|d| d.truncate()))?;
        let albedos = points.iter().map(surface::albedo);
        let indirect = irradiance
            .iter()
            .zip(albedos)
            .map(|(e, a)| a * e.truncate() * std::f32::consts::FRAC_1_PI);
        set(&mut picture, "indirect", indirect)?;
        picture.set_scalar("coverage.A", irradiance.iter().map(|e| e.w).collect())?;
        if let Some(view) = self.gi.debug_view() {
            picture.set_scalar(&view.channel(), self.debug_picture()?.values().to_vec())?;
        }
        Ok(picture)
    }

    /// The debug view after the last frame: that of the setting `debug`, which [`Renderer::set_settings`] may change.
    ///
    /// # Errors
    /// [`RenderError::NoDebugView`] where there is none; [`RenderError::NoFrame`] before the first frame and between a
    /// change and the next one; [`RenderError::Backend`].
    pub fn debug_picture(&mut self) -> Result<DebugPicture, RenderError> {
        let view = self.gi.debug_view().ok_or(RenderError::NoDebugView)?;
        Ok(DebugPicture::new(
            view,
            self.gi.size(),
            &self.output("debug")?,
        ))
    }

    /// The elements of an output after the last frame: one of
    /// [`surfel_frame`](gibs_passes::frame::surfel_frame)'s, or of the stages that extend it.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`] before the first frame and between a change and the next one;
    /// [`BackendError::Refused`](gibs_graph::BackendError::Refused) if the frame has no such output, or its elements are of another type.
    pub fn output<T: Element>(&mut self, name: &str) -> Result<Vec<T>, RenderError> {
        find_output::<T>(self.gi.schedule(), name)?;
        if !self.gi.has_begun() {
            return Err(RenderError::NoFrame { what: name.into() });
        }
        read_output(self.exec.as_mut(), name)
    }
}
