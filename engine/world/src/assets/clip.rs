//! Animation clips of glTF files: curves over time for the nodes of a model (glTF 2.0, section 3.11 and appendix C).

use std::collections::BTreeMap;

/// A named animation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Name; `animation N` if the file has none.
    pub name: String,
    /// Time of the last key of all \[s\].
    pub duration: f64,
    /// Curves of the nodes that it moves, by the node's index.
    pub nodes: BTreeMap<usize, NodeCurves>,
}

impl Clip {
    /// Whether it says where a node is.
    pub fn moves(&self, node: usize) -> bool {
        self.nodes.get(&node).is_some_and(|c| c.translation.is_some() || c.rotation.is_some() || c.scale.is_some())
    }
}

/// The curves of one node in a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeCurves {
    /// Translation \[m\].
    pub translation: Option<Curve>,
    /// Rotation, quaternions x, y, z, w.
    pub rotation: Option<Curve>,
    /// Scale.
    pub scale: Option<Curve>,
    /// Weights of the morph targets of the node's mesh.
    pub weights: Option<Curve>,
}

/// Interpolation between the keys of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The value of the last key that has passed.
    Step,
    /// A straight line; for rotations the shortest arc.
    Linear,
    /// A cubic Hermite spline with tangents of its own: each key has an in-tangent, a value and an out-tangent.
    Cubic,
}

/// Values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Times of the keys \[s\], growing.
    pub times: Vec<f32>,
    /// Values of all keys one after the other; with [`Between::Cubic`] three for each key.
    pub values: Vec<f32>,
    /// Numbers of a value.
    pub width: usize,
    /// Interpolation between keys.
    pub between: Between,
    /// Values are unit quaternions.
    pub is_rotation: bool,
}

impl Curve {
    /// The value at a time \[s\]; before the first key and after the last theirs.
    pub fn at(&self, time: f64) -> Vec<f32> {
        let next = self.times.partition_point(|t| f64::from(*t) <= time);
        let last = self.times.len().saturating_sub(1);
        let lanes = if next == 0 || next > last || self.between == Between::Step {
            self.value(next.saturating_sub(1).min(last))
        } else {
            self.inside(next - 1, time)
        };
        let lanes = if self.is_rotation { normalized(lanes) } else { lanes };
        lanes.into_iter().map(|v| v as f32).collect()
    }

    /// Between the keys `key` and `key + 1`.
    fn inside(&self, key: usize, time: f64) -> Vec<f64> {
        let (start, end) = (f64::from(self.times[key]), f64::from(self.times[key + 1]));
        let span = end - start;
        let s = (time - start) / span;
        let (a, mut b) = (self.value(key), self.value(key + 1));
        match self.between {
            Between::Cubic => {
                let (out, into) = (self.triple(key, 2), self.triple(key + 1, 0));
                let (s2, s3) = (s * s, s * s * s);
                let weights =
                    [2.0 * s3 - 3.0 * s2 + 1.0, span * (s3 - 2.0 * s2 + s), 3.0 * s2 - 2.0 * s3, span * (s3 - s2)];
                let lane =
                    |i: usize| weights[0] * a[i] + weights[1] * out[i] + weights[2] * b[i] + weights[3] * into[i];
                (0..self.width).map(lane).collect()
            }
            _ if self.is_rotation => {
                let cosine = dot(&a, &b);
                // The same rotation by the quaternion that is nearer.
                if cosine < 0.0 {
                    b.iter_mut().for_each(|v| *v = -*v);
                }
                let angle = cosine.abs().min(1.0).acos();
                let sin = angle.sin();
                let (wa, wb) = match sin < 1e-6 {
                    true => (1.0 - s, s),
                    false => (((1.0 - s) * angle).sin() / sin, (s * angle).sin() / sin),
                };
                a.iter().zip(&b).map(|(a, b)| wa * a + wb * b).collect()
            }
            _ => a.iter().zip(&b).map(|(a, b)| a + s * (b - a)).collect(),
        }
    }

    fn value(&self, key: usize) -> Vec<f64> {
        self.triple(key, 1)
    }

    /// In-tangent, value or out-tangent of a key; curves that are not cubic have values alone.
    fn triple(&self, key: usize, part: usize) -> Vec<f64> {
        let index = if self.between == Between::Cubic { 3 * key + part } else { key };
        let values = self.values.get(index * self.width..(index + 1) * self.width).unwrap_or(&[]);
        (0..self.width).map(|i| values.get(i).map_or(0.0, |v| f64::from(*v))).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The unit quaternion; no rotation for one without direction.
fn normalized(q: Vec<f64>) -> Vec<f64> {
    let length = dot(&q, &q).sqrt();
    if length > 1e-9 && length.is_finite() {
        q.into_iter().map(|v| v / length).collect()
    } else {
        vec![0.0, 0.0, 0.0, 1.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(between: Between, times: &[f32], values: &[f32], width: usize) -> Curve {
        Curve { times: times.to_vec(), values: values.to_vec(), width, between, is_rotation: width == 4 }
    }

    #[test]
    fn steps_lines_and_ends() {
        let step = curve(Between::Step, &[1.0, 2.0], &[10.0, 20.0], 1);
        assert_eq!([0.0, 1.5, 2.0, 9.0].map(|t| step.at(t)[0]), [10.0, 10.0, 20.0, 20.0]);
        let line = curve(Between::Linear, &[1.0, 3.0], &[0.0, 1.0, 4.0, -1.0], 2);
        assert_eq!([line.at(0.5), line.at(1.5), line.at(3.0)], [[0.0, 1.0], [1.0, 0.5], [4.0, -1.0]]);
    }

    #[test]
    fn splines_go_through_values_with_their_tangents() {
        // Key 0: in 9, value 0, out 1; key 1: in 2, value 3, out 9; over 2 s.
        let spline = curve(Between::Cubic, &[0.0, 2.0], &[9.0, 0.0, 1.0, 2.0, 3.0, 9.0], 1);
        assert_eq!([spline.at(0.0)[0], spline.at(2.0)[0]], [0.0, 3.0]);
        // At the middle: (a + b)/2 + span·(out − in)/8.
        assert_eq!(spline.at(1.0)[0], 1.5 + 2.0 * (1.0 - 2.0) / 8.0);
        let slope = (f64::from(spline.at(1e-3)[0])) / 1e-3;
        assert!((slope - 1.0).abs() < 1e-2, "{slope}");
    }

    #[test]
    fn rotations_take_the_short_way_and_stay_of_unit_length() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // No turn, then a quarter about z, written as the quaternion of the other sign.
        let turn = curve(Between::Linear, &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half], 4);
        let [_, _, z, w] = turn.at(0.5)[..] else { panic!("four numbers") };
        let expected = (std::f32::consts::PI / 8.0).sin_cos();
        assert!((z - expected.0).abs() < 1e-6 && (w - expected.1).abs() < 1e-6, "{z} {w}");
        let zero = curve(Between::Step, &[0.0], &[0.0; 4], 4);
        assert_eq!(zero.at(0.0), [0.0, 0.0, 0.0, 1.0]);
    }
}
