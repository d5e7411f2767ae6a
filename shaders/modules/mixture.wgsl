// Where a surfel's rays go: over its cosine lobe, or to points on emissive triangles, weighted by the balance heuristic
// (Veach 1997, section 9.2.2).
import package::hash::HASH_ALMOST_ONE;

/// Share of the rays that go to emitters, in a scene that has some.
const MIXTURE_TO_EMITTERS: f32 = 1.0 / 3.0;
/// A ray to an emitter ends this share of its length beyond it, and counts as arrived this share before it.
const MIXTURE_SLACK: f32 = 1.0 / 4096.0;
const MIXTURE_FRAC_1_PI: f32 = 0.31830987;

/// Whether ray `index` of a surfel goes to an emitter: a share of any run of indices, by the golden ratio's sequence.
fn mixture_goes_to_emitter(index: u32, shift: u32) -> bool {
    return index * 0x9e3779b9u + shift < 1431655808u;
}

/// Density of the rays over the lobe at this cosine, 1/sr, with or without emitters to share with.
fn mixture_lobe_density(cosine: f32, emitters: bool) -> f32 {
    // One constant, because compilers join two.
    let scale = select(MIXTURE_FRAC_1_PI, MIXTURE_FRAC_1_PI * (1.0 - MIXTURE_TO_EMITTERS), emitters);
    return max(cosine, 0.0) * scale;
}

/// The density of the lobe where `guided` of its rays follow a guide with density `guide` there.
fn mixture_guided_density(cosine: f32, guide: f32, guided: f32, emitters: bool) -> f32 {
    let share = select(1.0, 1.0 - MIXTURE_TO_EMITTERS, emitters);
    let lobe = max(cosine, 0.0) * MIXTURE_FRAC_1_PI;
    return (lobe + (guide - lobe) * guided) * share;
}

/// Whether a ray follows the guide, and what is left of the number that decides it.
struct MixtureChoice {
    guided: bool,
    left: f32,
}

/// The choice by `u` in `[0, 1)`, where `guided` of the rays follow the guide.
fn mixture_follow_guide(u: f32, guided: f32) -> MixtureChoice {
    if u < guided {
        return MixtureChoice(true, min(u / guided, HASH_ALMOST_ONE));
    }
    return MixtureChoice(false, min((u - guided) / (1.0 - guided), HASH_ALMOST_ONE));
}

/// What a sample counts: the cosine lobe's density over that of the mixture.
fn mixture_weight(cosine: f32, lobe: f32, emitter: f32) -> f32 {
    let density = lobe + MIXTURE_TO_EMITTERS * emitter;
    if density > 0.0 {
        return max(cosine, 0.0) * MIXTURE_FRAC_1_PI / density;
    }
    return 0.0;
}
