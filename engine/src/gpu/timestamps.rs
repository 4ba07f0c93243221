//! GPU time of named stretches of a command encoder.

use super::Gpu;

/// A pair of timestamps for each of up to `capacity` stretches; without the feature, times are not known.
pub struct TimestampQueries {
    set: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    capacity: u32,
    names: Vec<String>,
    /// Stretches begun and not yet ended; none for one that there was no room for.
    open: Vec<Option<u32>>,
}

impl TimestampQueries {
    /// Room for that many stretches (at most 2048).
    pub fn new(gpu: &Gpu, capacity: u32) -> Self {
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let capacity = capacity.clamp(1, 2048);
        let set = gpu.features.contains(wanted).then(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * capacity + 1,
            });
            let resolved = gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16 * u64::from(capacity),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            (set, resolved)
        });
        Self { set, capacity, names: Vec::new(), open: Vec::new() }
    }

    /// Forgets the stretches of the last frame.
    pub fn reset(&mut self) {
        self.names.clear();
        self.open.clear();
    }

    /// Begins a stretch, which may lie inside another; [`TimestampQueries::end`] must follow. False if there is no
    /// room for it: it is then not timed.
    pub fn begin(&mut self, encoder: &mut wgpu::CommandEncoder, name: &str) -> bool {
        let index = self.names.len() as u32;
        if index >= self.capacity {
            self.open.push(None);
            return false;
        }
        self.open.push(Some(index));
        self.names.push(name.to_string());
        if let Some((set, _)) = &self.set {
            self.write(encoder, set, 2 * index);
        }
        true
    }

    /// Ends the innermost stretch.
    pub fn end(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if let (Some(Some(index)), Some((set, _))) = (self.open.pop(), &self.set) {
            self.write(encoder, set, 2 * index + 1);
        }
    }

    /// Writes a timestamp, and one that nobody reads: lavapipe queues a timestamp with the next piece of rasterisation,
    /// and only a further timestamp flushes it. Alone it may be taken after the dispatch that follows it.
    fn write(&self, encoder: &mut wgpu::CommandEncoder, set: &wgpu::QuerySet, index: u32) {
        encoder.write_timestamp(set, index);
        encoder.write_timestamp(set, 2 * self.capacity);
    }

    /// Records the copy of the times; the last thing before the encoder is submitted.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = 2 * self.names.len() as u32;
        if let (Some((set, resolved)), true) = (&self.set, count > 0) {
            encoder.resolve_query_set(set, 0..count, resolved, 0);
        }
    }

    /// Waits for the device and gives each stretch's time \[ms\], none where the device cannot tell.
    pub fn read(&self, gpu: &Gpu) -> Vec<(String, Option<f64>)> {
        let ticks = self.set.as_ref().and_then(|(_, resolved)| super::read_buffer::<u64>(gpu, resolved).ok());
        let period = f64::from(gpu.queue.get_timestamp_period());
        let time = |index: usize| {
            let ticks = ticks.as_ref()?;
            let span = ticks.get(2 * index + 1)?.saturating_sub(*ticks.get(2 * index)?);
            Some(span as f64 * period * 1e-6)
        };
        self.names.iter().cloned().enumerate().map(|(index, name)| (name, time(index))).collect()
    }
}
