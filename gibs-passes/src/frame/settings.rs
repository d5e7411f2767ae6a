//! Every setting of the surfel frame, with unit, default and range.
use crate::data::SurfelSettings;
use crate::shared::debug::DebugView;
use crate::shared::grid::GridLayout;
use crate::stages::gap_fill::{GROUP, LEAST_TILE};
use serde::{Deserialize, Serialize};

mod table;
use table::LEAST_SIDE;
pub use table::{SettingError, SettingInfo};

/// Settings of the surfel frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// See [`Settings::all`].
    pub surfels: u32,
    /// See [`Settings::all`].
    pub rays: u32,
    /// See [`Settings::all`].
    pub radius: f32,
    /// See [`Settings::all`].
    pub coverage: f32,
    /// See [`Settings::all`].
    pub lookup: u32,
    /// See [`Settings::all`].
    pub half_resolution: bool,
    /// See [`Settings::all`].
    pub depth: bool,
    /// See [`Settings::all`].
    pub fallback: bool,
    /// See [`Settings::all`].
    pub depth_blend: f32,
    /// See [`Settings::all`].
    pub depth_side: u32,
    /// See [`Settings::all`].
    pub clamp: bool,
    /// See [`Settings::all`].
    pub steering: bool,
    /// See [`Settings::all`].
    pub guiding: bool,
    /// See [`Settings::all`].
    pub guide_side: u32,
    /// See [`Settings::all`].
    pub emitters: bool,
    /// See [`Settings::all`].
    pub sharing: bool,
    /// See [`Settings::all`].
    pub sorting: bool,
    /// See [`Settings::all`].
    pub ray_queries: bool,
    /// See [`Settings::all`].
    pub lights: u32,
    /// See [`Settings::all`].
    pub continuations: u32,
    /// See [`Settings::all`].
    pub hit_births: u32,
    /// See [`Settings::all`].
    pub geometric_normals: bool,
    /// See [`Settings::all`].
    pub grid_side: u32,
    /// See [`Settings::all`].
    pub grid_reach: f32,
    /// See [`Settings::all`].
    pub grid_lists: u32,
    /// See [`Settings::all`].
    pub grid_half: f32,
    /// See [`Settings::all`].
    pub queries: u32,
    /// See [`Settings::all`].
    pub check_slots: bool,
    /// A picture of what the technique does, beside what it renders.
    pub debug: Option<DebugView>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            surfels: 65_536,
            rays: 100_000,
            radius: 0.0,
            coverage: 1.0,
            lookup: 1024,
            half_resolution: true,
            depth: true,
            depth_blend: 0.05,
            depth_side: 4,
            fallback: true,
            clamp: false,
            steering: true,
            guiding: false,
            guide_side: 6,
            emitters: true,
            sharing: true,
            sorting: false,
            ray_queries: false,
            lights: 4,
            continuations: 8,
            hit_births: 0,
            geometric_normals: false,
            grid_side: 0,
            grid_reach: 128.0,
            grid_lists: 8,
            grid_half: 1.0 / 64.0,
            queries: 0,
            check_slots: false,
            debug: None,
        }
    }
}

impl Settings {
    /// Lights that are sampled per point in a scene of so many.
    pub fn lights_per_point(&self, lights: u64) -> u32 {
        lights.min(u64::from(self.lights)) as u32
    }

    /// Target radius of a surfel in a picture of this size, pixels.
    ///
    /// When spawning stops there are about `SURFELS_PER_DISC` times as many surfels as discs of that radius fit (measured:
    /// 5500 surfels of 8 pixels cover a picture of 480x270). Fitted, they take `SHARE_IN_VIEW` of the capacity; the rest is
    /// for the small ones beside walls and in foliage, in the atrium of Sponza half as many again, and for what the camera has
    /// left behind. Nor are there more than rays can feed, `SLOTS_PER_RAY` of the capacity, which is all of it by default: of more
    /// that know less each, the picture is worse, and takes longer.
    pub fn radius_in(&self, size: [u32; 2]) -> f32 {
        const SHARE_IN_VIEW: f32 = 0.276;
        const SURFELS_PER_DISC: f32 = 8.5;
        const SLOTS_PER_RAY: f32 = 0.65536;
        const LEAST: f32 = 1.0;
        if self.radius > 0.0 {
            return self.radius.max(LEAST);
        }
        let pixels = size[0] as f32 * size[1] as f32;
        let fed = (self.rays as f32 * SLOTS_PER_RAY).min(self.surfels as f32);
        let surfels = fed * SHARE_IN_VIEW;
        let fitting = (SURFELS_PER_DISC * pixels / (surfels * std::f32::consts::PI)).sqrt();
        fitting.clamp(LEAST, 16.0)
    }

    /// Length of the surfel buffers: the capacity, but at least one element, since no buffer can have none.
    pub fn slots(&self) -> u64 {
        u64::from(self.surfels.max(1))
    }

    /// Pixels along each side of a texel of gap filling.
    pub fn stride(&self) -> u32 {
        1 + u32::from(self.half_resolution)
    }

    /// Side of the tiles that surfels are born in, at most one in each or, beside small ones, in each of its quarters, in
    /// texels of gap filling. In pixels it does not depend on those: about a surfel's radius, within what the stage allows, so
    /// that gaps between surfels are found in a few frames.
    pub fn tile_in(&self, size: [u32; 2]) -> u32 {
        const LEAST_PIXELS: u32 = 2 * LEAST_TILE;
        let wide = self.radius_in(size) as u32;
        (1 << wide.max(1).ilog2()).clamp(LEAST_PIXELS, GROUP) / self.stride()
    }

    /// The grid's shape for a picture where a pixel subtends this angle, radians.
    ///
    /// Cells are about four target radii wide: wide enough that the grid does not limit radii, narrow enough that
    /// lists stay short. There are no more than pay: where there is room for more surfels, whose lists would get long,
    /// more of them.
    pub fn grid(&self, pixel_angle: f32, size: [u32; 2]) -> GridLayout {
        const RADII_PER_CELL: f32 = 4.0;
        let radius = self.radius_in(size);
        let fitting = 2.0 / (RADII_PER_CELL * radius * pixel_angle.max(1e-6));
        let most = (self.slots() as f32 / 1024.0).sqrt() * 5.0;
        let side = if self.grid_side == 0 {
            (fitting as u32).clamp(LEAST_SIDE, most.clamp(40.0, 64.0) as u32)
        } else {
            self.grid_side.max(LEAST_SIDE)
        };
        GridLayout::new(side, self.grid_reach)
    }

    fn check_debug(&self) -> Result<(), SettingError> {
        let Some(view) = self.debug else {
            return Ok(());
        };
        match view.missing(self) {
            Some(needs) => Err(SettingError::Debug { view, needs }),
            None => Ok(()),
        }
    }

    /// The settings as stages see them, in a scene where no light is too faint.
    pub fn device(&self, size: [u32; 2]) -> SurfelSettings {
        SurfelSettings {
            capacity: self.surfels,
            ray_budget: self.rays,
            radius_pixels: self.radius_in(size),
            coverage: self.coverage,
            lookup: self.lookup,
            depth_blend: self.depth_blend,
            depth_side: self.depth_side,
            guide_side: self.guide_side,
            fallback: u32::from(self.fallback),
            clamp: u32::from(self.clamp),
            hit_births: self.hit_births,
            geometric_normals: u32::from(self.geometric_normals),
            steered: u32::from(self.steering),
            debug: self.debug.map_or(0, DebugView::number),
            stride: self.stride(),
            faintest: 0.0,
        }
    }
}
