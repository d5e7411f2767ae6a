// Position, normals, albedo, emission and transform id of each hit. Normals face the ray; emission leaves the front
// only, or both sides of a two-sided material.
import package::affine::{affine_map_point, affine_map_transposed};
import package::invocation::invocation_index;
import package::octahedral::{octahedral_pack, octahedral_unpack};
import package::surface::{SURFACE_EMITTER, SURFACE_OFFSET, surface_miss, surface_pack_albedo};
import package::texture::{TEXTURE_DOUBLE_SIDED, texture_base_color, texture_emission, texture_is_sampled_emitter, texture_uv_at};
import package::types::{Corners, DispatchArgs, Hit, Instance, Material, NONE, Ray, SurfacePoint, Triangle};
import package::vector::{vector_cross, vector_dot, vector_leveled, vector_normalize};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read> hits: array<Hit>;
@group(0) @binding(3) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(4) var<storage, read> instances: array<Instance>;
@group(0) @binding(5) var<storage, read> corners: array<Corners>;
@group(0) @binding(6) var<storage, read> materials: array<Material>;
@if(texels) @group(0) @binding(7) var<storage, read> texels: array<u32>;
@group(0) @binding(8) var<storage, read_write> points: array<SurfacePoint>;

// Magnitude of the numbers that made a position: where each coordinate's rounding error comes from.
fn magnitude(rows: array<vec4<f32>, 3>, reach: vec3<f32>) -> f32 {
    let x = vector_dot(abs(rows[0].xyz), reach) + abs(rows[0].w);
    let y = vector_dot(abs(rows[1].xyz), reach) + abs(rows[1].w);
    let z = vector_dot(abs(rows[2].xyz), reach) + abs(rows[2].w);
    return max(max(x, y), z);
}

fn resolve(direction: vec3<f32>, hit: Hit) -> SurfacePoint {
    let triangle = triangles[hit.triangle];
    let corner = corners[triangle.primitive];
    let material = triangle.material_flags & 0x7fffffffu;
    let to_world = instances[hit.instance].object_to_world;
    let to_object = instances[hit.instance].world_to_object;
    var point: SurfacePoint;
    point.position = affine_map_point(to_world, triangle.v0 + triangle.e1 * hit.u + triangle.e2 * hit.v);
    let reach = abs(triangle.v0) + abs(triangle.e1) + abs(triangle.e2);
    point.offset = magnitude(to_world, reach) * SURFACE_OFFSET;
    // The counter-clockwise side; a mirroring map turns the winding, not the side.
    let area = vector_leveled(vector_cross(triangle.e1, triangle.e2));
    let face = vector_normalize(vector_leveled(affine_map_transposed(to_object, area)));
    let front = vector_dot(face, direction) < 0.0;
    let side = select(-1.0, 1.0, front);
    var normal = face;
    if corner.smooth_ != 0u {
        let a = octahedral_unpack(corner.normals[0]);
        let b = octahedral_unpack(corner.normals[1]);
        let c = octahedral_unpack(corner.normals[2]);
        let mixed = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let mapped = affine_map_transposed(to_object, mixed);
        if vector_dot(mapped, mapped) > 0.0 {
            normal = vector_normalize(mapped);
        }
        // A vertex normal that contradicts the winding is taken for the same side.
        if vector_dot(normal, face) < 0.0 {
            normal = -normal;
        }
    }
    point.geometric_normal = octahedral_pack(face * side);
    point.shading_normal = octahedral_pack(normal * side);
    let uv = texture_uv_at(corner.uvs, hit.u, hit.v);
    var flags = 0u;
    if front || (materials[material].flags & TEXTURE_DOUBLE_SIDED) != 0u {
        point.emission = texture_emission(material, uv);
        flags = select(0u, SURFACE_EMITTER, texture_is_sampled_emitter(material));
    }
    let albedo = surface_pack_albedo(texture_base_color(material, uv).xyz, flags);
    point.albedo_rg = albedo.x;
    point.albedo_b_flags = albedo.y;
    point.transform_id = triangle.transform_id;
    if triangle.transform_id == NONE {
        point.transform_id = instances[hit.instance].transform_id;
    }
    return point;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(workgroup, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let hit = hits[i];
    if hit.instance == NONE {
        points[i] = surface_miss();
    } else {
        points[i] = resolve(rays[i].direction, hit);
    }
}
