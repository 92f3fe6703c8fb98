//! Every buffer and image of a deformer by name.

use crate::gpu::Class;

/// What a resource is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Content fixed when the deformer is made.
    Static,
    /// Uploaded every frame, one a frame slot, with a slice a sub-step.
    Ring,
    /// Written by passes.
    Transient,
    /// A 3D image.
    Image,
}

macro_rules! resources {
    ($($name:ident $label:literal $kind:ident $class:ident,)*) => {
        /// A buffer or image; the label is its name in reports and debuggers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Resource {
            $(#[doc = $label] $name,)*
        }

        impl Resource {
            /// All of them, in order of their numbers.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Name in reports and debuggers.
            pub fn label(self) -> &'static str {
                match self { $(Self::$name => $label,)* }
            }

            /// What it is.
            pub fn kind(self) -> Kind {
                match self { $(Self::$name => Kind::$kind,)* }
            }

            /// Budget class.
            pub fn class(self) -> Class {
                match self { $(Self::$name => Class::$class,)* }
            }
        }
    };
}

resources! {
    Vertices "vertices" Static Mesh,
    FileRows "file_rows" Static Mesh,
    FileNormals "file_normals" Static Mesh,
    WeldedRows "welded_rows" Static Mesh,
    WeldedNormals "welded_normals" Static Mesh,
    InfluenceJoints "influence_joints" Static Mesh,
    InfluenceWeights "influence_weights" Static Mesh,
    RingOffsets "ring_offsets" Static Mesh,
    Rings "rings" Static Mesh,
    MeanValues "mean_values" Static Mesh,
    NeighbourhoodOffsets "neighbourhood_offsets" Static Mesh,
    Neighbourhoods "neighbourhoods" Static Mesh,
    CornerOffsets "corner_offsets" Static Mesh,
    Corners "corners" Static Mesh,
    SeedList "seed_list" Static Mesh,
    SeedRanks "seed_ranks" Static Mesh,
    SeedDispatches "seed_dispatches" Static Mesh,
    IsoValues "iso_values" Static Mesh,
    Directions "directions" Static Mesh,
    Bodies "bodies" Static Mesh,
    RingWeights "ring_weights" Static Mesh,
    FleshRows "flesh_rows" Static Mesh,
    SpineWeights "spine_weights" Static Mesh,
    SpinePoints "spine_points" Static Mesh,
    Opening "opening" Static Operators,
    Atlas "atlas" Image Fields,
    Operators "operators" Image Operators,
    PaletteRing "palette_ring" Ring PoseRing,
    FieldsRing "fields_ring" Ring PoseRing,
    Palette "palette" Transient Transient,
    Fields "fields" Transient Transient,
    Index "index" Transient Transient,
    Geometric "geometric" Transient Transient,
    Positions "positions" Transient Transient,
    Relaxed "relaxed" Transient Transient,
    Rotations "rotations" Transient Transient,
    SmoothNormals "smooth_normals" Transient Transient,
    Anchors "anchors" Transient Transient,
    Gradients "gradients" Transient Transient,
    Status "status" Transient Transient,
    LiveSet "live_set" Transient Transient,
    ContactSet "contact_set" Transient Transient,
    RegionSet "region_set" Transient Transient,
    LiveA "live_a" Transient Transient,
    LiveB "live_b" Transient Transient,
    ContactList "contact_list" Transient Transient,
    RegionList "region_list" Transient Transient,
    Dispatches "dispatches" Transient Transient,
    BetaA "beta_a" Transient Transient,
    BetaB "beta_b" Transient Transient,
    Tracked "tracked" Transient Mesh,
    TrackedBefore "tracked_before" Transient Mesh,
    TrackedSlopes "tracked_slopes" Transient Mesh,
    Corrections "corrections" Transient Mesh,
    Around "around" Transient Mesh,
    TrackA "track_a" Transient Transient,
    TrackB "track_b" Transient Transient,
    TrackC "track_c" Transient Transient,
    SlopesA "slopes_a" Transient Transient,
    SlopesB "slopes_b" Transient Transient,
    Stirs "stirs" Transient Transient,
    Goals "goals" Transient Transient,
    Faults "faults" Transient Transient,
    History "history" Transient Transient,
    SkinPositions "skin_positions" Transient Transient,
    SkinNormals "skin_normals" Transient Transient,
}
