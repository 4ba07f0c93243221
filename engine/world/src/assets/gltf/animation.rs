//! Animations: checked and read into clips.

use super::GltfNode;
use super::accessor::{Buffers, place};
use super::remarks::Remarks;
use crate::assets::clip::{Between, Clip, Curve, NodeCurves};
use crate::assets::{AssetError, parallel};
use gltf::Document;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::animation::{Interpolation, Property};

/// Reads all animations. Tracks that are broken are left out.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    nodes: &[GltfNode],
    remarks: &mut Remarks,
) -> Result<Vec<Clip>, AssetError> {
    let animations: Vec<_> = document.animations().collect();
    let mut clips = Vec::with_capacity(animations.len());
    for result in parallel::map(&animations, |animation| clip(animation, buffers, nodes)) {
        let (clip, found) = result?;
        remarks.append(found);
        clips.push(clip);
    }
    Ok(clips)
}

fn clip(animation: &gltf::Animation, buffers: &Buffers, nodes: &[GltfNode]) -> Result<(Clip, Remarks), AssetError> {
    let index = animation.index();
    let name = animation.name().map_or(format!("animation {index}"), str::to_string);
    let mut clip = Clip { name, ..Clip::default() };
    let mut remarks = Remarks::default();
    for channel in animation.channels() {
        let at = format!("animation {index} \"{}\", channel {}", clip.name, channel.index());
        let node = channel.target().node().index();
        let property = channel.target().property();
        let targets = nodes.get(node).map_or(0, |n| n.weights.len());
        if property == Property::MorphTargetWeights && targets == 0 {
            remarks.push(format!("{at}: moves the weights of node {node}, whose mesh has no morph targets"));
            continue;
        }
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => targets,
        };
        let curve = curve(&channel, width, buffers, &at, &mut remarks);
        let Some(curve) = remarks.part(curve, "left out")? else { continue };
        let slot = slot(clip.nodes.entry(node).or_default(), property);
        if slot.is_some() {
            remarks.fault(format!("{at}: another channel moves the {property:?} of node {node} already; left out"));
            continue;
        }
        clip.duration = clip.duration.max(curve.times.last().map_or(0.0, |t| f64::from(*t)));
        *slot = Some(curve);
    }
    Ok((clip, remarks))
}

fn slot(curves: &mut NodeCurves, property: Property) -> &mut Option<Curve> {
    match property {
        Property::Translation => &mut curves.translation,
        Property::Rotation => &mut curves.rotation,
        Property::Scale => &mut curves.scale,
        Property::MorphTargetWeights => &mut curves.weights,
    }
}

fn curve(
    channel: &gltf::animation::Channel,
    width: usize,
    buffers: &Buffers,
    at: &str,
    remarks: &mut Remarks,
) -> Result<Curve, AssetError> {
    let sampler = channel.sampler();
    let (input, output) = (sampler.input(), sampler.output());
    let times = times(&input, buffers, at, remarks)?;
    let property = channel.target().property();
    let is_rotation = property == Property::Rotation;
    let values = values(&output, width, property, buffers, at, remarks)?;
    let between = match sampler.interpolation() {
        Interpolation::Step => Between::Step,
        Interpolation::Linear => Between::Linear,
        Interpolation::CubicSpline => Between::Cubic,
    };
    let is_weights = property == Property::MorphTargetWeights;
    let place_of_values = format!("{at}, {}", place(&output));
    let (between, values) = keyed(between, values, times.len(), width, is_weights, &place_of_values, remarks);
    if between == Between::Cubic && times.len() < 2 {
        remarks.fault(format!("{at}, {}: a spline needs two keys; its value stands still", place(&input)));
    }
    let of_each = width * per_key(between);
    let (times, values) = in_order(times, &values, of_each, &format!("{at}, {}", place(&input)), remarks);
    let values = if is_rotation && between != Between::Cubic { unit_turns(values) } else { values };
    if times.is_empty() {
        return Err(AssetError::format(buffers.path, at, "has no key"));
    }
    Ok(Curve { times, values, width, between, is_rotation })
}

/// Rotations of unit length, between which the shortest arc leads. Those that are so already keep their bits.
fn unit_turns(mut values: Vec<f32>) -> Vec<f32> {
    for turn in values.as_chunks_mut::<4>().0 {
        let squared: f32 = turn.iter().map(|v| v * v).sum();
        if squared > 0.0 && squared.is_finite() && (squared - 1.0).abs() > 1e-3 {
            turn.iter_mut().for_each(|v| *v /= squared.sqrt());
        }
    }
    values
}

/// Values of a key: of a spline it has tangents too.
fn per_key(between: Between) -> usize {
    if between == Between::Cubic { 3 } else { 1 }
}

/// Interpolation and values that fit each other and the keys. Exporters are known to name a spline and to write values alone, the
/// other way round, and to write weights for more or fewer morph targets than the mesh has.
fn keyed(
    between: Between,
    values: Vec<f32>,
    keys: usize,
    width: usize,
    is_weights: bool,
    at: &str,
    remarks: &mut Remarks,
) -> (Between, Vec<f32>) {
    let (found, each) = (values.len(), per_key(between));
    let wanted = keys * width * each;
    if found == wanted {
        return (between, values);
    }
    let problem = format!("{at}: {found} numbers for {keys} keys; there must be {wanted}");
    if between == Between::Cubic && found == keys * width {
        remarks.fault(format!("{problem}; taken for values without tangents, between which it is linear"));
        return (Between::Linear, values);
    }
    if between == Between::Linear && !is_weights && found == 3 * keys * width {
        remarks.fault(format!("{problem}; taken for a spline"));
        return (Between::Cubic, values);
    }
    let of_each = found.checked_div(keys * each).filter(|of_each| is_weights && of_each * keys * each == found);
    if let Some(of_each) = of_each.filter(|of_each| *of_each > 0) {
        remarks.fault(format!("{problem}; of {of_each} weights a key those of {width} morph targets are taken"));
        let fitted = |key: &[f32]| (0..width).map(|i| key.get(i).copied().unwrap_or(0.0)).collect::<Vec<_>>();
        return (between, values.chunks_exact(of_each).flat_map(fitted).collect());
    }
    remarks.fault(format!("{problem}; keys with all of theirs are kept"));
    (between, values)
}

/// The keys in the order of their times, each with so many values. Of those at one time all are kept, which makes a jump: they
/// get times that differ by the least that a float can tell.
fn in_order(times: Vec<f32>, values: &[f32], of_each: usize, at: &str, remarks: &mut Remarks) -> (Vec<f32>, Vec<f32>) {
    let keys = times.iter().copied().zip(values.chunks_exact(of_each));
    let mut keys: Vec<_> = keys.filter(|(t, key)| t.is_finite() && key.iter().all(|v| v.is_finite())).collect();
    let whole = times.len().min(values.len() / of_each);
    if keys.len() < whole {
        remarks.fault(format!("{at}: {} keys are not finite; left out", whole - keys.len()));
    }
    if let Some(early) = times.iter().find(|time| **time < 0.0) {
        remarks.fault(format!("{at}: time {early} is negative"));
    }
    if let Some(i) = (1..times.len()).find(|i| times[*i] < times[i - 1]) {
        remarks.fault(format!("{at}: time {i} is {}, after {}; keys are sorted", times[i], times[i - 1]));
    }
    keys.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut equal = None;
    for i in 1..keys.len() {
        if keys[i].0 <= keys[i - 1].0 {
            equal = equal.or(Some(keys[i].0));
            keys[i].0 = keys[i - 1].0.next_up();
        }
    }
    if let Some(time) = equal {
        remarks.fault(format!("{at}: has several keys at {time} s; the value jumps there"));
    }
    (keys.iter().map(|(time, _)| *time).collect(), keys.iter().flat_map(|(_, key)| key.iter().copied()).collect())
}

fn times(input: &Accessor, buffers: &Buffers, at: &str, remarks: &mut Remarks) -> Result<Vec<f32>, AssetError> {
    let at = format!("{at}, {}", place(input));
    if input.dimensions() != Dimensions::Scalar {
        return Err(AssetError::format(buffers.path, at, "times must be float scalars"));
    }
    if input.data_type() != DataType::F32 {
        remarks.fault(format!("{at}: times must be floats, not {:?}; read all the same", input.data_type()));
    }
    Ok(buffers.vectors::<1>(input)?.into_flattened())
}

/// The values of a track whose value has so many numbers. Integers that are not marked as normalised stand for themselves only
/// where they can be more than 1.
fn values(
    output: &Accessor,
    width: usize,
    property: Property,
    buffers: &Buffers,
    at: &str,
    remarks: &mut Remarks,
) -> Result<Vec<f32>, AssetError> {
    let at = format!("{at}, {}", place(output));
    let fail = |problem: String| Err(AssetError::format(buffers.path, &at, problem));
    let is_unit = output.normalized() && output.data_type() != DataType::U32;
    let is_share = output.normalized() || matches!(property, Property::Rotation | Property::MorphTargetWeights);
    if output.data_type() != DataType::F32 && !is_unit {
        let outcome = if is_share { "taken as normalised" } else { "taken as they are" };
        remarks.fault(format!("{at}: values must be floats or normalised integers; {outcome}"));
    }
    let (count, found) = (output.count(), output.dimensions().multiplicity());
    match output.dimensions() {
        Dimensions::Scalar => Ok(buffers.loose_vectors::<1>(output, count, 1, [0.0], is_share)?.into_flattened()),
        Dimensions::Vec3 if width == 3 => {
            Ok(buffers.loose_vectors::<3>(output, count, 3, [0.0; 3], is_share)?.into_flattened())
        }
        Dimensions::Vec4 if width == 4 => {
            Ok(buffers.loose_vectors::<4>(output, count, 4, [0.0; 4], is_share)?.into_flattened())
        }
        other => {
            fail(format!("values of the type {other:?} move nothing of {width} numbers; it has {}", found * count))
        }
    }
}
