//! Stack traversal of the binary tree: the oracle of the other traversals, in the order a simple GPU loop has.
use super::intersect::{BoxRay, InstanceRay};
use super::level::STACK_SIZE;
use super::types::{AccelView, BvhNode, Hit, Ray};

/// Limit that ends a walk: no box is entered below zero.
const STOP: f32 = -1.0;

/// Closest hit of a ray.
///
/// `filter(instance, triangle, u, v)` decides whether a hit of a triangle with
/// [`super::Triangle::ALPHA_TEST`] counts; it must be a pure function.
pub fn closest(view: &AccelView, ray: &Ray, filter: impl Fn(u32, u32, f32, f32) -> bool) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    trace(view, ray, |instance, triangle, hit, needs_filter| {
        if best.loses_to(hit.t, instance, triangle)
            && (!needs_filter || filter(instance, triangle, hit.u, hit.v))
        {
            best = Hit {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                triangle,
                instance,
            };
        }
        best.t
    });
    best
}

/// Whether a ray hits anything. The filter is that of [`closest`].
pub fn any(view: &AccelView, ray: &Ray, filter: impl Fn(u32, u32, f32, f32) -> bool) -> bool {
    let mut occluded = false;
    trace(view, ray, |instance, triangle, hit, needs_filter| {
        occluded |=
            hit.t <= ray.t_max && (!needs_filter || filter(instance, triangle, hit.u, hit.v));
        if occluded { STOP } else { ray.t_max }
    });
    occluded
}

/// Reports hits to `found(instance, triangle, hit, needs filter)`, which returns the distance beyond which hits no
/// longer matter.
#[inline(always)]
fn trace(
    view: &AccelView,
    ray: &Ray,
    mut found: impl FnMut(u32, u32, super::intersect::TriangleHit, bool) -> f32,
) {
    let Some(world) = BoxRay::new(ray.origin, ray.direction) else {
        return;
    };
    walk(
        view.nodes,
        0,
        &world,
        ray.t_min,
        ray.t_max,
        |leaf, near, limit| {
            let instance = &view.instances[leaf.first as usize];
            let Some(local) = InstanceRay::new(ray, instance, near) else {
                return limit;
            };
            walk(
                view.nodes,
                instance.root,
                &local.ray,
                ray.t_min,
                limit,
                |node, _, mut limit| {
                    for index in node.first..node.first + node.count {
                        let triangle = &view.triangles[index as usize];
                        if let Some(hit) = local.hit(triangle)
                            && hit.t <= limit
                        {
                            limit = found(leaf.first, index, hit, triangle.needs_alpha_test());
                        }
                    }
                    limit
                },
            )
        },
    );
}

/// Visits the leaves of one level whose boxes the ray enters no later than `limit`, nearer child first. `leaf(node,
/// entry, limit)` returns the new limit, as does the whole walk.
#[inline(always)]
fn walk(
    nodes: &[BvhNode],
    root: u32,
    ray: &BoxRay,
    t_min: f32,
    mut limit: f32,
    mut leaf: impl FnMut(&BvhNode, f32, f32) -> f32,
) -> f32 {
    let mut stack = [(0_u32, 0_f32); STACK_SIZE];
    let mut size = 0;
    let enter = |index: u32| {
        let node = &nodes[index as usize];
        ray.enter(node.min, node.max, t_min)
    };
    let mut current = enter(root)
        .filter(|&near| near <= limit)
        .map(|near| (root, near));
    while let Some((index, near)) = current {
        let node = &nodes[index as usize];
        current = None;
        if node.count > 0 {
            limit = leaf(node, near, limit);
        } else {
            let left = enter(node.first)
                .filter(|&t| t <= limit)
                .map(|t| (node.first, t));
            let right = enter(node.first + 1)
                .filter(|&t| t <= limit)
                .map(|t| (node.first + 1, t));
            current = match (left, right) {
                (Some(a), Some(b)) => {
                    let (nearer, farther) = if b.1 < a.1 { (b, a) } else { (a, b) };
                    stack[size] = farther;
                    size += 1;
                    Some(nearer)
                }
                (a, b) => a.or(b),
            };
        }
        while current.is_none() && size > 0 {
            size -= 1;
            current = Some(stack[size]).filter(|entry| entry.1 <= limit);
        }
    }
    limit
}
