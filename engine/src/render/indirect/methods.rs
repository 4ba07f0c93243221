//! The registry of methods: the one place that names them all.

use super::instant_radiosity::InstantRadiosityMethod;
use super::light_culling::LightCullingMethod;
use super::light_volumes::LightVolumesMethod;
use super::none::NoIndirectLight;
use super::path_tracer::PathTracing;
use super::{GiMethod, IndirectMethod, Preset};
use crate::render::error::RenderError;
use std::any::Any;

/// Description of a method for help and interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodInfo {
    /// Its name.
    pub id: GiMethod,
    /// Its full name.
    pub title: &'static str,
    /// One line of help.
    pub about: &'static str,
}

impl MethodInfo {
    /// The description of a method.
    pub fn of(method: &dyn IndirectMethod) -> Self {
        Self { id: method.id(), title: method.title(), about: method.about() }
    }
}

/// The methods that a renderer knows, in the order in which they are listed.
pub struct Methods(Vec<Box<dyn IndirectMethod>>);

impl Methods {
    /// Those of the engine.
    pub fn standard() -> Self {
        Self(vec![
            Box::new(NoIndirectLight),
            Box::new(LightVolumesMethod),
            Box::new(InstantRadiosityMethod::default()),
            Box::new(LightCullingMethod),
            Box::new(PathTracing),
        ])
    }

    /// Adds one. It takes the place of one of the same name.
    pub fn add(&mut self, method: Box<dyn IndirectMethod>) {
        self.0.retain(|known| known.id() != method.id());
        self.0.push(method);
    }

    /// Descriptions of all.
    pub fn list(&self) -> impl Iterator<Item = MethodInfo> {
        self.0.iter().map(|method| MethodInfo::of(method.as_ref()))
    }

    /// The presets of all, each with its method.
    pub fn presets(&self) -> impl Iterator<Item = (GiMethod, &'static Preset)> {
        self.0.iter().flat_map(|method| method.presets().iter().map(|preset| (method.id(), preset)))
    }

    /// The method of that name.
    ///
    /// # Errors
    /// If there is none; the message names those that there are.
    pub fn get(&self, id: GiMethod) -> Result<&dyn IndirectMethod, RenderError> {
        self.0.iter().find(|method| method.id() == id).map(Box::as_ref).ok_or_else(|| self.unknown(id))
    }

    /// As [`Methods::get`].
    ///
    /// # Errors
    /// If there is none.
    pub fn get_mut(&mut self, id: GiMethod) -> Result<&mut dyn IndirectMethod, RenderError> {
        let unknown = self.unknown(id);
        let found = self.0.iter_mut().find(|method| method.id() == id);
        found.map(|method| method.as_mut() as _).ok_or(unknown)
    }

    /// The method of that type, for tools that look into it.
    pub fn of_type<M: IndirectMethod>(&self) -> Option<&M> {
        self.0.iter().find_map(|method| (method.as_ref() as &dyn Any).downcast_ref())
    }

    fn unknown(&self, id: GiMethod) -> RenderError {
        let known = self.0.iter().map(|method| method.id().name()).collect::<Vec<_>>().join(", ");
        RenderError::UnknownMethod { name: id.name(), known }
    }
}
