// Positions in a dispatch as one number.

/// Workgroup, x running fastest.
fn invocation_group(workgroup: vec3<u32>, groups: vec3<u32>) -> u32 {
    return (workgroup.z * groups.y + workgroup.y) * groups.x + workgroup.x;
}

/// Invocation, of workgroups with `lanes` invocations each.
fn invocation_index(workgroup: vec3<u32>, groups: vec3<u32>, lanes: u32, lane: u32) -> u32 {
    return invocation_group(workgroup, groups) * lanes + lane;
}
