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
    let times = times(&input, buffers, at)?;
    let values = values(&output, buffers, at)?;
    let between = match sampler.interpolation() {
        Interpolation::Step => Between::Step,
        Interpolation::Linear => Between::Linear,
        Interpolation::CubicSpline => Between::Cubic,
    };
    if between == Between::Cubic && times.len() < 2 {
        remarks.fault(format!("{at}, {}: a spline needs two keys; its value stands still", place(&input)));
    }
    let of_each = width * if between == Between::Cubic { 3 } else { 1 };
    if values.len() != times.len() * of_each {
        let (found, wanted) = (values.len(), times.len() * of_each);
        let outcome = "keys with all of theirs are kept";
        remarks.fault(format!(
            "{at}, {}: {found} numbers for {} keys; there must be {wanted}; {outcome}",
            place(&output),
            times.len()
        ));
    }
    let (times, values) = in_order(times, &values, of_each, &format!("{at}, {}", place(&input)), remarks);
    if times.is_empty() {
        return Err(AssetError::format(buffers.path, at, "has no key"));
    }
    let is_rotation = channel.target().property() == Property::Rotation;
    Ok(Curve { times, values, width, between, is_rotation })
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

fn times(input: &Accessor, buffers: &Buffers, at: &str) -> Result<Vec<f32>, AssetError> {
    let is_unit = input.normalized() && input.data_type() != DataType::U32;
    if (input.data_type() != DataType::F32 && !is_unit) || input.dimensions() != Dimensions::Scalar {
        let problem = "times must be float scalars";
        return Err(AssetError::format(buffers.path, format!("{at}, {}", place(input)), problem));
    }
    Ok(buffers.vectors::<1>(input)?.into_flattened())
}

fn values(output: &Accessor, buffers: &Buffers, at: &str) -> Result<Vec<f32>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, format!("{at}, {}", place(output)), problem));
    let is_unit = output.normalized() && output.data_type() != DataType::U32;
    if output.data_type() != DataType::F32 && !is_unit {
        return fail("values must be floats or normalised integers".into());
    }
    match output.dimensions() {
        Dimensions::Scalar => Ok(buffers.vectors::<1>(output)?.into_flattened()),
        Dimensions::Vec3 => Ok(buffers.vectors::<3>(output)?.into_flattened()),
        Dimensions::Vec4 => Ok(buffers.vectors::<4>(output)?.into_flattened()),
        other => fail(format!("values of the type {other:?} move nothing")),
    }
}
