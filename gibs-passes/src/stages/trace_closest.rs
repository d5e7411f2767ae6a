//! `*/ray_trace`: the closest surface along each ray.
use crate::accel::{AccelView, WideView, scalar, wide};
use crate::data::{BvhNode, Corners, Hit, Instance, Material, Ray, Triangle, WideNode, WidePacket};
use crate::shared::texture;
use gibs_graph::{AccelerationInstance, DispatchArgs, Workgroup, stage};
use glam::Vec2;

stage! {
    /// Finds the closest hit of each ray in the two-level BVH; of equal distances the smallest (instance, triangle).
    pub stage TraceClosest {
        wgsl: gibs_shaders::stages::TRACE_CLOSEST,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read nodes: BvhNode,
            read triangles: Triangle,
            read instances: Instance,
            optional_read corners: Corners,
            optional_read materials: Material,
            optional_read texels: u32,
            read rays: Ray,
            write hits: Hit,
            optional_acceleration structure: AccelerationInstance,
            host_only wide_nodes: WideNode,
            host_only wide_packets: WidePacket,
        },
        cpu: scalar_kernel,
        wide: Some(wide_kernel),
    }
}

/// Texture coordinates of a point on a triangle.
#[inline]
pub fn uv_at(corners: &Corners, u: f32, v: f32) -> Vec2 {
    corners.uvs[0] * (1.0 - u - v) + corners.uvs[1] * u + corners.uvs[2] * v
}

/// The alpha test of a traversal.
#[inline]
pub fn stops<'a>(
    ray: &'a Ray,
    triangles: &'a [Triangle],
    corners: &'a [Corners],
    materials: &'a [Material],
    texels: &'a [u32],
) -> impl Fn(u32, u32, f32, f32) -> bool + 'a {
    move |_, triangle, u, v| {
        let t = &triangles[triangle as usize];
        let uv = uv_at(&corners[t.primitive as usize], u, v);
        texture::stops(&materials[t.material() as usize], texels, uv, ray, triangle)
    }
}

fn scalar_kernel(p: &Views<'_>, group: Workgroup) {
    let view = AccelView {
        nodes: p.nodes.slice(),
        triangles: p.triangles.slice(),
        instances: p.instances.slice(),
    };
    for i in group.range(p.batch.count) {
        let i = p.batch.first as usize + i;
        let ray = &p.rays[i];
        let filter = stops(ray, &p.triangles, &p.corners, &p.materials, &p.texels);
        p.hits.set(i, scalar::closest(&view, ray, filter));
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let view = WideView {
        nodes: p.wide_nodes.slice(),
        packets: p.wide_packets.slice(),
        instances: p.instances.slice(),
    };
    let mut tracer = wide::Tracer::new();
    for i in group.range(p.batch.count) {
        let i = p.batch.first as usize + i;
        let ray = &p.rays[i];
        let filter = stops(ray, &p.triangles, &p.corners, &p.materials, &p.texels);
        p.hits.set(i, tracer.closest(&view, ray, filter));
    }
}
