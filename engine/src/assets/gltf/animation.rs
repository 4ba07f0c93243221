//! Animations: checked and read into clips.

use super::GltfNode;
use super::accessor::{Buffers, place};
use crate::assets::clip::{Between, Clip, Curve, NodeCurves};
use crate::assets::{AssetError, parallel};
use gltf::Document;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::animation::{Interpolation, Property};

/// Reads all animations.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    nodes: &[GltfNode],
    warnings: &mut Vec<String>,
) -> Result<Vec<Clip>, AssetError> {
    let animations: Vec<_> = document.animations().collect();
    let mut clips = Vec::with_capacity(animations.len());
    for result in parallel::map(&animations, |animation| clip(animation, buffers, nodes)) {
        let (clip, remarks) = result?;
        warnings.extend(remarks);
        clips.push(clip);
    }
    Ok(clips)
}

fn clip(animation: &gltf::Animation, buffers: &Buffers, nodes: &[GltfNode]) -> Result<(Clip, Vec<String>), AssetError> {
    let index = animation.index();
    let name = animation.name().map_or(format!("animation {index}"), str::to_string);
    let mut clip = Clip { name, ..Clip::default() };
    let mut warnings = Vec::new();
    for channel in animation.channels() {
        let at = format!("animation {index} \"{}\", channel {}", clip.name, channel.index());
        let fail = |problem: String| Err(AssetError::format(buffers.path, at.clone(), problem));
        let node = channel.target().node().index();
        let property = channel.target().property();
        let targets = nodes.get(node).map_or(0, |n| n.weights.len());
        if property == Property::MorphTargetWeights && targets == 0 {
            warnings.push(format!("{at}: moves the weights of node {node}, whose mesh has no morph targets"));
            continue;
        }
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => targets,
        };
        let curve = curve(&channel, width, buffers, &at)?;
        clip.duration = clip.duration.max(curve.times.last().map_or(0.0, |t| f64::from(*t)));
        let slot = slot(clip.nodes.entry(node).or_default(), property);
        if slot.replace(curve).is_some() {
            return fail(format!("another channel moves the {property:?} of node {node} already"));
        }
    }
    Ok((clip, warnings))
}

fn slot(curves: &mut NodeCurves, property: Property) -> &mut Option<Curve> {
    match property {
        Property::Translation => &mut curves.translation,
        Property::Rotation => &mut curves.rotation,
        Property::Scale => &mut curves.scale,
        Property::MorphTargetWeights => &mut curves.weights,
    }
}

fn curve(channel: &gltf::animation::Channel, width: usize, buffers: &Buffers, at: &str) -> Result<Curve, AssetError> {
    let sampler = channel.sampler();
    let (input, output) = (sampler.input(), sampler.output());
    let times = times(&input, buffers, at)?;
    let values = values(&output, buffers, at)?;
    let between = match sampler.interpolation() {
        Interpolation::Step => Between::Step,
        Interpolation::Linear => Between::Linear,
        Interpolation::CubicSpline => Between::Cubic,
    };
    let of_each = if between == Between::Cubic { 3 } else { 1 };
    if values.len() != times.len() * width * of_each {
        let problem = format!(
            "{} numbers for {} keys; there must be {}",
            values.len(),
            times.len(),
            times.len() * width * of_each
        );
        return Err(AssetError::format(buffers.path, format!("{at}, {}", place(&output)), problem));
    }
    let is_rotation = channel.target().property() == Property::Rotation;
    Ok(Curve { times, values, width, between, is_rotation })
}

fn times(input: &Accessor, buffers: &Buffers, at: &str) -> Result<Vec<f32>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, format!("{at}, {}", place(input)), problem));
    if input.data_type() != DataType::F32 || input.dimensions() != Dimensions::Scalar {
        return fail("times must be float scalars".into());
    }
    let times: Vec<f32> = buffers.vectors::<1>(input)?.into_flattened();
    for (i, time) in times.iter().enumerate() {
        if !(time.is_finite() && *time >= 0.0) {
            return fail(format!("time {i} is {time}; times must be finite and not negative"));
        }
        if i > 0 && times[i - 1] >= *time {
            return fail(format!("time {i} is {time} and does not come after {}", times[i - 1]));
        }
    }
    Ok(times)
}

fn values(output: &Accessor, buffers: &Buffers, at: &str) -> Result<Vec<f32>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, format!("{at}, {}", place(output)), problem));
    let is_unit = output.normalized() && output.data_type() != DataType::U32;
    if output.data_type() != DataType::F32 && !is_unit {
        return fail("values must be floats or normalised integers".into());
    }
    let values = match output.dimensions() {
        Dimensions::Scalar => buffers.vectors::<1>(output)?.into_flattened(),
        Dimensions::Vec3 => buffers.vectors::<3>(output)?.into_flattened(),
        Dimensions::Vec4 => buffers.vectors::<4>(output)?.into_flattened(),
        other => return fail(format!("values of the type {other:?} move nothing")),
    };
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => fail(format!("value {i} is {}: not a finite number", values[i])),
        None => Ok(values),
    }
}
