//! Between what files say and what the engine uses.

use super::loader::Context;
use super::source::SceneInfo;
use crate::assets::{
    AlphaMode, Anisotropy, Attenuation, Clearcoat, Iridescence, Material, Sampling, Sheen, Texture, Wrap,
};
use crate::core::{Transform, look_rotation};
use crate::files::format::custom_components::CustomValue;
use crate::files::format::scene_file::*;
use crate::world::animation::rotation_from_degrees;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

impl From<TransformFile> for Transform {
    fn from(file: TransformFile) -> Self {
        let rotation = match (file.rotation, file.look_at) {
            (_, Some(target)) => look_rotation(target - file.translation),
            (Some(Rotation::Euler(degrees)), _) => rotation_from_degrees(degrees),
            (Some(Rotation::Quaternion(q)), _) => q,
            (None, None) => Quat::IDENTITY,
        };
        let scale = match file.scale {
            Some(Scale::Uniform(s)) => Vec3::splat(s),
            Some(Scale::Axes(s)) => s,
            None => Vec3::ONE,
        };
        Self { translation: file.translation, rotation, scale }
    }
}

impl From<Transform> for TransformFile {
    fn from(t: Transform) -> Self {
        Self {
            translation: t.translation,
            rotation: (t.rotation != Quat::IDENTITY).then_some(Rotation::Quaternion(t.rotation)),
            look_at: None,
            scale: (t.scale != Vec3::ONE).then_some(Scale::Axes(t.scale)),
        }
    }
}

impl EntityFile {
    /// The entity's components alone.
    pub fn components(&self) -> OverrideFile {
        OverrideFile {
            transform: self.transform,
            mesh: self.mesh.clone(),
            model: self.model.clone(),
            material: self.material.clone(),
            casts_shadow: self.casts_shadow,
            visible: self.visible,
            light: self.light.clone(),
            camera: self.camera.clone(),
            clpv: self.clpv.clone(),
            vpl: self.vpl.clone(),
            slc: self.slc.clone(),
            fog: self.fog,
            particles: self.particles,
            animation: self.animation.clone(),
            components: self.components.clone(),
            ..Default::default()
        }
    }

    /// An entity of the components.
    pub fn with_components(name: String, c: OverrideFile) -> Self {
        Self {
            name,
            transform: c.transform,
            mesh: c.mesh,
            model: c.model,
            material: c.material,
            casts_shadow: c.casts_shadow,
            visible: c.visible,
            light: c.light,
            camera: c.camera,
            clpv: c.clpv,
            vpl: c.vpl,
            slc: c.slc,
            fog: c.fog,
            particles: c.particles,
            animation: c.animation,
            components: c.components,
            ..Default::default()
        }
    }
}

/// Calls the macro with the names of all component fields.
macro_rules! for_components {
    ($each:ident) => {
        $each!(
            transform,
            mesh,
            model,
            material,
            casts_shadow,
            visible,
            light,
            camera,
            clpv,
            vpl,
            slc,
            fog,
            particles,
            animation
        )
    };
}

impl OverrideFile {
    /// Takes every component that the other one gives.
    pub fn replace_with(&mut self, other: &Self) {
        macro_rules! replace {
            ($($field:ident),*) => { $(if other.$field.is_some() { self.$field = other.$field.clone(); })* };
        }
        for_components!(replace);
        self.components.extend(other.components.clone());
    }

    /// The changes from `base` to this one; nothing if they are the same.
    pub fn changes_from(&self, base: &Self) -> Self {
        let mut changes = Self::default();
        macro_rules! compare {
            ($($field:ident),*) => { $(if self.$field != base.$field { changes.$field = self.$field.clone(); })* };
        }
        for_components!(compare);
        let own = self.components.iter().filter(|(name, value)| base.components.get(*name) != Some(value));
        changes.components = own.map(|(name, value)| (name.clone(), value.clone())).collect();
        changes.restore_defaults(self, base);
        let gone = [
            (ComponentKind::Mesh, base.has_surface() && !self.has_surface()),
            (ComponentKind::Light, base.light.is_some() && self.light.is_none()),
            (ComponentKind::Camera, base.camera.is_some() && self.camera.is_none()),
            (ComponentKind::Clpv, base.clpv.is_some() && self.clpv.is_none()),
            (ComponentKind::Vpl, base.vpl.is_some() && self.vpl.is_none()),
            (ComponentKind::Slc, base.slc.is_some() && self.slc.is_none()),
            (ComponentKind::Fog, base.fog.is_some() && self.fog.is_none()),
            (ComponentKind::Particles, base.particles.is_some() && self.particles.is_none()),
            (ComponentKind::Animation, base.animation.is_some() && self.animation.is_none()),
        ];
        changes.without = gone.into_iter().filter(|(_, gone)| *gone).map(|(kind, _)| kind).collect();
        let gone = base.components.keys().filter(|name| !self.components.contains_key(*name));
        changes.without.extend(gone.map(|name| ComponentKind::Own(name.clone())));
        changes
    }

    /// Components that are not there mean a default, which an override has to write out.
    fn restore_defaults(&mut self, now: &Self, base: &Self) {
        if now.transform.is_none() && base.transform.is_some() {
            self.transform = Some(TransformFile::default());
        }
        if now.casts_shadow.is_none() && base.casts_shadow.is_some() {
            self.casts_shadow = Some(true);
        }
        if now.visible.is_none() && base.visible.is_some() {
            self.visible = Some(true);
        }
    }

    /// Takes from an override what it says that is still so, though it makes no difference to the prefab.
    pub fn keep(&mut self, described: &Self, now: &Self) {
        macro_rules! keep {
            ($($field:ident),*) => {
                $(if self.$field.is_none() && described.$field == now.$field { self.$field = described.$field.clone(); })*
            };
        }
        for_components!(keep);
        let is_so = |(name, value): &(&String, &CustomValue)| now.components.get(*name) == Some(*value);
        let own = described.components.iter().filter(is_so);
        self.components.extend(own.map(|(name, value)| (name.clone(), value.clone())));
        let mut without = described.without.clone();
        without.retain(|kind| {
            let mut less = now.clone();
            less.take_away(kind);
            less == *now
        });
        self.without.retain(|kind| !without.contains(kind));
        without.append(&mut self.without);
        self.without = without;
    }

    fn has_surface(&self) -> bool {
        self.mesh.is_some() || self.model.is_some()
    }

    /// Takes a component away.
    pub fn take_away(&mut self, kind: &ComponentKind) {
        match kind {
            ComponentKind::Mesh => (self.mesh, self.model, self.material) = (None, None, None),
            ComponentKind::Light => self.light = None,
            ComponentKind::Camera => self.camera = None,
            ComponentKind::Clpv => self.clpv = None,
            ComponentKind::Vpl => self.vpl = None,
            ComponentKind::Slc => self.slc = None,
            ComponentKind::Fog => self.fog = None,
            ComponentKind::Particles => self.particles = None,
            ComponentKind::Animation => self.animation = None,
            ComponentKind::Own(name) => drop(self.components.remove(name)),
        }
    }
}

impl MaterialFile {
    /// The material without its images.
    pub fn material(&self, name: &str) -> Material {
        Material {
            base_color: self.color.extend(self.alpha),
            metallic: self.metallic,
            roughness: self.roughness,
            specular: self.specular,
            specular_color: self.specular_color,
            transmission: self.transmission,
            ior: self.ior,
            volume: self.volume.map(|volume| Attenuation { color: volume.color, distance: volume.distance }),
            dispersion: self.dispersion,
            clearcoat: self.clearcoat.map(Clearcoat::from).unwrap_or_default(),
            sheen: self.sheen.map(Sheen::from).unwrap_or_default(),
            anisotropy: self.anisotropy.map(Anisotropy::from).unwrap_or_default(),
            iridescence: self.iridescence.map(Iridescence::from).unwrap_or_default(),
            emissive: self.emissive,
            normal_scale: self.normal_scale,
            alpha_mode: match self.alpha_mode {
                AlphaModeFile::Opaque => AlphaMode::Opaque,
                AlphaModeFile::Mask(cutoff) => AlphaMode::Mask(cutoff),
                AlphaModeFile::Blend => AlphaMode::Blend,
            },
            double_sided: self.double_sided,
            ..Material::new(if name.is_empty() { "inline" } else { name })
        }
    }

    /// A description of the material; none if one of its images comes from no file that is known.
    pub(in crate::files) fn describe(m: &Material, info: &SceneInfo) -> Option<Self> {
        // Those of layers and of `KHR_materials_specular` come from models alone.
        let of_models = [&m.specular_texture, &m.specular_color_texture].into_iter().chain(m.layer_textures());
        if of_models.flatten().next().is_some() {
            return None;
        }
        let image = |texture: &Option<Arc<Texture>>| match texture {
            None => Some(None),
            Some(texture) => info.textures_by_id.get(&texture.id).cloned().map(Some),
        };
        Some(Self {
            color: m.base_color.truncate(),
            alpha: m.base_color.w,
            alpha_mode: match m.alpha_mode {
                AlphaMode::Opaque => AlphaModeFile::Opaque,
                AlphaMode::Mask(cutoff) => AlphaModeFile::Mask(cutoff),
                AlphaMode::Blend => AlphaModeFile::Blend,
            },
            metallic: m.metallic,
            roughness: m.roughness,
            specular: m.specular,
            specular_color: m.specular_color,
            transmission: m.transmission,
            ior: m.ior,
            volume: m.volume.map(|volume| AttenuationFile { color: volume.color, distance: volume.distance }),
            dispersion: m.dispersion,
            clearcoat: (m.clearcoat != Clearcoat::default()).then(|| m.clearcoat.into()),
            sheen: (m.sheen != Sheen::default()).then(|| m.sheen.into()),
            anisotropy: (m.anisotropy != Anisotropy::default()).then(|| m.anisotropy.into()),
            iridescence: (m.iridescence != Iridescence::default()).then(|| m.iridescence.into()),
            emissive: m.emissive,
            double_sided: m.double_sided,
            color_texture: image(&m.base_color_texture)?,
            metallic_roughness_texture: image(&m.metallic_roughness_texture)?,
            normal_texture: image(&m.normal_texture)?,
            normal_scale: m.normal_scale,
            emissive_texture: image(&m.emissive_texture)?,
            transmission_texture: image(&m.transmission_texture)?,
        })
    }

    /// The same as the scene file would say it.
    pub(in crate::files) fn rebased(mut self, context: &Context) -> Self {
        let images = [
            &mut self.color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.emissive_texture,
            &mut self.transmission_texture,
        ];
        for image in images.into_iter().flatten() {
            *image = image.clone().rebased(context);
        }
        self
    }
}

impl From<ClearcoatFile> for Clearcoat {
    fn from(file: ClearcoatFile) -> Self {
        Self { factor: file.factor, roughness: file.roughness, ..Self::default() }
    }
}

impl From<Clearcoat> for ClearcoatFile {
    fn from(coat: Clearcoat) -> Self {
        Self { factor: coat.factor, roughness: coat.roughness }
    }
}

impl From<SheenFile> for Sheen {
    fn from(file: SheenFile) -> Self {
        Self { color: file.color, roughness: file.roughness }
    }
}

impl From<Sheen> for SheenFile {
    fn from(sheen: Sheen) -> Self {
        Self { color: sheen.color, roughness: sheen.roughness }
    }
}

impl From<AnisotropyFile> for Anisotropy {
    fn from(file: AnisotropyFile) -> Self {
        Self { strength: file.strength, rotation: file.rotation.to_radians() }
    }
}

impl From<Anisotropy> for AnisotropyFile {
    fn from(anisotropy: Anisotropy) -> Self {
        Self { strength: anisotropy.strength, rotation: (anisotropy.rotation % TAU).to_degrees() }
    }
}

impl From<IridescenceFile> for Iridescence {
    fn from(file: IridescenceFile) -> Self {
        Self { factor: file.factor, ior: file.ior, thickness: file.thickness, ..Self::default() }
    }
}

impl From<Iridescence> for IridescenceFile {
    fn from(film: Iridescence) -> Self {
        Self { factor: film.factor, ior: film.ior, thickness: film.thickness }
    }
}

impl TextureFile {
    /// Path as written.
    pub fn path(&self) -> &str {
        match self {
            Self::Path(path) | Self::Sampled(SampledTexture { path, .. }) => path,
        }
    }

    /// Its sampling.
    pub fn sampling(&self) -> Sampling {
        match self {
            Self::Path(_) => Sampling::default(),
            Self::Sampled(s) => {
                let (wrap_u, wrap_v) = (s.wrap_u.into(), s.wrap_v.into());
                Sampling { wrap_u, wrap_v, nearest: s.nearest, minification: None }
            }
        }
    }

    /// The same as the scene file would say it: a path from a prefab in another folder becomes an absolute one.
    pub(in crate::files) fn rebased(mut self, context: &Context) -> Self {
        let path = match &mut self {
            Self::Path(path) | Self::Sampled(SampledTexture { path, .. }) => path,
        };
        let beside = context.document.folder().join(&*path);
        if !context.is_root && beside.is_file() {
            *path = std::path::absolute(&beside).unwrap_or(beside).display().to_string();
        }
        self
    }
}

impl OverrideFile {
    /// With whole paths where a prefab names files beside itself, so that they mean the same in the scene.
    pub(in crate::files) fn located(mut self, context: &Context) -> Self {
        let grading = self.camera.as_mut().and_then(|camera| camera.lens.grading.as_mut());
        if let Some(path) = grading.filter(|_| !context.is_root) {
            let beside = context.document.folder().join(&*path);
            if beside.is_file() {
                *path = std::path::absolute(&beside).unwrap_or(beside).display().to_string();
            }
        }
        self
    }
}

impl From<WrapFile> for Wrap {
    fn from(wrap: WrapFile) -> Self {
        match wrap {
            WrapFile::Repeat => Self::Repeat,
            WrapFile::Mirror => Self::Mirror,
            WrapFile::Clamp => Self::Clamp,
        }
    }
}
