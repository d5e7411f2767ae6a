//! The wide tests with AVX2 and FMA, where the processor has them.
//!
//! Fused multiply-add serves box tests alone, with margins; triangle tests follow the scalar formula to the bit.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::super::intersect::{BoxRay, FAR_SCALE};
    use super::super::types::{Hit, Ray, WideNode, WidePacket, WideView};
    use super::super::walk::{self, Stack};
    use super::super::wide::Kernel;
    use crate::simd::Avx2;

    type Lanes3 = [__m256; 3];

    /// A ray broadcast to all lanes.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2Ray {
        origin: Lanes3,
        direction: Lanes3,
        inverse: Lanes3,
        /// `origin * inverse`, made larger for near planes and smaller for far planes by more than rounding can do.
        near_offset: Lanes3,
        far_offset: Lanes3,
        t_min: __m256,
        /// Rows of [`WideNode::planes`] that the ray meets first, then last, for each axis.
        planes: [Row; 6],
    }

    /// A row of [`WideNode::planes`]: its offset in floats, one of 0, 8, .. 40.
    #[derive(Clone, Copy, Debug)]
    struct Row(usize);

    impl Row {
        #[inline(always)]
        fn new(axis: usize, upper: bool) -> Self {
            Row(8 * (axis % 3 + 3 * usize::from(upper)))
        }

        #[inline]
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn load(self, node: &WideNode) -> __m256 {
            // SAFETY: the offset leaves eight of the 48 floats, as `new` makes it; the load needs no alignment.
            unsafe { _mm256_loadu_ps(node.planes.as_ptr().cast::<f32>().add(self.0)) }
        }
    }

    impl Avx2 {
        #[inline]
        pub(in super::super) fn closest<F: Fn(u32, u32, f32, f32) -> bool>(
            self,
            view: &WideView,
            ray: &Ray,
            stack: &mut Stack,
            filter: &F,
        ) -> Hit {
            // SAFETY: `self` proves that the processor has the features.
            unsafe { closest(self, view, ray, stack, filter) }
        }

        #[inline]
        pub(in super::super) fn any<F: Fn(u32, u32, f32, f32) -> bool>(
            self,
            view: &WideView,
            ray: &Ray,
            stack: &mut Stack,
            filter: &F,
        ) -> bool {
            // SAFETY: `self` proves that the processor has the features.
            unsafe { any(self, view, ray, stack, filter) }
        }
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn closest<F: Fn(u32, u32, f32, f32) -> bool>(
        kernel: Avx2,
        view: &WideView,
        ray: &Ray,
        stack: &mut Stack,
        filter: &F,
    ) -> Hit {
        walk::closest(kernel, view, ray, stack, filter)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn any<F: Fn(u32, u32, f32, f32) -> bool>(
        kernel: Avx2,
        view: &WideView,
        ray: &Ray,
        stack: &mut Stack,
        filter: &F,
    ) -> bool {
        walk::any(kernel, view, ray, stack, filter)
    }

    impl Kernel for Avx2 {
        type Ray = Avx2Ray;

        #[inline(always)]
        fn prepare(self, ray: &BoxRay, t_min: f32) -> Avx2Ray {
            // SAFETY: `self` proves that the processor has the features.
            unsafe { prepare(ray, t_min) }
        }

        #[inline(always)]
        fn boxes(self, ray: &Avx2Ray, node: &WideNode, limit: f32) -> (u32, [f32; 8]) {
            // SAFETY: `self` proves that the processor has the features.
            unsafe { boxes(ray, node, limit) }
        }

        #[inline(always)]
        fn triangles(self, ray: &Avx2Ray, packet: &WidePacket, limit: f32) -> u32 {
            // SAFETY: `self` proves that the processor has the features.
            unsafe { triangles(ray, packet, limit) }
        }

        #[inline(always)]
        fn prefetch<T>(self, soon: &T) {
            let start = std::ptr::from_ref(soon).cast::<i8>();
            for line in (0..size_of::<T>()).step_by(64) {
                // SAFETY: a prefetch reads nothing; the address lies within the referenced value.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
            }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn all(v: glam::Vec3) -> Lanes3 {
        [
            _mm256_set1_ps(v.x),
            _mm256_set1_ps(v.y),
            _mm256_set1_ps(v.z),
        ]
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn prepare(ray: &BoxRay, t_min: f32) -> Avx2Ray {
        // The fused test computes `x * inverse - offset`; against the scalar `(x - origin) * inverse` it errs by half
        // an ulp of the offset and a few of the result. The latter the callers' limits and FAR_SCALE cover.
        let offset = ray.origin * ray.inverse;
        let margin = offset.abs() * (4.0 * f32::EPSILON);
        let near = |inverse: f32, axis| Row::new(axis, inverse < 0.0);
        let far = |inverse: f32, axis| Row::new(axis, inverse >= 0.0);
        let inverse = ray.inverse;
        Avx2Ray {
            origin: all(ray.origin),
            direction: all(ray.direction),
            inverse: all(ray.inverse),
            near_offset: all(offset + margin),
            far_offset: all(offset - margin),
            t_min: _mm256_set1_ps(t_min),
            planes: [
                near(inverse.x, 0),
                near(inverse.y, 1),
                near(inverse.z, 2),
                far(inverse.x, 0),
                far(inverse.y, 1),
                far(inverse.z, 2),
            ],
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn load(lanes: &[f32; 8]) -> __m256 {
        // SAFETY: the load reads the eight floats of the array and needs no alignment.
        unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn boxes(ray: &Avx2Ray, node: &WideNode, limit: f32) -> (u32, [f32; 8]) {
        // `max` and `min` return their second operand where the first is not a number.
        let near = |axis: usize| {
            let planes = ray.planes[axis].load(node);
            _mm256_fmsub_ps(planes, ray.inverse[axis], ray.near_offset[axis])
        };
        let far = |axis: usize| {
            let planes = ray.planes[axis + 3].load(node);
            _mm256_fmsub_ps(planes, ray.inverse[axis], ray.far_offset[axis])
        };
        let entry = _mm256_max_ps(
            _mm256_max_ps(near(0), near(1)),
            _mm256_max_ps(near(2), ray.t_min),
        );
        let exit = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), far(2));
        let exit = _mm256_mul_ps(exit, _mm256_set1_ps(FAR_SCALE * 1.000_002));
        let last = _mm256_min_ps(exit, _mm256_set1_ps(limit));
        let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, last));
        let mut distances = [0.0; 8];
        // SAFETY: the store writes the eight floats of the array and needs no alignment.
        unsafe { _mm256_storeu_ps(distances.as_mut_ptr(), entry) };
        (mask as u32, distances)
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn cross(a: &Lanes3, b: &Lanes3) -> Lanes3 {
        let difference =
            |a0, b0, a1, b1| _mm256_sub_ps(_mm256_mul_ps(a0, b0), _mm256_mul_ps(a1, b1));
        [
            difference(a[1], b[2], a[2], b[1]),
            difference(a[2], b[0], a[0], b[2]),
            difference(a[0], b[1], a[1], b[0]),
        ]
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn dot(a: &Lanes3, b: &Lanes3) -> __m256 {
        let xy = _mm256_add_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1]));
        _mm256_add_ps(xy, _mm256_mul_ps(a[2], b[2]))
    }

    /// [`super::super::intersect::intersect_triangle`], operation for operation.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn triangles(ray: &Avx2Ray, packet: &WidePacket, limit: f32) -> u32 {
        let (zero, minus) = (_mm256_setzero_ps(), _mm256_set1_ps(-0.0));
        let e1 = [
            load(&packet.e1[0]),
            load(&packet.e1[1]),
            load(&packet.e1[2]),
        ];
        let e2 = [
            load(&packet.e2[0]),
            load(&packet.e2[1]),
            load(&packet.e2[2]),
        ];
        let n = cross(&e1, &e2);
        let c = [
            _mm256_sub_ps(load(&packet.v0[0]), ray.origin[0]),
            _mm256_sub_ps(load(&packet.v0[1]), ray.origin[1]),
            _mm256_sub_ps(load(&packet.v0[2]), ray.origin[2]),
        ];
        let r = cross(&c, &ray.direction);
        let det = dot(&ray.direction, &n);
        let sign = _mm256_and_ps(det, minus);
        let size = _mm256_andnot_ps(minus, det);
        let u = _mm256_xor_ps(dot(&e2, &r), sign);
        let v = _mm256_xor_ps(dot(&e1, &r), _mm256_xor_ps(sign, minus));
        let inside = _mm256_and_ps(
            _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_GE_OQ>(u, zero),
                _mm256_cmp_ps::<_CMP_GE_OQ>(v, zero),
            ),
            _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_add_ps(u, v), size),
                _mm256_cmp_ps::<_CMP_GT_OQ>(size, zero),
            ),
        );
        if _mm256_movemask_ps(inside) == 0 {
            return 0;
        }
        let t = _mm256_div_ps(_mm256_xor_ps(dot(&c, &n), sign), size);
        let between = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(t, ray.t_min),
            _mm256_cmp_ps::<_CMP_LE_OQ>(t, _mm256_set1_ps(limit)),
        );
        _mm256_movemask_ps(_mm256_and_ps(inside, between)) as u32
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod other {
    use super::super::types::{Hit, Ray, WideView};
    use super::super::walk::Stack;
    use crate::simd::Avx2;

    impl Avx2 {
        pub(in super::super) fn closest<F>(
            self,
            _: &WideView,
            _: &Ray,
            _: &mut Stack,
            _: &F,
        ) -> Hit {
            match self {}
        }

        pub(in super::super) fn any<F>(self, _: &WideView, _: &Ray, _: &mut Stack, _: &F) -> bool {
            match self {}
        }
    }
}
