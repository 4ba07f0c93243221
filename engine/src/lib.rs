//! Lightwell: a mini game engine with real-time global illumination.
//!
//! Data flows one way, `world → scene → graph → gpu`:
//!
//! 1. [`world`]: entities with components (`bevy_ecs`), their hierarchy and animation. The clock is an input.
//! 2. [`scene`]: flat arrays in world space, kept current by change detection. Knows neither entities nor the device.
//! 3. [`render`]: the passes. [`render::Renderer`] asks what a scene needs and declares the passes of a frame.
//! 4. [`graph`]: the render graph. Every result has a key made of all that it depends on; what nobody reads is culled,
//!    what has not changed is reused. Knows no light.
//! 5. [`gpu`]: the device, shaders with imports and hot reload, pipelines, timestamps, readback.
//!
//! A game is made of [`game`]: steps of time, input, prefabs at run time, scenes, questions to the space around, saved
//! games; with components of its own by [`files::SceneData`]. The crate `lightwell_game` puts it into a window.
//!
//! Beside them: [`assets`] (meshes, materials, textures, glTF), [`bvh`] (hierarchies that rays are cast at), [`files`]
//! (scenes and prefabs), [`measure`] (image error metrics) and [`profile`] (times of the last frames). Below them all lies
//! [`core`] (boxes, rays, transforms, identities).
//!
//! # A frame without a window
//!
//! ```no_run
//! use lightwell::assets::AssetLibrary;
//! use lightwell::files::{LoadOptions, load_scene};
//! use lightwell::gpu::{Gpu, GpuOptions, read_texture_f32};
//! use lightwell::render::{RenderSettings, Renderer};
//! use lightwell::scene::{Extractor, Scene, SceneView};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let gpu = Gpu::headless(&GpuOptions::default())?;
//! let mut library = AssetLibrary::new();
//! let mut world = load_scene(Path::new("scenes/cornell.scene.ron"), &mut library, &LoadOptions::default())?;
//! let (mut extractor, mut scene, mut renderer) = (Extractor::new(), Scene::default(), Renderer::new(&gpu));
//!
//! world.set_seconds(1.5);
//! world.update();
//! extractor.extract(&mut world, &mut scene);
//! let view = SceneView { camera: scene.cameras[0].clone(), size: [512, 512], jitter: [0.0; 2] };
//! let report = renderer.render(&gpu, &scene, &view, &RenderSettings::default())?;
//! println!("{report}");
//! let radiance = renderer.radiance().map(|texture| read_texture_f32(&gpu, texture)).transpose()?;
//! # Ok(()) }
//! ```
//!
//! # From the thesis to the code
//!
//! The diffusion of light propagation volumes follows the thesis of Petr Šefčík, "Computing global illumination in
//! real-time using Cascaded Light Propagation Volumes" (2016), whose classes became:
//!
//! | thesis | here |
//! | --- | --- |
//! | `Rh*` device layer (4.1, 6.1) | `wgpu`, and [`gpu::Gpu`] around it |
//! | shader cache, forced rebuild (6.6.1) | [`gpu::ShaderLibrary`], [`gpu::PipelineCache`] |
//! | render-target cache (4.2.3, 6.6.2) | [`graph::TargetCache`] |
//! | render passes and their order (ch. 5) | [`graph::Graph`], declared in [`render`] |
//! | world, entities, components (4.3, 6.2) | [`world::GameWorld`] and the components in [`world`] |
//! | scene with primitives and lights (4.2.1) | [`scene::Scene`], [`scene::Extractor`] |
//! | clones, deferred despawn, behaviours (6.2) | [`world::GameWorld::clone_subtree`], [`world::DespawnQueue`], systems in [`game::FixedUpdate`] |
//! | prefabs and their files (6.3) | [`files`], [`game::GameCommands::spawn_prefab`] |
//! | picking, ray casts | [`game::SpatialQuery`], [`bvh`] |
//! | main loop, events, input | [`game::Game`], [`game::Input`]; the window in `lightwell_game::App` |
//! | resources, import (4.4, 6.3) | [`assets::AssetLibrary`], [`assets::Gltf`] |
//! | reflective shadow maps GRSM (5.3.3) | [`render::rsm`] |
//! | injection IL, IB; propagation PRP; relight REL (5.3 to 5.6) | [`render::lpv`] |
//! | cascaded volume and its placement (3.10.5) | [`render::lpv::Volume`], [`world::Clpv`] |
//! | reference images (6.7) | [`render::reference`] |
//! | profiler (6.5) | [`profile`], [`graph::FrameReport`] |

#[doc(inline)]
pub use lightwell_core::{core, measure, packed, profile};
#[doc(inline)]
pub use lightwell_gpu::{gpu, graph};
#[doc(hidden)]
pub use lightwell_world::__private;
#[doc(inline)]
pub use lightwell_world::{assets, bvh, files, game, scene, world};

pub mod render;
