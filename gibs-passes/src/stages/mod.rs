//! The stages: one file each, with what it reads and writes, the formula with its source, and the CPU kernel.
//! The device kernel of each has the same name in `shaders/stages`.
pub mod allocate_rays;
pub mod batch_args;
pub mod compose;
pub mod continue_paths;
pub mod count_contrasts;
pub mod count_paths;
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
pub mod geometric_normals;
pub mod grid_carry;
pub mod grid_count;
pub mod grid_insert;
pub mod grid_merge;
pub mod grid_order;
pub mod grid_room;
pub mod grid_scatter;
pub mod hit_gaps;
pub mod import_gbuffer;
pub mod integrate;
pub mod light_batch;
pub mod mark_slots;
pub mod measure_drift;
pub mod pack_contrasts;
pub mod pack_pixels;
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
pub mod slot_args;
pub mod spawn;
pub mod spawn_claim;
pub mod spawn_commit;
pub mod sum_clamped;
pub mod trace_any;
pub mod trace_closest;
pub mod update_depth;
pub mod update_guide;
pub mod upsample;

use gibs_graph::StageInfo;

/// Every stage of this crate.
pub fn all() -> Vec<StageInfo> {
    vec![
        StageInfo::of::<allocate_rays::AllocateRays>(),
        StageInfo::of::<batch_args::BatchArgs>(),
        StageInfo::of::<compose::Compose>(),
        StageInfo::of::<continue_paths::ContinuePaths>(),
        StageInfo::of::<count_contrasts::CountContrasts>(),
        StageInfo::of::<count_paths::CountPaths>(),
        StageInfo::of::<count_slots::CountSlots>(),
        StageInfo::of::<debug_discs::DebugDiscs>(),
        StageInfo::of::<debug_surface::DebugSurface>(),
        StageInfo::of::<debug_surfels::DebugSurfels>(),
        StageInfo::of::<drift_blocks::DriftBlocks>(),
        StageInfo::of::<drift_total::DriftTotal>(),
        StageInfo::of::<export_indirect::ExportIndirect>(),
        StageInfo::of::<gap_fill::GapFill>(),
        StageInfo::of::<gather_at_hits::GatherAtHits>(),
        StageInfo::of::<gather_direct::GatherDirect>(),
        StageInfo::of::<gather_surfels::GatherSurfels>(),
        StageInfo::of::<generate_rays::GenerateRays>(),
        StageInfo::of::<geometric_normals::GeometricNormals>(),
        StageInfo::of::<grid_carry::GridCarry>(),
        StageInfo::of::<grid_count::GridCount>(),
        StageInfo::of::<grid_insert::GridInsert>(),
        StageInfo::of::<grid_merge::GridMerge>(),
        StageInfo::of::<grid_order::GridOrder>(),
        StageInfo::of::<grid_room::GridRoom>(),
        StageInfo::of::<grid_scatter::GridScatter>(),
        StageInfo::of::<hit_gaps::HitGaps>(),
        StageInfo::of::<import_gbuffer::ImportGbuffer>(),
        StageInfo::of::<integrate::Integrate>(),
        StageInfo::of::<light_batch::LightBatch>(),
        StageInfo::of::<mark_slots::MarkSlots>(),
        StageInfo::of::<measure_drift::MeasureDrift>(),
        StageInfo::of::<pack_contrasts::PackContrasts>(),
        StageInfo::of::<pack_pixels::PackPixels>(),
        StageInfo::of::<positional_update::PositionalUpdate>(),
        StageInfo::of::<primary_rays::PrimaryRays>(),
        StageInfo::of::<ray_bins::RayBins>(),
        StageInfo::of::<ray_order::RayOrder>(),
        StageInfo::of::<ray_scatter::RayScatter>(),
        StageInfo::of::<recycle::Recycle>(),
        StageInfo::of::<recycle_commit::RecycleCommit>(),
        StageInfo::of::<recycle_push::RecyclePush>(),
        StageInfo::of::<reference_accumulate::ReferenceAccumulate>(),
        StageInfo::of::<reference_emitters::ReferenceEmitters>(),
        StageInfo::of::<reference_remaining::ReferenceRemaining>(),
        StageInfo::of::<reference_scatter::ReferenceScatter>(),
        StageInfo::of::<reorder_rays::ReorderRays>(),
        StageInfo::of::<request_rays::RequestRays>(),
        StageInfo::of::<resolve_hits::ResolveHits>(),
        StageInfo::of::<sample_lights::SampleLights>(),
        StageInfo::of::<scan_apply::ScanApply>(),
        StageInfo::of::<scan_blocks::ScanBlocks>(),
        StageInfo::of::<scan_sums::ScanSums>(),
        StageInfo::of::<select_pixels::SelectPixels>(),
        StageInfo::of::<shade_hits::ShadeHits>(),
        StageInfo::of::<share_irradiance::ShareIrradiance>(),
        StageInfo::of::<slot_args::SlotArgs>(),
        StageInfo::of::<spawn::Spawn>(),
        StageInfo::of::<spawn_claim::SpawnClaim>(),
        StageInfo::of::<spawn_commit::SpawnCommit>(),
        StageInfo::of::<sum_clamped::SumClamped>(),
        StageInfo::of::<trace_any::TraceAny>(),
        StageInfo::of::<trace_closest::TraceClosest>(),
        StageInfo::of::<update_depth::UpdateDepth>(),
        StageInfo::of::<update_guide::UpdateGuide>(),
        StageInfo::of::<upsample::Upsample>(),
    ]
}

/// Whether a stage of this name traces a ray for each of its items.
pub fn traces_rays(stage: &str) -> bool {
    use gibs_graph::Stage;
    [trace_closest::TraceClosest::NAME, trace_any::TraceAny::NAME].contains(&stage)
}
