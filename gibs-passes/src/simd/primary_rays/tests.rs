//! Wide primary rays have the scalar ones' bits.
use super::super::Avx2;
use super::primary_rays;
use crate::data::Camera;
use crate::stages::primary_rays::primary_each;
use glam::Vec3;

#[test]
fn wide_rays_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    for (width, height) in [(1, 1), (1, 40), (7, 9), (8, 8), (33, 5), (480, 3)] {
        let camera = Camera {
            eye: Vec3::new(1.0, -2.0, 3.5),
            width,
            right: Vec3::new(0.7, 0.1, 0.0),
            height,
            up: Vec3::new(0.0, 0.4, 0.05),
            forward: Vec3::new(0.1, 0.2, -0.97),
            ..Camera::default()
        };
        let all = (width * height) as usize;
        for range in [0..all, all / 3..all, all..all] {
            let (mut each, mut wide) = (vec![], vec![]);
            primary_each(&camera, range.clone(), |i, ray| each.push((i, ray)));
            primary_rays(&camera, range.clone(), |i, ray| wide.push((i, ray)));
            assert_eq!((each.len(), wide.len()), (range.len(), range.len()));
            for ((i, each), (j, wide)) in each.iter().zip(&wide) {
                assert_eq!(i, j);
                assert_eq!(
                    bytemuck::bytes_of(each),
                    bytemuck::bytes_of(wide),
                    "{width}x{height}, {i}: {each:?}, wide {wide:?}"
                );
            }
        }
    }
}
