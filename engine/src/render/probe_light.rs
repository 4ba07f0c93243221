//! The light of probes on its way back from the device.

use super::indirect::light_volumes::sweep;
use crate::gpu::{Gpu, PendingBuffer, ReadbackError};
use crate::scene::ProbePoint;
use glam::Vec3;

/// Indirect irradiance [W/m²] at the probes of a frame, on its way back from the device; see
/// [`Renderer::begin_probe_light`](super::Renderer::begin_probe_light).
pub struct PendingProbes {
    probes: Vec<ProbePoint>,
    /// None where no light volume was filled: the light is zero.
    found: Option<PendingBuffer>,
}

impl PendingProbes {
    pub(super) fn new(probes: Vec<ProbePoint>, found: Option<PendingBuffer>) -> Self {
        Self { probes, found }
    }

    /// The light at each probe if it is there, without a wait; none if it is not there yet. Not to be asked again after
    /// that.
    ///
    /// # Errors
    /// If the device fails.
    pub fn try_take(&mut self, gpu: &Gpu) -> Option<Result<Vec<Vec3>, ReadbackError>> {
        let found = match &mut self.found {
            Some(found) => Some(found.try_take(gpu)?),
            None => None,
        };
        Some(found.transpose().map(|found| self.light(found)))
    }

    /// Waits for the light at each probe.
    ///
    /// # Errors
    /// If the device fails.
    pub fn finish(mut self, gpu: &Gpu) -> Result<Vec<Vec3>, ReadbackError> {
        let found = self.found.take().map(|found| found.finish(gpu)).transpose()?;
        Ok(self.light(found))
    }

    fn light(&self, found: Option<Vec<[f32; 4]>>) -> Vec<Vec3> {
        match found {
            Some(found) => sweep::probe_light(&self.probes, &found),
            None => vec![Vec3::ZERO; self.probes.len()],
        }
    }
}
