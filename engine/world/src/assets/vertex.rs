//! Vertices as the GPU sees them.

/// One vertex as the GPU sees it: 48 bytes, object space, metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position in object space \[m\].
    pub position: [f32; 3],
    /// Unit normal in object space; zero only where the triangle itself has no area.
    pub normal: [f32; 3],
    /// Unit tangent along +u, and the handedness (±1) of the bitangent, as in glTF.
    pub tangent: [f32; 4],
    /// Texture coordinate set 0, origin at the upper left as in glTF.
    pub uv: [f32; 2],
}

/// Vertex attributes that only some meshes have, as the GPU sees them: 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct VertexExtra {
    /// Texture coordinate set 1.
    pub uv: [f32; 2],
    /// Linear colour and alpha in 65535ths; multiplies the base colour.
    pub color: [u16; 4],
}

impl VertexExtra {
    /// The attributes of a mesh without extras.
    pub const NEUTRAL: Self = Self { uv: [0.0; 2], color: [u16::MAX; 4] };

    /// The colour as numbers of 0 to 1.
    pub fn rgba(&self) -> [f32; 4] {
        self.color.map(|c| f32::from(c) / 65535.0)
    }
}
