// The drift of a workgroup's lanes, summed in a fixed order.
import package::estimator::estimator_plus_drift;
import package::types::Drift;

/// Lanes of a workgroup that sums.
const DRIFT_SUM_LANES: u32 = 256u;

var<workgroup> drift_sums: array<Drift, 256>;

/// The sum over all lanes, in pairs that are half of them apart. To be called once, by all of them; the first has the sum.
fn drift_sum_in_pairs(lane: u32, own: Drift) -> Drift {
    drift_sums[lane] = own;
    workgroupBarrier();
    for (var half = DRIFT_SUM_LANES / 2u; half > 0u; half /= 2u) {
        if lane < half {
            drift_sums[lane] = estimator_plus_drift(drift_sums[lane], drift_sums[lane + half]);
        }
        workgroupBarrier();
    }
    return drift_sums[0];
}
