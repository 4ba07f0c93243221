//! Counts of requests of the host to the device, which do not depend on the machine.

use std::fmt;

/// Counts of requests of the host to the device. They are of all that goes through [`Gpu`](super::Gpu) and the render graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostCounts {
    /// Compute dispatches.
    pub dispatches: u64,
    /// Compute passes; several dispatches may share one.
    pub compute_passes: u64,
    /// Render passes.
    pub render_passes: u64,
    /// Submits to the queue.
    pub submits: u64,
    /// Bind groups made.
    pub bind_groups: u64,
    /// Buffers made.
    pub buffers: u64,
    /// Bytes uploaded into buffers and textures.
    pub uploaded: u64,
    /// Waits for the device.
    pub waits: u64,
    /// Pipelines made.
    pub pipelines: u64,
    /// Expressions and statements of their entry points, every call inlined: what the driver compiles.
    pub operations: u64,
}

impl HostCounts {
    /// All counts with their names.
    pub fn named(&self) -> [(&'static str, u64); 10] {
        [
            ("dispatches", self.dispatches),
            ("compute passes", self.compute_passes),
            ("render passes", self.render_passes),
            ("submits", self.submits),
            ("bind groups made", self.bind_groups),
            ("buffers made", self.buffers),
            ("bytes uploaded", self.uploaded),
            ("waits", self.waits),
            ("pipelines made", self.pipelines),
            ("operations compiled", self.operations),
        ]
    }

    /// The counts since then.
    pub fn since(&self, then: &Self) -> Self {
        Self {
            dispatches: self.dispatches - then.dispatches,
            compute_passes: self.compute_passes - then.compute_passes,
            render_passes: self.render_passes - then.render_passes,
            submits: self.submits - then.submits,
            bind_groups: self.bind_groups - then.bind_groups,
            buffers: self.buffers - then.buffers,
            uploaded: self.uploaded - then.uploaded,
            waits: self.waits - then.waits,
            pipelines: self.pipelines - then.pipelines,
            operations: self.operations - then.operations,
        }
    }
}

impl fmt::Display for HostCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts: Vec<String> = self.named().map(|(name, count)| format!("{count} {name}")).into();
        f.pad(&counts.join(", "))
    }
}
