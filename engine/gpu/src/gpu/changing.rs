//! Values on the device of which few change from frame to frame.

use super::Gpu;
use bytemuck::Pod;
use std::ops::Range;

/// Ranges that hold all values which are others than before; two of them are one where no more than `gap` values lie
/// between.
#[doc(hidden)]
pub fn changed<T: PartialEq>(before: &[T], now: &[T], gap: usize) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let differs = |index: &usize| before.get(*index) != now.get(*index);
    for index in (0..now.len()).filter(differs) {
        match ranges.last_mut().filter(|range| index - range.end <= gap) {
            Some(range) => range.end = index + 1,
            None => ranges.push(index..index + 1),
        }
    }
    ranges
}

/// A storage buffer that is written where its values have changed.
#[derive(Debug)]
#[doc(hidden)]
pub struct Changing<T> {
    label: &'static str,
    values: Vec<T>,
    buffer: wgpu::Buffer,
}

impl<T: Pod + PartialEq> Changing<T> {
    /// With values that are not empty.
    pub fn new(gpu: &Gpu, label: &'static str, values: Vec<T>) -> Self {
        let buffer = gpu.storage(label, &values, wgpu::BufferUsages::COPY_DST);
        Self { label, values, buffer }
    }

    /// Takes other values.
    pub fn set(&mut self, gpu: &Gpu, values: Vec<T>) {
        // A write of its own costs about what 4 KiB cost.
        let gap = 4096 / size_of::<T>().max(1);
        if values.len() != self.values.len() {
            *self = Self::new(gpu, self.label, values);
            return;
        }
        gpu.audit.note(self.label, &bytemuck::cast_slice::<T, u8>(&values));
        for range in changed(&self.values, &values, gap) {
            let offset = (range.start * size_of::<T>()) as u64;
            gpu.write_buffer(&self.buffer, offset, bytemuck::cast_slice(&values[range]));
        }
        self.values = values;
    }

    /// The buffer, current after [`Self::set`].
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranges_hold_all_that_changed_and_little_else(
            before in prop::collection::vec(0..3_u8, 0..40),
            now in prop::collection::vec(0..3_u8, 0..40),
            gap in 0..4_usize,
        ) {
            let ranges = changed(&before, &now, gap);
            let mut copy: Vec<u8> = before.iter().copied().chain(std::iter::repeat(9)).take(now.len()).collect();
            for range in &ranges {
                copy[range.clone()].copy_from_slice(&now[range.clone()]);
                let differs = |index: usize| before.get(index) != now.get(index);
                prop_assert!(differs(range.start) && differs(range.end - 1));
            }
            prop_assert_eq!(copy, now);
            prop_assert!(ranges.windows(2).all(|pair| pair[1].start > pair[0].end + gap));
        }
    }
}
