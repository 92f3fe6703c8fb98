//! Animations: translation, rotation and scale channels of the kept nodes (glTF 2.0, 3.11 and appendix C).

use std::collections::HashSet;

use glam::Quat;
use gltf::json::{
    accessor::{ComponentType, Type},
    animation::{Animation, Interpolation as RawInterpolation, Property as RawProperty, Sampler},
    validation::Checked as Parsed,
};

use super::{
    accessor::{Accessor, Format},
    document::Document,
    fault::{Checked, refuse},
    graph,
    names::Names,
};
use crate::asset::{Channel, Clip, Interpolation, Property};

/// Greatest number of floats in all clips; channels may share accessors and so be more than the file.
const VALUE_LIMIT: usize = 1 << 26;

/// Reads all clips; `row` gives the skeleton's row of each node of the file.
pub(super) fn read(
    document: &Document,
    row: &[Option<usize>],
    warnings: &mut Vec<String>,
) -> Checked<Vec<Clip>> {
    let mut clips = Vec::new();
    let mut names = Names::default();
    let mut reader = Reader {
        document,
        row,
        values: 0,
        elsewhere: 0,
        foreign: 0,
    };
    for (number, animation) in document.root.animations.iter().enumerate() {
        let channels = reader.channels(animation, &format!("/animations/{number}"))?;
        let last = |channel: &Channel| channel.times.last().copied().unwrap_or(0.0);
        let seconds = channels.iter().map(last).fold(0.0, f32::max);
        let name = names.unique(animation.name.as_deref(), || format!("clip_{number}"));
        if channels.is_empty() {
            warnings.push(format!("clip {name} moves no joint and is left out"));
            continue;
        }
        clips.push(Clip {
            name,
            seconds,
            channels,
        });
    }
    if reader.elsewhere > 0 {
        let count = reader.elsewhere;
        warnings.push(format!(
            "{count} channels drive nodes outside of the skeleton"
        ));
    }
    if reader.foreign > 0 {
        let count = reader.foreign;
        warnings.push(format!(
            "{count} channels drive something else than translation, rotation or scale"
        ));
    }
    Ok(clips)
}

struct Reader<'a> {
    document: &'a Document,
    row: &'a [Option<usize>],
    /// Floats read so far.
    values: usize,
    /// Channels of other nodes.
    elsewhere: usize,
    /// Channels of other properties.
    foreign: usize,
}

impl Reader<'_> {
    fn channels(&mut self, animation: &Animation, element: &str) -> Checked<Vec<Channel>> {
        let mut channels = Vec::new();
        let mut targets = HashSet::new();
        for (number, channel) in animation.channels.iter().enumerate() {
            let element = format!("{element}/channels/{number}");
            let sampler = channel.sampler.value();
            let Some(sampler) = animation.samplers.get(sampler) else {
                let reason = format!(
                    "{sampler}, but there are {} samplers",
                    animation.samplers.len()
                );
                return refuse(format!("{element}/sampler"), reason);
            };
            let property = match channel.target.path {
                Parsed::Valid(RawProperty::Translation) => Property::Translation,
                Parsed::Valid(RawProperty::Rotation) => Property::Rotation,
                Parsed::Valid(RawProperty::Scale) => Property::Scale,
                _ => {
                    self.foreign += 1;
                    continue;
                }
            };
            let target = channel.target.node.value();
            if !targets.insert((target, property as u8)) {
                return refuse(format!("{element}/target"), "another channel drives it too");
            }
            if self.document.root.nodes[target].matrix.is_some() {
                let reason = format!("node {target} has a matrix and cannot be animated");
                return refuse(format!("{element}/target"), reason);
            }
            // Read even where no joint needs it: a broken clip is refused as a whole.
            let channel = self.channel(sampler, property, &element)?;
            match self.row[target] {
                Some(node) => channels.push(Channel { node, ..channel }),
                None => self.elsewhere += 1,
            }
        }
        Ok(channels)
    }

    /// The channel of a sampler, its node still to be set.
    fn channel(
        &mut self,
        sampler: &Sampler,
        property: Property,
        element: &str,
    ) -> Checked<Channel> {
        let interpolation = match sampler.interpolation {
            Parsed::Valid(RawInterpolation::Step) => Interpolation::Step,
            Parsed::Valid(RawInterpolation::Linear) => Interpolation::Linear,
            Parsed::Valid(RawInterpolation::CubicSpline) => Interpolation::CubicSpline,
            Parsed::Invalid => return refuse(element, "unknown interpolation"),
        };
        let times = Accessor::new(self.document, sampler.input.value())?
            .expect(&[Format::float(Type::Scalar)], "key times")?;
        let values = Accessor::new(self.document, sampler.output.value())?
            .expect(output_formats(property), output_role(property))?;
        let keys = times.count;
        let expected = match interpolation {
            Interpolation::CubicSpline => 3 * keys,
            _ => keys,
        };
        if values.count != expected {
            let reason = format!("{} values for {keys} keys, not {expected}", values.count);
            return refuse(format!("{element}/sampler"), reason);
        }
        self.values += keys + 4 * expected;
        if self.values > VALUE_LIMIT {
            return refuse(element, "the clips are too long");
        }
        let times = check_times(times.floats()?, sampler.input.value())?;
        let mut values = values.floats()?;
        if property == Property::Rotation {
            check_rotations(&mut values, interpolation, sampler.output.value())?;
        }
        Ok(Channel {
            node: 0,
            property,
            interpolation,
            times,
            values,
        })
    }
}

const ROTATIONS: &[Format] = &[
    Format::float(Type::Vec4),
    normalized(ComponentType::I8),
    normalized(ComponentType::U8),
    normalized(ComponentType::I16),
    normalized(ComponentType::U16),
];

const fn normalized(component: ComponentType) -> Format {
    Format {
        shape: Type::Vec4,
        component,
        normalized: true,
    }
}

fn output_formats(property: Property) -> &'static [Format] {
    match property {
        Property::Rotation => ROTATIONS,
        _ => const { &[Format::float(Type::Vec3)] },
    }
}

fn output_role(property: Property) -> &'static str {
    match property {
        Property::Translation => "translations",
        Property::Rotation => "rotations",
        Property::Scale => "scales",
    }
}

fn check_times(times: Vec<f32>, accessor: usize) -> Checked<Vec<f32>> {
    let element = format!("/accessors/{accessor}");
    if times.first().is_some_and(|&first| first < 0.0) {
        return refuse(element, "element 0: a key time below 0");
    }
    match times.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(row) => refuse(
            element,
            format!("element {}: key times do not rise", row + 1),
        ),
        None => Ok(times),
    }
}

/// Makes rotations unit; the tangents of splines stay as they are.
fn check_rotations(
    values: &mut [f32],
    interpolation: Interpolation,
    accessor: usize,
) -> Checked<()> {
    let (rotations, _) = values.as_chunks_mut::<4>();
    for (row, rotation) in rotations.iter_mut().enumerate() {
        if interpolation == Interpolation::CubicSpline && row % 3 != 1 {
            continue;
        }
        match graph::unit(Quat::from_array(*rotation)) {
            Some(unit) => *rotation = unit.to_array(),
            None => {
                let reason = format!("element {row} is not a unit quaternion");
                return refuse(format!("/accessors/{accessor}"), reason);
            }
        }
    }
    Ok(())
}
