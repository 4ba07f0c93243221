//! Which pipeline a primitive is drawn with, and the layouts of its vertices.

use super::material::alpha_cutoff;
use crate::assets::{AlphaMode, Vertex, VertexExtra};
use crate::gpu::ShaderDef;
use crate::scene::Primitive;
use crate::scene::is_mirrored;

/// The properties of a primitive that choose its pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialClass {
    /// Back faces are drawn.
    pub double_sided: bool,
    /// Alpha is tested.
    pub masked: bool,
    /// Blended over what lies behind, or of glass.
    pub blended: bool,
    /// Light passes it.
    pub glass: bool,
    /// The transform mirrors: triangles wind the other way.
    pub mirrored: bool,
    /// One set of texture coordinates as it is, no vertex colours, no textures but those of the metallic-roughness base.
    pub plain: bool,
    /// There is more than the metallic-roughness base.
    pub layered: bool,
    /// A lobe of it is drawn apart, see `geometry/second_lobe.wgsl`.
    pub second_lobe: bool,
}

impl MaterialClass {
    /// The front of opaque surfaces without anything that costs more: for passes that draw no material.
    pub const SIMPLEST: Self = Self {
        double_sided: false,
        masked: false,
        blended: false,
        glass: false,
        mirrored: false,
        plain: true,
        layered: false,
        second_lobe: false,
    };

    pub(super) fn of(primitive: &Primitive) -> Self {
        Self {
            double_sided: primitive.material.double_sided,
            masked: alpha_cutoff(&primitive.material) >= 0.0,
            blended: primitive.material.alpha_mode == AlphaMode::Blend || primitive.material.is_glass(),
            glass: primitive.material.is_glass(),
            mirrored: is_mirrored(&primitive.world_from_object),
            plain: primitive.mesh.extras.is_none() && primitive.material.is_plain(),
            layered: primitive.material.has_layers(),
            second_lobe: primitive.material.has_second_lobe(),
        }
    }

    /// The shader definitions of the parts that a pass leaves out.
    pub fn defs(self) -> Vec<(&'static str, ShaderDef)> {
        if self.plain { vec![("PLAIN", ShaderDef::Flag(true))] } else { Vec::new() }
    }

    /// The same for passes that draw the view, which see what layers there are.
    pub fn defs_of_view(self) -> Vec<(&'static str, ShaderDef)> {
        let mut defs = self.defs();
        defs.extend(self.layered.then_some(("LAYERED", ShaderDef::Flag(true))));
        defs
    }

    /// Layouts of [`Vertex`] and, where there is more than the plain, [`VertexExtra`].
    pub fn vertex_buffers(self) -> Vec<wgpu::VertexBufferLayout<'static>> {
        if self.plain { vec![vertex_layout()] } else { vec![vertex_layout(), extra_layout()] }
    }

    /// Winding and culling for what the camera sees: back faces of single-sided surfaces are left out.
    pub fn primitive_state(self) -> wgpu::PrimitiveState {
        wgpu::PrimitiveState {
            front_face: if self.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            cull_mode: (!self.double_sided).then_some(wgpu::Face::Back),
            ..Default::default()
        }
    }
}

fn extra_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![4 => Float32x2, 5 => Unorm16x4];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<VertexExtra>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}

/// [`Vertex`] at locations 0 to 3.
pub fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}
