//! Building, rebuilding and refitting trees.
use super::*;

#[test]
fn device_structs_have_the_layout_of_shaders() {
    use std::mem::{offset_of, size_of};
    assert_eq!((size_of::<BvhNode>(), offset_of!(BvhNode, max)), (32, 16));
    assert_eq!(
        (
            size_of::<Triangle>(),
            offset_of!(Triangle, e1),
            offset_of!(Triangle, e2)
        ),
        (48, 16, 32)
    );
    assert_eq!(
        (size_of::<Instance>(), offset_of!(Instance, root)),
        (112, 96)
    );
    assert_eq!((size_of::<Ray>(), offset_of!(Ray, direction)), (32, 16));
    assert_eq!(size_of::<Hit>(), 20);
    assert_eq!((size_of::<WideNode>(), size_of::<WidePacket>()), (256, 320));
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let mut random = Random(7);
    let meshes = [
        Mesh::soup(&mut random, 12_000, 0.05),
        Mesh::soup(&mut random, 10, 0.5),
        Mesh::soup(&mut random, 3_000, 0.5),
    ];
    let placements: Vec<InstanceInput> = (0..40)
        .map(|i| {
            instance(
                i % 3,
                DAffine3::from_translation(random.vec3().as_dvec3() * 9.0),
            )
        })
        .collect();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let tree = build(&meshes, &placements);
            let wide = Wide::build(&tree);
            (tree, wide)
        })
    };
    let ((a, wide_a), (b, wide_b)) = (with(1), with(2));
    assert!(bytemuck::cast_slice::<_, u8>(&a.nodes) == bytemuck::cast_slice::<_, u8>(&b.nodes));
    assert!(
        bytemuck::cast_slice::<_, u8>(&a.triangles) == bytemuck::cast_slice::<_, u8>(&b.triangles)
    );
    assert!(a.triangle_source == b.triangle_source && a.stats == b.stats);
    assert!(
        bytemuck::cast_slice::<_, u8>(&wide_a.nodes)
            == bytemuck::cast_slice::<_, u8>(&wide_b.nodes)
    );
    assert!(
        bytemuck::cast_slice::<_, u8>(&wide_a.packets)
            == bytemuck::cast_slice::<_, u8>(&wide_b.packets)
    );
}

#[test]
fn moved_instances_equal_a_fresh_tree() {
    let mut random = Random(8);
    let meshes = [
        Mesh::soup(&mut random, 30, 0.5),
        Mesh::soup(&mut random, 9, 0.5),
    ];
    let mut inputs: Vec<InstanceInput> = (0..30)
        .map(|i| instance(i % 2, DAffine3::IDENTITY))
        .collect();
    let mut tree = build(&meshes, &inputs);
    let mut wide = Wide::build(&tree);
    for visible in [30, 3, 1, 0, 2] {
        let moved: Vec<DAffine3> = (0..30)
            .map(|i| {
                let scale = if i < visible { 1.0 } else { 0.0 };
                DAffine3::from_translation(random.vec3().as_dvec3() * 4.0)
                    * DAffine3::from_scale(DVec3::splat(scale))
            })
            .collect();
        tree.rebuild_top(&moved).expect("same number");
        wide.update_top(&tree);
        assert_eq!(tree.stats.left_out.len(), 30 - visible);
        for (input, transform) in inputs.iter_mut().zip(&moved) {
            input.object_to_world = *transform;
        }
        let rays = random_rays(&mut random, 300, Vec3::ZERO, 5.0);
        assert_eq!(
            agree(&tree, &wide, &rays),
            agree_fresh(&build(&meshes, &inputs), &rays)
        );
    }
    let error = tree.rebuild_top(&[DAffine3::IDENTITY]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("1 given, but the tree was built from 30"),
        "{error}"
    );
}

#[test]
fn refitted_meshes_agree() {
    let mut random = Random(9);
    let meshes = [Mesh::soup(&mut random, 200, 0.4), Mesh::square(0.0)];
    let inputs = [
        instance(0, DAffine3::IDENTITY),
        instance(1, DAffine3::IDENTITY),
    ];
    let mut tree = build(&meshes, &inputs);
    let mut wide = Wide::build(&tree);
    let mut bent = Mesh {
        triangles: meshes[0].triangles.clone(),
        ..Mesh::default()
    };
    bent.positions = meshes[0]
        .positions
        .iter()
        .map(|p| *p * 1.5 + Vec3::X * p.y * p.y)
        .collect();
    let before = tree.triangles.clone();
    tree.refit_bottom(0, &[bent.part()])
        .expect("same triangles");
    tree.rebuild_top(&inputs.map(|i| i.object_to_world))
        .expect("same number");
    wide.refit_bottom(&tree, 0);
    wide.update_top(&tree);
    assert!(
        bytemuck::cast_slice::<_, u8>(&before) != bytemuck::cast_slice::<_, u8>(&tree.triangles)
    );
    let rays = random_rays(&mut random, 1000, Vec3::ZERO, 3.0);
    assert!(agree(&tree, &wide, &rays) > 300);
    // The same closest distances as a tree built from the moved mesh; indices differ with the order of leaves.
    let fresh = build(&[bent, Mesh::square(0.0)], &inputs);
    for ray in &rays {
        let all = |_: u32, _: u32, _: f32, _: f32| true;
        let (a, b) = (
            scalar::closest(&tree.view(), ray, all),
            scalar::closest(&fresh.view(), ray, all),
        );
        assert_eq!(a.t, b.t);
    }
}

#[test]
fn triangles_remember_where_they_came_from() {
    let (a, mut b) = (Mesh::square(0.0), Mesh::square(1.0));
    b.alpha = true;
    let ids = [40, 41];
    let parts = [
        a.part(),
        MeshPart {
            material: 5,
            first_primitive: 100,
            transform_ids: &ids,
            ..b.part()
        },
    ];
    let tree = TwoLevel::build(&[BlasInput { parts: &parts }], &[]).expect("valid");
    for (triangle, &(part, index)) in tree.triangles.iter().zip(&tree.triangle_source) {
        let expected = if part == 0 {
            (index, 0, 0, false)
        } else {
            (100 + index, 40 + index, 5, true)
        };
        let found = (
            triangle.primitive,
            triangle.transform_id,
            triangle.material(),
            triangle.needs_alpha_test(),
        );
        assert_eq!(found, expected);
        let source = &parts[part as usize];
        let corners = source.triangles[index as usize].map(|i| source.positions[i as usize]);
        assert_eq!(
            [
                triangle.v0,
                triangle.v0 + triangle.e1,
                triangle.v0 + triangle.e2
            ],
            corners
        );
    }
}

#[test]
fn wrong_geometry_is_an_error() {
    let check = |change: fn(&mut Mesh), message: &str| {
        let mut mesh = Mesh::square(0.0);
        change(&mut mesh);
        let parts = [mesh.part()];
        let error = TwoLevel::build(&[BlasInput { parts: &parts }], &[]).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    };
    check(
        |mesh| mesh.triangles[1][2] = 9,
        "vertex index 9 is out of range",
    );
    check(
        |mesh| mesh.positions[2].y = f32::NAN,
        "not a finite position",
    );
    check(|mesh| mesh.positions[2].y = 1e13, "not a finite position");
    let missing = TwoLevel::build(&[], &[instance(0, DAffine3::IDENTITY)]).unwrap_err();
    assert!(
        missing
            .to_string()
            .contains("names bottom level 0, of which there are 0"),
        "{missing}"
    );
    let mut tree = build(&[Mesh::square(0.0)], &[]);
    assert!(tree.refit_bottom(0, &[]).is_err());
    assert!(tree.refit_bottom(1, &[]).is_err());
}
