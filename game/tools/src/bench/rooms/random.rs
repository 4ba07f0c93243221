//! Random numbers that are the same on every machine: integers, and floats by operations that IEEE 754 rounds exactly.

/// A stream of random numbers (SplitMix64, Steele et al. 2014).
pub struct Random(u64);

const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// The stream of one room of a seed.
    pub fn new(seed: u64, index: u64) -> Self {
        Self(mix(mix(seed.wrapping_add(STEP)) ^ index.wrapping_mul(STEP)))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        mix(self.0)
    }

    /// A number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number in low..high.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number in low..high whose logarithm is uniform; both above 0. It takes square roots alone: `powf` rounds
    /// differently from machine to machine.
    pub fn log_within(&mut self, low: f64, high: f64) -> f64 {
        let (mut value, mut factor, bits) = (low, high / low, self.next());
        for bit in 0..24 {
            factor = factor.sqrt();
            if bits >> (63 - bit) & 1 == 1 {
                value *= factor;
            }
        }
        value
    }

    /// A whole number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A whole number in low..=high.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high - low + 1)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// The index of one of the weights, by their size.
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        let mut left = self.unit() * weights.iter().sum::<f64>();
        for (index, weight) in weights.iter().enumerate() {
            left -= weight;
            if left < 0.0 {
                return index;
            }
        }
        weights.len().saturating_sub(1)
    }

    /// One of the two signs.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_the_published_one() {
        // First outputs of SplitMix64 from state 0.
        let mut random = Random(0);
        assert_eq!([random.next(), random.next()], [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
    }

    #[test]
    fn numbers_fill_their_ranges_evenly() {
        let mut random = Random::new(1, 2);
        let mean = |draw: &mut dyn FnMut() -> f64| (0..20_000).map(|_| draw()).sum::<f64>() / 20_000.0;
        assert!((mean(&mut || random.within(2.0, 4.0)) - 3.0).abs() < 0.02);
        assert!((mean(&mut || random.log_within(1.0, 30.0).ln()) - 30f64.ln() / 2.0).abs() < 0.03);
        assert!((mean(&mut || random.below(5) as f64) - 2.0).abs() < 0.05);
        assert!((mean(&mut || random.weighted(&[1.0, 0.0, 1.0]) as f64) - 1.0).abs() < 0.03);
        assert!((0..1000).all(|_| (1.0..30.0).contains(&random.log_within(1.0, 30.0))));
    }

    #[test]
    fn rooms_have_streams_of_their_own() {
        let first = |seed, index| Random::new(seed, index).next();
        assert_ne!(first(1, 0), first(0, 1));
        assert_ne!(first(1, 0), first(1, 1));
    }
}
