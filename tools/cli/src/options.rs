//! Options that the commands share.

use std::{ops::Range, path::PathBuf};

use clap::{Args, ValueEnum};
use dermis::{
    compose::{Controller, OpeningCurve, Operator},
    deformer::Method,
    rig::SpineChain,
};

use crate::parse::{self, DeviceChoice};

/// Where to compute.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Device")]
pub(crate) struct DeviceOptions {
    /// Device that computes: `auto` takes the best Vulkan device and falls back to `cpu`, which is slow; a number or a
    /// part of a name is one of `dermis devices`.
    #[arg(long, default_value = "auto", value_name = "auto|cpu|INDEX|NAME-PART")]
    pub(crate) device: DeviceChoice,
    /// Turn on Vulkan's validation layer, synchronization validation included; any message makes the command fail.
    #[arg(long)]
    pub(crate) validation: bool,
    /// Refuse to hold more device memory than this, such as 512K, 64M or 1G.
    #[arg(long, value_name = "BYTES", value_parser = parse::bytes)]
    pub(crate) budget: Option<u64>,
}

/// How the character is prepared.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Preparation")]
pub(crate) struct RigOptions {
    /// Operator between a joint's part and its parent's part (repeatable): union, blend or bulge in implicit skinning, where
    /// union is the default; contact, union, bulge or profile in tracking, where contact is.
    #[arg(long, value_name = "NAME=union|blend|bulge|contact|profile", value_parser = parse::joint)]
    pub(crate) joint: Vec<(String, Operator)>,
    /// Opening curve of a joint's operator (repeatable): a preset, or three points cosine:opening with rising cosines
    /// and openings between 0 (full operator) and 1 (union).
    #[arg(long, value_name = "NAME=elbow|finger|b:F,b:F,b:F", value_parser = parse::opening)]
    pub(crate) opening: Vec<(String, OpeningCurve)>,
    /// How deep the contact at a joint goes with the angle between the two surfaces, in tracking (repeatable): a preset, or
    /// three points cosine:depth with rising cosines and depths between 0 (union) and 1. fold, the default, reaches as deep as
    /// skin folds; elbow touches from 90 degrees on, finger sooner, never not at all.
    #[arg(long, value_name = "NAME=elbow|finger|fold|never|c:d,c:d,c:d", value_parser = parse::controller)]
    pub(crate) controller: Vec<(String, Controller)>,
    /// Profile curve of the joints with --joint NAME=profile, in tracking: a JSON file with the surface and the contact line
    /// at some depths of contact, such as assets/profile.json.
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,
    /// Keep the skin of this joint's part from sliding, in tracking (repeatable): it follows the joint rigidly, as do vertices
    /// that the file paints so, with the attribute _RIGID (1 rigid, 0 free).
    #[arg(long, value_name = "JOINT")]
    pub(crate) rigid: Vec<String>,
    /// Bend a chain of joints by fleshing (repeatable): tails, trunks, necks, tentacles, from the joint ROOT to its descendant
    /// TIP. The skin of the chain keeps the volume of every piece, and blends into the rest by its weights. The map says in which
    /// direction flesh gives way: radial (from the spine, the default), normal (in the plane of the bend) or binormal (across).
    #[arg(long, value_name = "ROOT:TIP[=radial|normal|binormal]", value_parser = parse::spine)]
    pub(crate) spine: Vec<SpineChain>,
    /// Size of the bulge at a contact; 0 gives none, 1 is the authors' size.
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse::not_negative)]
    pub(crate) magnitude: f32,
    /// Extra implicit primitives, such as muscles that swell as a joint bends, from a JSON file: a list of {name, joint, start,
    /// end, radius, driver, degrees, scale}. An ellipsoid goes from start to end in the joint's frame, radius thick; while the
    /// driver, a joint, bends from the first of degrees to the second, it goes from the first scale to the second.
    #[arg(long, value_name = "FILE")]
    pub(crate) primitives: Option<PathBuf>,
    /// Subdivide the mesh this many times before the preparation; each time quadruples the triangles.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=4))]
    pub(crate) subdivide: u32,
    /// Keep prepared characters in this folder and take them from there while the file and the options stay the same.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
}

/// A way to deform, as the command line names it.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MethodName {
    /// Linear blend skinning
    Lbs,
    /// Dual quaternion skinning
    Dqs,
    /// Implicit skinning (2013): contact and volume at the joints
    Implicit,
    /// Iso-surface tracking (2014): contact and elasticity, from pose to pose
    Tracking,
}

impl MethodName {
    /// The library's method.
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Lbs => Method::Lbs,
            Self::Dqs => Method::Dqs,
            Self::Implicit => Method::Implicit,
            Self::Tracking => Method::Tracking,
        }
    }

    /// Its word on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Lbs => "lbs",
            Self::Dqs => "dqs",
            Self::Implicit => "implicit",
            Self::Tracking => "tracking",
        }
    }
}

/// Which poses.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Poses")]
pub(crate) struct PoseOptions {
    /// Clip of the file, by name or number; the first one where neither this nor another source of poses is given.
    #[arg(long, value_name = "NAME|INDEX", group = "source")]
    pub(crate) clip: Option<String>,
    /// Poses from a JSON file: joint name → rotation, a list of such objects is a sequence.
    #[arg(long, value_name = "FILE", group = "source")]
    pub(crate) pose: Option<PathBuf>,
    /// This many random poses, independent of each other: bake and render track each of them from rest.
    #[arg(long, value_name = "N", group = "source", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) random: Option<u32>,
    /// The rest pose only.
    #[arg(long, group = "source")]
    pub(crate) rest: bool,
    /// Frames a second at which a clip is sampled and a sequence is played.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = parse::positive)]
    pub(crate) fps: f32,
    /// Frames to take: A..B without B, A..=B with it.
    #[arg(long, value_name = "A..B", value_parser = parse::frames)]
    pub(crate) frames: Option<Range<usize>>,
    /// Seed of the random poses.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Greatest angle of a random pose at a joint, in degrees; 90, or 45 in bench and profile, where it is not given.
    #[arg(long, value_name = "X", value_parser = parse::not_negative)]
    pub(crate) degrees: Option<f32>,
}

/// What is written besides the result.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Output")]
pub(crate) struct ReportOptions {
    /// Write a report as JSON to a file, or with `-` to standard output (the text then goes to standard error).
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}
