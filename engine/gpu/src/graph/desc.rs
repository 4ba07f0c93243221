//! Descriptions of resources. They are what memory is shared by: two targets with equal
//! descriptions may use the same memory at different times; names play no part.

use std::fmt;

use wgpu::{BufferUsages, Extent3d, TextureDimension, TextureFormat, TextureUsages, TextureViewDimension};

/// A texture: size, format and what it is used for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TextureDesc {
    /// Width, height, and depth (3D) or number of layers (otherwise), in texels.
    pub size: [u32; 3],
    /// 1D, 2D (also arrays and cubes) or 3D.
    pub dimension: TextureDimension,
    /// Number of mip levels, at least 1.
    pub mips: u32,
    /// Format of a texel.
    pub format: TextureFormat,
    /// Its usages by passes. The graph adds `COPY_DST`, so that a pass can clear it, and for
    /// retained textures `COPY_SRC`, so that tools can read it back.
    pub usage: TextureUsages,
    /// The dimension of the default view; `None`: what wgpu derives from size and dimension.
    pub view: Option<TextureViewDimension>,
}

impl TextureDesc {
    /// A 2D texture with one mip level.
    pub fn d2(width: u32, height: u32, format: TextureFormat, usage: TextureUsages) -> Self {
        let size = [width, height, 1];
        Self { size, dimension: TextureDimension::D2, mips: 1, format, usage, view: None }
    }

    /// A 2D array texture; its default view is an array even with one layer.
    pub fn d2_array(width: u32, height: u32, layers: u32, format: TextureFormat, usage: TextureUsages) -> Self {
        let view = Some(TextureViewDimension::D2Array);
        Self { size: [width, height, layers], view, ..Self::d2(width, height, format, usage) }
    }

    /// A 3D texture.
    pub fn d3(width: u32, height: u32, depth: u32, format: TextureFormat, usage: TextureUsages) -> Self {
        let dimension = TextureDimension::D3;
        Self { size: [width, height, depth], dimension, ..Self::d2(width, height, format, usage) }
    }

    /// This description with another format.
    pub fn with_format(self, format: TextureFormat) -> Self {
        Self { format, ..self }
    }

    /// This description with further usages.
    pub fn with_usage(self, usage: TextureUsages) -> Self {
        Self { usage: self.usage | usage, ..self }
    }

    /// This description with `mips` mip levels.
    pub fn with_mips(self, mips: u32) -> Self {
        Self { mips, ..self }
    }

    /// This description at half the width and height, rounded up.
    pub fn half_size(self) -> Self {
        let [width, height, depth] = self.size;
        Self { size: [width.div_ceil(2), height.div_ceil(2), depth], ..self }
    }

    /// The description of an existing texture.
    pub fn of(texture: &wgpu::Texture) -> Self {
        Self {
            size: [texture.width(), texture.height(), texture.depth_or_array_layers()],
            dimension: texture.dimension(),
            mips: texture.mip_level_count(),
            format: texture.format(),
            usage: texture.usage(),
            view: None,
        }
    }

    /// The size as wgpu wants it.
    pub fn extent(&self) -> Extent3d {
        let [width, height, depth_or_array_layers] = self.size;
        Extent3d { width, height, depth_or_array_layers }
    }

    /// Memory \[bytes\] of all mip levels, without the driver's padding.
    pub fn bytes(&self) -> u64 {
        (0..self.mips).map(|mip| self.mip_bytes(mip)).sum()
    }

    fn mip_bytes(&self, mip: u32) -> u64 {
        let extent = self.extent().mip_level_size(mip, self.dimension);
        self.format.theoretical_memory_footprint(extent)
    }
}

/// A buffer: size and what it is used for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct BufferDesc {
    /// Size \[bytes\], above 0.
    pub size: u64,
    /// Its usages by passes. The graph adds `COPY_DST`, and for retained buffers `COPY_SRC`.
    pub usage: BufferUsages,
}

impl BufferDesc {
    /// A buffer of a size \[bytes\] for a use.
    pub fn new(size: u64, usage: BufferUsages) -> Self {
        Self { size, usage }
    }

    /// The description of an existing buffer.
    pub fn of(buffer: &wgpu::Buffer) -> Self {
        Self { size: buffer.size(), usage: buffer.usage() }
    }
}

/// The description of a texture or a buffer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ResourceDesc {
    /// A texture.
    Texture(TextureDesc),
    /// A buffer.
    Buffer(BufferDesc),
}

impl ResourceDesc {
    /// Memory \[bytes\], without the driver's padding.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Texture(desc) => desc.bytes(),
            Self::Buffer(desc) => desc.size,
        }
    }

    /// Its fault, or `None`.
    pub(super) fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Texture(desc) if desc.size.contains(&0) => Some("a side of its size is 0"),
            Self::Texture(desc) if desc.mips == 0 => Some("it has 0 mip levels"),
            Self::Buffer(desc) if desc.size == 0 => Some("its size is 0 bytes"),
            _ => None,
        }
    }

    /// With the usages that the graph adds: passes clear targets, tools read retained ones.
    pub(super) fn with_graph_usages(self, retained: bool) -> Self {
        match self {
            Self::Texture(mut desc) => {
                let read_back = if retained { TextureUsages::COPY_SRC } else { TextureUsages::empty() };
                desc.usage |= TextureUsages::COPY_DST | read_back;
                Self::Texture(desc)
            }
            Self::Buffer(mut desc) => {
                let read_back = if retained { BufferUsages::COPY_SRC } else { BufferUsages::empty() };
                desc.usage |= BufferUsages::COPY_DST | read_back;
                Self::Buffer(desc)
            }
        }
    }
}

impl From<TextureDesc> for ResourceDesc {
    fn from(desc: TextureDesc) -> Self {
        Self::Texture(desc)
    }
}

impl From<BufferDesc> for ResourceDesc {
    fn from(desc: BufferDesc) -> Self {
        Self::Buffer(desc)
    }
}

impl fmt::Display for ResourceDesc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Texture(desc) => {
                let [width, height, depth] = desc.size;
                write!(f, "{width}x{height}")?;
                if depth > 1 {
                    write!(f, "x{depth}")?;
                }
                write!(f, " {:?}", desc.format)?;
                if desc.mips > 1 { write!(f, ", {} mips", desc.mips) } else { Ok(()) }
            }
            Self::Buffer(desc) => write!(f, "buffer of {} B", desc.size),
        }
    }
}
