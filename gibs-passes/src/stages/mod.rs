//! The stages: one file each, with what it reads and writes, the formula with its source, and the CPU kernel.
//! The device kernel of each has the same name in `shaders/stages`.
pub mod allocate_rays;
pub mod batch_args;
pub mod compose;
pub mod continue_paths;
pub mod count_slots;
pub mod debug_discs;
pub mod debug_surface;
pub mod debug_surfels;
pub mod drift_blocks;
pub mod drift_total;
pub mod export_indirect;
pub mod gap_fill;
pub mod gather_at_hits;
pub mod gather_direct;
pub mod gather_surfels;
pub mod generate_rays;
pub mod grid_carry;
pub mod grid_count;
pub mod grid_insert;
pub mod grid_leave;
pub mod grid_merge;
pub mod grid_order;
pub mod grid_scatter;
pub mod hit_gaps;
pub mod import_gbuffer;
pub mod integrate;
pub mod light_batch;
pub mod mark_slots;
pub mod measure_drift;
pub mod pack_points;
pub mod positional_update;
pub mod primary_rays;
pub mod ray_bins;
pub mod ray_order;
pub mod ray_scatter;
pub mod recycle;
pub mod recycle_commit;
pub mod recycle_push;
pub mod reference_accumulate;
pub mod reference_emitters;
pub mod reference_remaining;
pub mod reference_scatter;
pub mod reorder_rays;
pub mod request_rays;
pub mod resolve_hits;
pub mod sample_lights;
pub mod scan_apply;
pub mod scan_blocks;
pub mod scan_sums;
pub mod select_pixels;
pub mod shade_hits;
pub mod share_irradiance;
pub mod spawn;
pub mod spawn_claim;
pub mod spawn_commit;
pub mod sum_clamped;
pub mod trace_any;
pub mod trace_closest;
pub mod update_depth;
pub mod update_guide;
pub mod upsample;

use gibs_graph::{KernelSource, Port, Stage};

/// One stage, for checks that walk all of them.
#[derive(Clone, Debug)]
pub struct StageInfo {
    /// Type name.
    pub name: &'static str,
    /// Ports.
    pub ports: Vec<Port>,
    /// Kernels.
    pub kernel: KernelSource,
}

fn info<S: Stage>() -> StageInfo {
    StageInfo {
        name: S::NAME,
        ports: S::ports(),
        kernel: S::kernel(),
    }
}

/// Every stage of this crate.
pub fn all() -> Vec<StageInfo> {
    vec![
        info::<allocate_rays::AllocateRays>(),
        info::<batch_args::BatchArgs>(),
        info::<compose::Compose>(),
        info::<continue_paths::ContinuePaths>(),
        info::<count_slots::CountSlots>(),
        info::<debug_discs::DebugDiscs>(),
        info::<debug_surface::DebugSurface>(),
        info::<debug_surfels::DebugSurfels>(),
        info::<drift_blocks::DriftBlocks>(),
        info::<drift_total::DriftTotal>(),
        info::<export_indirect::ExportIndirect>(),
        info::<gap_fill::GapFill>(),
        info::<gather_at_hits::GatherAtHits>(),
        info::<gather_direct::GatherDirect>(),
        info::<gather_surfels::GatherSurfels>(),
        info::<generate_rays::GenerateRays>(),
        info::<grid_carry::GridCarry>(),
        info::<grid_count::GridCount>(),
        info::<grid_insert::GridInsert>(),
        info::<grid_leave::GridLeave>(),
        info::<grid_merge::GridMerge>(),
        info::<grid_order::GridOrder>(),
        info::<grid_scatter::GridScatter>(),
        info::<hit_gaps::HitGaps>(),
        info::<import_gbuffer::ImportGbuffer>(),
        info::<integrate::Integrate>(),
        info::<light_batch::LightBatch>(),
        info::<mark_slots::MarkSlots>(),
        info::<measure_drift::MeasureDrift>(),
        info::<pack_points::PackPoints>(),
        info::<positional_update::PositionalUpdate>(),
        info::<primary_rays::PrimaryRays>(),
        info::<ray_bins::RayBins>(),
        info::<ray_order::RayOrder>(),
        info::<ray_scatter::RayScatter>(),
        info::<recycle::Recycle>(),
        info::<recycle_commit::RecycleCommit>(),
        info::<recycle_push::RecyclePush>(),
        info::<reference_accumulate::ReferenceAccumulate>(),
        info::<reference_emitters::ReferenceEmitters>(),
        info::<reference_remaining::ReferenceRemaining>(),
        info::<reference_scatter::ReferenceScatter>(),
        info::<reorder_rays::ReorderRays>(),
        info::<request_rays::RequestRays>(),
        info::<resolve_hits::ResolveHits>(),
        info::<sample_lights::SampleLights>(),
        info::<scan_apply::ScanApply>(),
        info::<scan_blocks::ScanBlocks>(),
        info::<scan_sums::ScanSums>(),
        info::<select_pixels::SelectPixels>(),
        info::<shade_hits::ShadeHits>(),
        info::<share_irradiance::ShareIrradiance>(),
        info::<spawn::Spawn>(),
        info::<spawn_claim::SpawnClaim>(),
        info::<spawn_commit::SpawnCommit>(),
        info::<sum_clamped::SumClamped>(),
        info::<trace_any::TraceAny>(),
        info::<trace_closest::TraceClosest>(),
        info::<update_depth::UpdateDepth>(),
        info::<update_guide::UpdateGuide>(),
        info::<upsample::Upsample>(),
    ]
}
