//! Structs that host and shaders share, member by member as in `shaders/shared/layout.wesl`; a test compares the offsets.

use bytemuck::{Pod, Zeroable};

/// Declares `#[repr(C)]` structs and, for the test, the names and offsets of their members.
macro_rules! shared {
    ($($(#[$doc:meta])* struct $name:ident { $($field:ident: $ty:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
            #[repr(C)]
            #[expect(missing_docs, reason = "the names are those of the shader and of the compiled scene")]
            pub struct $name { $(pub $field: $ty,)* }
        )*
        /// Every struct's name, size, and members with their offsets.
        #[cfg(test)]
        type Members = Vec<(&'static str, usize)>;
        #[cfg(test)]
        fn structs() -> Vec<(&'static str, usize, Members)> {
            vec![$((stringify!($name), size_of::<$name>(), vec![$((stringify!($field), std::mem::offset_of!($name, $field))),*])),*]
        }
    };
}

/// Interiors that a ray can be in at once.
pub const MAX_INTERIORS: usize = 8;

shared! {
    /// What a whole render shares.
    struct SceneParams {
        adc_bailout: f32,
        max_level: u32,
        n_lights: u32,
        n_unbounded: u32,
        background: [f32; 3],
        background_filter: f32,
        ambient_light: [f32; 3],
        background_transmit: f32,
        sky_emission: [f32; 3],
        sky_at: u32,
        tree_low: [f32; 3],
        n_bounded: u32,
        tree_high: [f32; 3],
        tree_extent: f32,
        sky_transform_ix: u32,
        fogs_at: u32,
        clip_steps_at: u32,
        clip_boxes_at: u32,
        materials_at: u32,
        emitters_at: u32,
        n_camera_interiors: u32,
        unbounded_at: u32,
        camera_interiors: [u32; MAX_INTERIORS],
        generator: u32,
        n_emitters: u32,
        lists_at: u32,
        n_meshes: u32,
        air_media_at: u32,
        global_lights_at: u32,
        rainbows_at: u32,
        padding: u32,
    }
    /// Where a camera ray starts.
    struct Start {
        origin: [f32; 3],
        shown: u32,
        dir: [f32; 3],
        key: u32,
        origin_low: [f32; 3],
        n_interiors: u32,
        dir_low: [f32; 3],
        padding: u32,
        interiors: [u32; MAX_INTERIORS],
    }
    /// What one step works on.
    struct Batch {
        first: u32,
        n: u32,
        slot: u32,
        n_areas: u32,
        round: u32,
        lens_first: u32,
        lens_samples: u32,
        open_first: u32,
        open_side: u32,
        left: u32,
        top: u32,
        columns: u32,
        rows: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
    /// A leaf of the scene.
    struct Prim {
        kind: u32,
        shape_at: u32,
        transform_ix: u32,
        surface_at: u32,
        interior_ix: u32,
        object_ix: u32,
        clip_start: u32,
        clip_len: u32,
        flags: u32,
        lights_at: u32,
        bounded_by_at: u32,
        cutaway_at: u32,
        low: [f32; 3],
        padding0: f32,
        high: [f32; 3],
        padding1: f32,
    }
    /// Rows of the affine maps from shape space to the world and back.
    struct Transform {
        forward: [[f32; 4]; 3],
        inverse: [[f32; 4]; 3],
        forward_low: [[f32; 4]; 3],
        inverse_low: [[f32; 4]; 3],
    }
    /// A filling.
    struct Interior {
        fade_color: [f32; 3],
        fade_distance: f32,
        ior: f32,
        fade_power: f32,
        old_refraction: f32,
        caustics: f32,
        hollow: u32,
        media_at: u32,
        ior_low: f32,
        padding: u32,
    }
    /// An answer to light.
    struct Finish {
        ambient: [f32; 3],
        diffuse: f32,
        emission: [f32; 3],
        diffuse_back: f32,
        reflection_min: [f32; 3],
        brilliance: f32,
        reflection_max: [f32; 3],
        phong: f32,
        phong_size: f32,
        specular: f32,
        roughness: f32,
        metallic: f32,
        reflection_fresnel: u32,
        reflection_falloff: f32,
        reflection_exponent: f32,
        reflection_metallic: f32,
        conserve_energy: u32,
        irid_amount: f32,
        irid_thickness: f32,
        irid_turbulence: f32,
        crand: f32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
    /// A light source.
    struct Light {
        location: [f32; 3],
        kind: u32,
        point_at: [f32; 3],
        radius: f32,
        color: [f32; 3],
        falloff: f32,
        axis: [f32; 3],
        tightness: f32,
        fade_kind: u32,
        fade_distance: f32,
        fade_power: f32,
        flags: u32,
        area_at: u32,
        projected_at: u32,
        padding0: u32,
        padding1: u32,
    }
    /// A ray on its way.
    struct Ray {
        origin: [f32; 3],
        slot: u32,
        dir: [f32; 3],
        weight: f32,
        throughput: [f32; 3],
        transmit: f32,
        interiors: [u32; MAX_INTERIORS],
        level: u32,
        n_interiors: u32,
        state: u32,
        from_prim: u32,
        from_face: u32,
        max_depth: f32,
        key: u32,
        media_at: u32,
        origin_low: [f32; 3],
        padding0: u32,
        dir_low: [f32; 3],
        padding1: u32,
    }
    /// What a ray met.
    struct Hit {
        t: f32,
        prim: u32,
        face: u32,
        a: f32,
        b: f32,
        t_low: f32,
        padding0: u32,
        padding1: u32,
    }
    /// A ray towards a light.
    struct ShadowRay {
        origin: [f32; 3],
        slot: u32,
        dir: [f32; 3],
        left: f32,
        response: [f32; 3],
        light_ix: u32,
        interiors: [u32; MAX_INTERIORS],
        n_interiors: u32,
        from_prim: u32,
        from_face: u32,
        padding0: u32,
        origin_low: [f32; 3],
        padding1: u32,
    }
    /// What the path integrator shares over a whole picture.
    struct PathParams {
        location: [f32; 3],
        lens_radius: f32,
        direction: [f32; 3],
        focus_distance: f32,
        right: [f32; 3],
        lens_blades: u32,
        up: [f32; 3],
        lens_rotation: f32,
        camera_at: u32,
        poses_at: u32,
        hair_at: u32,
        lens_ratio: f32,
        tree_low: [f32; 3],
        n_faces: u32,
        tree_high: [f32; 3],
        lists_at: u32,
        width: f32,
        height: f32,
        extent: f32,
        seed: u32,
        max_bounces: u32,
        diffuse_bounces: u32,
        glossy_bounces: u32,
        transmission_bounces: u32,
        transparent_bounces: u32,
        min_light_bounces: u32,
        min_transparent_bounces: u32,
        filter_at: u32,
        clamp_direct: f32,
        clamp_indirect: f32,
        filter_glossy: f32,
        exposure: f32,
        materials_at: u32,
        mirror_at: u32,
        volumes_at: u32,
        lamps_at: u32,
        n_lamps: u32,
        suns_at: u32,
        n_suns: u32,
        emitters_at: u32,
        tree_lamps_at: u32,
        n_tree_lamps: u32,
        leaves_at: u32,
        env_visibility: u32,
        env_strength: [f32; 3],
        env_at: u32,
        env_x: [f32; 3],
        env_sums_at: u32,
        env_y: [f32; 3],
        env_estimate: f32,
        env_z: [f32; 3],
        sky_sun_open: f32,
        sky_sun: [f32; 3],
        sky_sun_half: f32,
        sky_sun_dir: [f32; 3],
        sky_sun_energy: f32,
        sky_sun_up: [f32; 3],
        sky_sun_foot_height: f32,
        sky_sun_foot: [f32; 3],
        sky_sun_span: f32,
        sky_sun_top: [f32; 3],
        volume_bounces: u32,
    }
    /// Slots and samples of one dispatch of the path integrator.
    struct PathBatch {
        first: u32,
        n: u32,
        first_sample: u32,
        end_sample: u32,
    }
    /// An area light at a hit, until it is known what arrives from it.
    struct AreaTask {
        point: [f32; 3],
        slot: u32,
        response: [f32; 3],
        light_ix: u32,
        arriving: [f32; 3],
        points_at: u32,
        interiors: [u32; MAX_INTERIORS],
        n_interiors: u32,
        from_prim: u32,
        from_face: u32,
        key: u32,
        point_low: [f32; 3],
        padding: u32,
    }
    /// Lengths of the queues, and what went wrong.
    struct Counters {
        n_children: u32,
        n_shadows: u32,
        n_shadows_out: u32,
        fault: u32,
        n_areas: u32,
        n_area_points: u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::gpu::modules::MODULES;

    /// Names, sizes and members of the structs that naga sees in a shader.
    /// A struct of the shader: name, size, members with their offsets.
    type ShaderStruct = (String, usize, Vec<(String, usize)>);

    fn shader_structs(text: &str) -> Vec<ShaderStruct> {
        let module = naga::front::wgsl::parse_str(text).expect("the layout module is plain WGSL");
        let mut list = Vec::new();
        for (_, ty) in module.types.iter() {
            if let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) {
                let members = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
                list.push((name.clone(), *span as usize, members));
            }
        }
        list
    }

    #[test]
    fn members_lie_where_the_shader_sees_them() {
        let (_, text) = MODULES.iter().find(|(name, _)| *name == "shared/layout").expect("the layout module");
        let theirs = shader_structs(text);
        let ours = structs();
        assert_eq!(ours.len(), theirs.len());
        for (name, size, members) in ours {
            let found = theirs.iter().find(|s| s.0 == name).unwrap_or_else(|| panic!("{name} is not in the shader"));
            let members: Vec<(String, usize)> = members.into_iter().map(|(n, o)| (n.to_owned(), o)).collect();
            assert_eq!((size, &members), (found.1, &found.2), "{name}");
        }
    }

    #[test]
    fn a_member_in_another_place_is_seen() {
        let list = shader_structs("struct Batch { n: u32, first: vec3f }");
        assert_eq!(list[0].2, [("n".to_owned(), 0), ("first".to_owned(), 16)]);
        assert_ne!(list[0].1, size_of::<Batch>() - 1);
    }
}
