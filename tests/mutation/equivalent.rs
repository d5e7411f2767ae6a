//! Mutants that do what the kernel does, so that nothing could tell them from it.
//!
//! Each is one that survived and was then shown, by its reason here, to give the same results in all frames that this
//! library builds. They do not count as survivors. One that is caught all the same is an error of this list.

/// Mutants with one reason.
struct Equivalent {
    /// Kernels with their features, or with an asterisk the beginning of that.
    kernels: &'static [&'static str],
    /// Beginning of the description: function and change.
    what: &'static str,
    /// Part of the changed line.
    line: &'static str,
    reason: &'static str,
}

const EQUIVALENT: [Equivalent; 33] = [
    Equivalent {
        kernels: &["*"],
        what: "octahedral_fold: Multiply to Divide",
        line: "octahedral_sign",
        reason: "the factor is 1 or -1",
    },
    Equivalent {
        kernels: &["trace_*"],
        what: "trace_walk: no store",
        line: "direction = ray.direction;",
        reason: "only the bottom level asks for it, and it is set where that is entered",
    },
    Equivalent {
        kernels: &["trace_*"],
        what: "trace_walk: no store",
        line: "base = 0u;",
        reason: "only the bottom level asks for it, and it is set where that is entered",
    },
    Equivalent {
        kernels: &["trace_any*"],
        what: "trace_walk: Less to LessEqual",
        line: "let before = ",
        reason: "the walk ends at the first hit, and before that there is no other to come before",
    },
    Equivalent {
        kernels: &["share_irradiance*"],
        what: "constant SHARING_REACH: U32(2) to U32(3)",
        line: "",
        reason: "naga has put the number in wherever it is multiplied; what is left rejects fewer surfels beforehand, of no weight",
    },
    Equivalent {
        kernels: &["debug_discs with guides"],
        what: "weighted: ",
        line: "",
        reason: "guides are bound where the view shows them, which asks for the nearest surfel alone",
    },
    Equivalent {
        kernels: &["debug_surface with cells"],
        what: "main: no store",
        line: "DebugPixel(f32(point.transform_id), light)",
        reason: "cells are bound where the view shows them, which is not that of nodes",
    },
    Equivalent {
        kernels: &["debug_surface with cells"],
        what: "part: ",
        line: "",
        reason: "cells are bound where the view shows them, which is not that of the seven grids",
    },
    Equivalent {
        kernels: &["debug_surfels*"],
        what: "frames_unseen: U32(0)",
        line: "",
        reason: "the view of unseen frames binds them",
    },
    Equivalent {
        kernels: &["debug_surfels*"],
        what: "born: U32(0)",
        line: "",
        reason: "the view of ages binds births",
    },
    Equivalent {
        kernels: &["debug_discs", "debug_discs with depths"],
        what: "guide_at: F32(-1.0)",
        line: "",
        reason: "the view of guides binds them",
    },
    Equivalent {
        kernels: &["debug_discs", "debug_discs with guides"],
        what: "mean_distance: F32(-1.0)",
        line: "",
        reason: "the view of depth functions binds them",
    },
    Equivalent {
        kernels: &[
            "debug_surfels",
            "debug_surfels with irradiance",
            "debug_surfels with irradiance, spans",
            "debug_surfels with unseen",
        ],
        what: "value: ",
        line: "frame.number - born(i)",
        reason: "the view of ages binds births, and no other does",
    },
    Equivalent {
        kernels: &[
            "debug_surfels with births",
            "debug_surfels with irradiance",
            "debug_surfels with irradiance, spans",
            "debug_surfels with unseen",
        ],
        what: "value: ",
        line: "pose.radius / (camera.pixel_angle * distance)",
        reason: "the view of radii binds none of these",
    },
    Equivalent {
        kernels: &["continue_paths*"],
        what: "main: Less to LessEqual",
        line: "hash_unit(third) < MIXTURE_TO_EMITTERS",
        reason: "the numbers are multiples of 2^-24, and a third in 32 bits is none",
    },
    Equivalent {
        kernels: &["gap_fill*"],
        what: "is_fine: sign of a difference",
        line: "let d = pose.position - point;",
        reason: "only its length is asked for",
    },
    Equivalent {
        kernels: &["compose*"],
        what: "main: GreaterEqual to Greater",
        line: "i >= batch.count",
        reason: "one thread more does what the last one does: all buffers end there, and beyond the end is their last element",
    },
    Equivalent {
        kernels: &["positional_update"],
        what: "main: ",
        line: "clearance = min(clearance, SURFEL_SHRINKS_TO * pose.radius)",
        reason: "without depth functions no surfel is crowded",
    },
    Equivalent {
        kernels: &["*"],
        what: "lookup_gather: LessEqual to Less",
        line: "if weight <= 0.0 || light[id].trust == 0.0 {",
        reason: "a surfel of no weight is left out two lines on, as one of too little",
    },
    Equivalent {
        kernels: &["debug_discs*"],
        what: "weighted: Bool(true) to Bool(false)",
        line: "if weight <= 0.0 || value < 0.0 {",
        reason: "a surfel of no weight is left out two lines on, as one of too little",
    },
    Equivalent {
        kernels: &["*"],
        what: "estimator_to_forget: Less to LessEqual",
        line: "all_surfels < 0.0",
        reason: "where all surfels together do not drift, their sign counts for nothing",
    },
    Equivalent {
        kernels: &["trace_*"],
        what: "trace_walk: U32(0) to U32(1)",
        line: "(triangle.material_flags & TRACE_ALPHA_TEST) == 0u",
        reason: "all triangles are asked whether they stop the ray, and those without an alpha test do",
    },
    Equivalent {
        kernels: &["*"],
        what: "main: element 0 to 1",
        line: "counters[0]",
        reason: "there is one element, and what is beyond the end is the last one",
    },
    Equivalent {
        kernels: &["*"],
        what: "main: element 0 to 1",
        line: "total[0]",
        reason: "there is one element, and what is beyond the end is the last one",
    },
    Equivalent {
        kernels: &["trace_closest*", "trace_any*"],
        what: "intersect_triangle: Multiply to Divide",
        line: "* turn",
        reason: "the factor is 1 or -1",
    },
    Equivalent {
        kernels: &["trace_*"],
        what: "trace_walk: index 0 to 1",
        line: "near = entry.x;",
        reason: "only leaves of the top level ask for it, and this one is of a bottom level",
    },
    Equivalent {
        kernels: &["*"],
        what: "lookup_gather: Bool(true) to Bool(false)",
        line: "if weight <= 0.0 || light[id].trust == 0.0 {",
        reason: "a surfel of no weight is left out two lines on, as one of too little",
    },
    Equivalent {
        kernels: &["*"],
        what: "grid_high: Greater to GreaterEqual",
        line: "x > 0.0",
        reason: "nothing divided by either is nothing",
    },
    Equivalent {
        kernels: &["*"],
        what: "grid_cell: Less to LessEqual",
        line: "axes.x < 0.0",
        reason: "it is the longest component of a place outside the centre cube, and not 0",
    },
    Equivalent {
        kernels: &["reference_accumulate*"],
        what: "meet: U32(0) to U32(1)",
        line: "(point.albedo_b_flags & SURFACE_EMITTER) != 0u",
        reason: "what does not emit is then asked for its density as well, which is none",
    },
    Equivalent {
        kernels: &["reference_remaining"],
        what: "main: no store",
        line: "atomicStore(&unfinished, 0u);",
        reason: "WGSL promises that workgroup memory begins as zeros, and the SPIR-V asks for it",
    },
    Equivalent {
        kernels: &["sum_clamped"],
        what: "main: U32(0) to U32(1)",
        line: "if lane == 0u {",
        reason: "another thread writes the same",
    },
    Equivalent {
        kernels: &["debug_surfels with irradiance, spans"],
        what: "constant LEAST_DISTANCE",
        line: "",
        reason: "the view of radii binds none of these",
    },
];

/// Why a mutant is no other kernel, if it is listed. `kernel` is written as reports do.
pub fn reason(kernel: &str, what: &str) -> Option<&'static str> {
    let fits = |e: &&Equivalent| {
        let is_kernel = |name: &&str| match name.strip_suffix('*') {
            Some(beginning) => kernel.starts_with(beginning),
            None => kernel == *name,
        };
        e.kernels.iter().any(is_kernel) && what.starts_with(e.what) && what.contains(e.line)
    };
    EQUIVALENT.iter().find(fits).map(|e| e.reason)
}
