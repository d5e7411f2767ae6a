//! The walk over both levels of the wide tree, for any kernel.
use super::intersect::{BoxRay, InstanceRay, TriangleHit};
use super::types::{Hit, Ray, WideNode, WideView};
use super::wide::Kernel;

/// Entries of the stack: seven for each level above the current node, over both levels of the tree.
const STACK_SIZE: usize = 7 * super::level::STACK_SIZE + 8;

/// Slack of distance limits: the distances of SIMD box tests may exceed those of the scalar test by rounding.
const LIMIT_SCALE: f32 = 1.0 + 16.0 * f32::EPSILON;

/// Children to visit: the bits of the entry distance above the child word. Distances are not negative, so that
/// entries order by distance.
#[derive(Clone, Debug)]
pub(super) struct Stack([u64; STACK_SIZE]);

impl Default for Stack {
    fn default() -> Self {
        Stack([0; STACK_SIZE])
    }
}

#[inline(always)]
fn entry(near: f32, word: u32) -> u64 {
    (u64::from(near.to_bits()) << 32) | u64::from(word)
}

#[inline(always)]
fn entry_near(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

/// What a traversal looks for.
trait Goal {
    /// Whether hits are sought in order of distance.
    const ORDERED: bool;
    /// Distance beyond which nothing matters; negative when the search is over.
    fn limit(&self) -> f32;
    fn found(&mut self, instance: u32, triangle: u32, hit: TriangleHit, needs_filter: bool);
}

struct Closest<'a, F> {
    best: Hit,
    filter: &'a F,
}

impl<F: Fn(u32, u32, f32, f32) -> bool> Goal for Closest<'_, F> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn found(&mut self, instance: u32, triangle: u32, hit: TriangleHit, needs_filter: bool) {
        if self.best.loses_to(hit.t, instance, triangle)
            && (!needs_filter || (self.filter)(instance, triangle, hit.u, hit.v))
        {
            self.best = Hit {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                triangle,
                instance,
            };
        }
    }
}

struct Any<'a, F> {
    occluded: bool,
    limit: f32,
    filter: &'a F,
}

impl<F: Fn(u32, u32, f32, f32) -> bool> Goal for Any<'_, F> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn found(&mut self, instance: u32, triangle: u32, hit: TriangleHit, needs_filter: bool) {
        if hit.t <= self.limit && (!needs_filter || (self.filter)(instance, triangle, hit.u, hit.v))
        {
            self.occluded = true;
            self.limit = -1.0;
        }
    }
}

#[inline(always)]
pub(super) fn closest<K: Kernel, F: Fn(u32, u32, f32, f32) -> bool>(
    kernel: K,
    view: &WideView,
    ray: &Ray,
    stack: &mut Stack,
    filter: &F,
) -> Hit {
    let mut goal = Closest {
        best: Hit::miss(ray.t_max),
        filter,
    };
    trace(kernel, view, ray, stack, &mut goal);
    goal.best
}

#[inline(always)]
pub(super) fn any<K: Kernel, F: Fn(u32, u32, f32, f32) -> bool>(
    kernel: K,
    view: &WideView,
    ray: &Ray,
    stack: &mut Stack,
    filter: &F,
) -> bool {
    let mut goal = Any {
        occluded: false,
        limit: ray.t_max,
        filter,
    };
    trace(kernel, view, ray, stack, &mut goal);
    goal.occluded
}

/// Walks the top level and, from its leaves, the bottom levels.
#[inline(always)]
fn trace<K: Kernel, G: Goal>(
    kernel: K,
    view: &WideView,
    ray: &Ray,
    stack: &mut Stack,
    goal: &mut G,
) {
    let Some(world) = BoxRay::new(ray.origin, ray.direction) else {
        return;
    };
    let lanes = kernel.prepare(&world, ray.t_min);
    let mut size = 0;
    let mut word = 0;
    loop {
        if word & WideNode::LEAF == 0 {
            let node = &view.nodes[word as usize];
            let (mask, near) = kernel.boxes(&lanes, node, goal.limit() * LIMIT_SCALE);
            // A leaf is known by its place, because its box is needed again.
            let place = WideNode::LEAF | (word << 3);
            let name = |lane: usize| {
                let child = node.children[lane];
                if child & WideNode::LEAF == 0 {
                    return child;
                }
                place | lane as u32
            };
            if let Some(next) = descend::<G>(mask, &near, name, stack, &mut size) {
                word = next;
                continue;
            }
        } else {
            enter_instance(
                kernel,
                view,
                ray,
                &world,
                word & !WideNode::LEAF,
                stack,
                size,
                goal,
            );
        }
        match pop(stack, &mut size, 0, goal.limit()) {
            Some(next) => word = next,
            None => return,
        }
    }
}

#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "state of one loop, kept in registers"
)]
fn enter_instance<K: Kernel, G: Goal>(
    kernel: K,
    view: &WideView,
    ray: &Ray,
    world: &BoxRay,
    place: u32,
    stack: &mut Stack,
    base: usize,
    goal: &mut G,
) {
    let (node, lane) = (&view.nodes[(place >> 3) as usize], (place & 7) as usize);
    let index = node.children[lane] & !WideNode::LEAF;
    let corner = |first: usize| {
        glam::Vec3::new(
            node.planes[first][lane],
            node.planes[first + 1][lane],
            node.planes[first + 2][lane],
        )
    };
    let Some(near) = world.enter(corner(0), corner(3), ray.t_min) else {
        return;
    };
    let Some(local) = InstanceRay::new(ray, &view.instances[index as usize], near) else {
        return;
    };
    let lanes = kernel.prepare(&local.ray, ray.t_min);
    let mut size = base;
    let mut word = node.sources[lane];
    loop {
        if word & WideNode::LEAF == 0 {
            let node = &view.nodes[word as usize];
            let (mask, near) = kernel.boxes(&lanes, node, goal.limit() * LIMIT_SCALE);
            let name = |lane: usize| {
                let child = node.children[lane];
                prefetch(kernel, view, child);
                child
            };
            if let Some(next) = descend::<G>(mask, &near, name, stack, &mut size) {
                word = next;
                continue;
            }
        } else {
            let packet = &view.packets[(word & !WideNode::LEAF) as usize];
            let mut mask = kernel.triangles(&lanes, packet, goal.limit());
            while mask != 0 {
                let lane = mask.trailing_zeros();
                mask &= mask - 1;
                if let Some(hit) = local.hit(&packet.triangle(lane as usize)) {
                    let needs_filter = packet.alpha & (1 << lane) != 0;
                    goal.found(index, packet.first + lane, hit, needs_filter);
                }
            }
        }
        match pop(stack, &mut size, base, goal.limit()) {
            Some(next) => word = next,
            None => return,
        }
    }
}

/// Asks for the memory of a node or packet of a bottom level.
#[inline(always)]
fn prefetch<K: Kernel>(kernel: K, view: &WideView, child: u32) {
    if child & WideNode::LEAF == 0 {
        kernel.prefetch(&view.nodes[child as usize]);
    } else {
        kernel.prefetch(&view.packets[(child & !WideNode::LEAF) as usize]);
    }
}

/// Next child to visit, the nearest; the others go on the stack, the farthest lowest.
#[inline(always)]
fn descend<G: Goal>(
    mut mask: u32,
    near: &[f32; 8],
    name: impl Fn(usize) -> u32,
    stack: &mut Stack,
    size: &mut usize,
) -> Option<u32> {
    if mask == 0 {
        return None;
    }
    if !G::ORDERED {
        loop {
            let next = name(mask.trailing_zeros() as usize & 7);
            mask &= mask - 1;
            if mask == 0 {
                return Some(next);
            }
            stack.0[*size] = u64::from(next);
            *size += 1;
        }
    }
    let mut take = || {
        let lane = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        (entry(near[lane], name(lane)), mask != 0)
    };
    let (mut first, more) = take();
    if !more {
        return Some(first as u32);
    }
    let (second, more) = take();
    let (nearer, farther) = (first.min(second), first.max(second));
    first = nearer;
    let base = *size;
    stack.0[base] = farther;
    *size = base + 1;
    if !more {
        return Some(first as u32);
    }
    loop {
        let (next, more) = take();
        let (nearer, moved) = (first.min(next), first.max(next));
        first = nearer;
        // Insertion keeps the stack's new part ordered, the nearest on top.
        let mut place = *size;
        while place > base && stack.0[place - 1] < moved {
            stack.0[place] = stack.0[place - 1];
            place -= 1;
        }
        stack.0[place] = moved;
        *size += 1;
        if !more {
            return Some(first as u32);
        }
    }
}

/// Takes the next child off the stack that still matters, down to `base`.
#[inline(always)]
fn pop(stack: &Stack, size: &mut usize, base: usize, limit: f32) -> Option<u32> {
    let limit = limit * LIMIT_SCALE;
    while *size > base {
        *size -= 1;
        let next = stack.0[*size];
        if entry_near(next) <= limit {
            return Some(next as u32);
        }
    }
    None
}
