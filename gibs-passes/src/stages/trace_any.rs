//! `*/shadow`: does anything stand along each ray?
use super::trace_closest::stops;
use crate::accel::{AccelView, WideView, scalar, wide};
use crate::data::{BvhNode, Corners, Instance, Material, Ray, Triangle, WideNode, WidePacket};
use gibs_graph::{AccelerationInstance, DispatchArgs, Workgroup, stage};

stage! {
    /// Writes 1 for each ray that nothing stops between `t_min` and `t_max`, else 0.
    pub stage TraceAny {
        wgsl: gibs_shaders::stages::TRACE_ANY,
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
            write visible: u32,
            optional_acceleration structure: AccelerationInstance,
            host_only wide_nodes: WideNode,
            host_only wide_packets: WidePacket,
        },
        cpu: scalar_kernel,
        wide: Some(wide_kernel),
    }
}

fn scalar_kernel(p: &Views<'_>, group: Workgroup) {
    let view = AccelView {
        nodes: p.nodes.slice(),
        triangles: p.triangles.slice(),
        instances: p.instances.slice(),
    };
    for i in group.range(p.batch.count) {
        let ray = &p.rays[i];
        let filter = stops(ray, &p.triangles, &p.corners, &p.materials, &p.texels);
        p.visible.set(
            i,
            u32::from(!(ray.t_max > 0.0 && scalar::any(&view, ray, filter))),
        );
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
        let ray = &p.rays[i];
        let filter = stops(ray, &p.triangles, &p.corners, &p.materials, &p.texels);
        p.visible.set(
            i,
            u32::from(!(ray.t_max > 0.0 && tracer.any(&view, ray, filter))),
        );
    }
}
