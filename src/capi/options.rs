//! What a caller may choose about a preparation.

use std::{
    ffi::{c_char, c_void},
    path::PathBuf,
    sync::Mutex,
};

use super::{
    guard::{Fault, Outcome, c_text, dm_result, guard},
    pointer::{self, structs},
    shapes::{self, dm_primitive, dm_profile, dm_spine_chain},
};
use crate::{
    asset::Model,
    compose::{Controller, OpeningCurve, Operator, Profile},
    report::Progress,
    rig::{Options, Primitive, Rig, Skeleton},
};

/// Flag of a preparation: compute weights by heat diffusion though the character has some.
pub const DM_RIG_HEAT_WEIGHTS: u32 = 1;

/// Operator of the method: union in implicit skinning, contact in tracking.
pub const DM_OPERATOR_DEFAULT: u32 = 0;
/// Operator: union, with a crease.
pub const DM_OPERATOR_UNION: u32 = 1;
/// Operator: blend, without a crease (implicit skinning).
pub const DM_OPERATOR_BLEND: u32 = 2;
/// Operator: bulge in contact.
pub const DM_OPERATOR_BULGE: u32 = 3;
/// Operator: contact surface (tracking).
pub const DM_OPERATOR_CONTACT: u32 = 4;
/// Operator: the profile curve of dm_rig_options (tracking).
pub const DM_OPERATOR_PROFILE: u32 = 5;

/// Curve over the angle of two surfaces: the operator's own.
pub const DM_CURVE_DEFAULT: u32 = 0;
/// Curve: for elbows and knees.
pub const DM_CURVE_ELBOW: u32 = 1;
/// Curve: for fingers.
pub const DM_CURVE_FINGER: u32 = 2;
/// Curve of a controller: as deep as skin folds.
pub const DM_CURVE_FOLD: u32 = 3;
/// Curve of a controller: no contact.
pub const DM_CURVE_NEVER: u32 = 4;
/// Curve: through the three points that are given with it.
pub const DM_CURVE_POINTS: u32 = 5;

/// How a joint's part meets its parent's part. Zeros besides size and name are the defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_joint_options {
    /// sizeof(dm_joint_options).
    pub size: u32,
    /// DM_OPERATOR_...
    pub op: u32,
    /// Name of the joint, in UTF-8.
    pub name: *const c_char,
    /// Opening of the operator with the angle (implicit skinning): DM_CURVE_DEFAULT, _ELBOW, _FINGER or _POINTS.
    pub opening: u32,
    /// Depth of the contact with the angle (tracking): DM_CURVE_...
    pub controller: u32,
    /// Not 0: the skin of the joint's part follows it rigidly (tracking).
    pub rigid: u32,
    /// Three pairs of cosine, rising, and opening from 0 (full operator) to 1 (union), for DM_CURVE_POINTS.
    pub opening_points: [f32; 6],
    /// Three pairs of cosine, rising, and depth from 0 (union) to 1, for DM_CURVE_POINTS.
    pub controller_points: [f32; 6],
    /// How abruptly the opening changes between its first two and its last two points, for DM_CURVE_POINTS: exponents above 0;
    /// 0 for 1.
    pub opening_exponents: [f32; 2],
    /// The same for the depth.
    pub controller_exponents: [f32; 2],
}

/// Receives how far a preparation is: the user pointer, what is being done, valid during the call only, and items done of all.
///
/// Any thread may call it, one at a time. It must return: neither throw nor jump, and not call dermis. NULL for none.
pub type dm_progress =
    Option<unsafe extern "C" fn(user: *mut c_void, stage: *const c_char, done: u64, total: u64)>;

/// How a character is prepared; dm_rig_options_default fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_rig_options {
    /// sizeof(dm_rig_options).
    pub size: u32,
    /// DM_RIG_HEAT_WEIGHTS or 0.
    pub flags: u32,
    /// How often every triangle is cut into four, 0 to 4.
    pub subdivide: u32,
    /// Magnitude of the bulge operator; 0 gives none, 1 is the authors' size and the default.
    pub magnitude: f32,
    /// Number of joints.
    pub joint_count: u32,
    /// Joints that have other than the defaults; may be NULL where there are none.
    pub joints: *const dm_joint_options,
    /// The profile curve of DM_OPERATOR_PROFILE; may be NULL.
    pub profile: *const dm_profile,
    /// Path of a profile curve as JSON, in place of profile; may be NULL.
    pub profile_file: *const c_char,
    /// Extra primitives (muscles); may be NULL where there are none.
    pub primitives: *const dm_primitive,
    /// Path of extra primitives as JSON, in place of primitives; may be NULL.
    pub primitive_file: *const c_char,
    /// Number of primitives.
    pub primitive_count: u32,
    /// Number of parts.
    pub part_count: u32,
    /// Joint whose part each vertex belongs to, one for each of dm_rig_info.vertices; NULL for that of its greatest weight.
    pub parts: *const u16,
    /// Folder that keeps preparations, which then take milliseconds the next time; may be NULL.
    pub cache: *const c_char,
    /// Receives how far the preparation is; may be NULL.
    pub progress: dm_progress,
    /// First argument of progress.
    pub progress_user: *mut c_void,
    /// Chains of joints that bend by fleshing; may be NULL where there are none.
    pub spines: *const dm_spine_chain,
    /// Number of these.
    pub spine_count: u32,
    /// 0.
    pub reserved: u32,
}

structs!(dm_joint_options, dm_rig_options since spines);

const DEFAULT: dm_rig_options = dm_rig_options {
    size: size_of::<dm_rig_options>() as u32,
    flags: 0,
    subdivide: 0,
    magnitude: 1.0,
    joint_count: 0,
    joints: std::ptr::null(),
    profile: std::ptr::null(),
    profile_file: std::ptr::null(),
    primitives: std::ptr::null(),
    primitive_file: std::ptr::null(),
    primitive_count: 0,
    part_count: 0,
    parts: std::ptr::null(),
    cache: std::ptr::null(),
    progress: None,
    progress_user: std::ptr::null_mut(),
    spines: std::ptr::null(),
    spine_count: 0,
    reserved: 0,
};

/// Fills options with the defaults, those that NULL in their place has.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_rig_options_default(out: *mut dm_rig_options) -> dm_result {
    guard("dm_rig_options_default", || {
        // SAFETY: the caller's promise.
        unsafe {
            pointer::check(out, "out")?;
            pointer::put(out, DEFAULT);
        }
        Ok(())
    })
}

/// The options as Rust has them, the files that they name, and who hears of the progress.
#[derive(Default)]
pub(super) struct Preparation {
    options: Options,
    primitives: Option<PathBuf>,
    cache: Option<PathBuf>,
    progress: Listener,
}

/// Whom to tell how far a preparation is.
#[derive(Default)]
pub(super) struct Listener(Option<Heard>);

struct Heard {
    call: unsafe extern "C" fn(*mut c_void, *const c_char, u64, u64),
    user: Mutex<*mut c_void>,
}

// SAFETY: the caller's function may be called by any thread; the mutex lets one at a time.
unsafe impl Sync for Heard {}

impl Listener {
    /// Tells `call`, where there is one, with `user`.
    pub(super) fn new(call: dm_progress, user: *mut c_void) -> Self {
        Self(call.map(|call| Heard {
            call,
            user: Mutex::new(user),
        }))
    }

    pub(super) fn tell(&self, progress: Progress) {
        let Some(heard) = &self.0 else { return };
        let stage = c_text(progress.stage);
        let user = heard.user.lock();
        let user = user.unwrap_or_else(std::sync::PoisonError::into_inner);
        // SAFETY: promised where the options were given; the text lives until the call returns.
        unsafe {
            (heard.call)(
                *user,
                stage.as_ptr(),
                progress.done as u64,
                progress.total as u64,
            )
        }
    }
}

impl Preparation {
    /// # Safety
    /// `options` is NULL, for the defaults, or valid with all that it points to.
    pub(super) unsafe fn read(options: *const dm_rig_options) -> Outcome<Self> {
        if options.is_null() {
            return Ok(Self::default());
        }
        // SAFETY: the caller's promise, here and below.
        let given = unsafe { pointer::read(options, "options")? };
        if given.flags & !DM_RIG_HEAT_WEIGHTS != 0 {
            let reason = format!("{:#x} has unknown flags", given.flags);
            return Err(Fault::argument("options.flags", reason));
        }
        if given.subdivide > 4 {
            let reason = format!("{} is not in 0 to 4", given.subdivide);
            return Err(Fault::argument("options.subdivide", reason));
        }
        let mut options = Options {
            magnitude: given.magnitude,
            subdivide: given.subdivide,
            heat_weights: given.flags & DM_RIG_HEAT_WEIGHTS != 0,
            ..Options::default()
        };
        let count = given.joint_count as usize;
        // SAFETY: see above.
        unsafe {
            for row in 0..rows(given.joints, count, "options.joints")? {
                add_joint(&mut options, given.joints.add(row))?;
            }
            let count = given.primitive_count as usize;
            for row in 0..rows(given.primitives, count, "options.primitives")? {
                let primitive = shapes::primitive(given.primitives.add(row))?;
                options.primitives.push(primitive);
            }
            let count = given.spine_count as usize;
            for row in 0..rows(given.spines, count, "options.spines")? {
                let spine = shapes::spine_chain(given.spines.add(row))?;
                options.spines.push(spine);
            }
            let count = given.part_count as usize;
            if rows(given.parts, count, "options.parts")? > 0 {
                options.part = Some(pointer::array(given.parts, count, "options.parts")?);
            }
            options.profile = curve(&given)?;
            let primitives =
                pointer::optional_path(given.primitive_file, "options.primitive_file")?;
            if primitives.is_some() && !options.primitives.is_empty() {
                return Err(twice("options.primitive_file"));
            }
            check_profile(&options)?;
            Ok(Self {
                options,
                primitives,
                cache: pointer::optional_path(given.cache, "options.cache")?,
                progress: Listener::new(given.progress, given.progress_user),
            })
        }
    }

    pub(super) fn prepare(mut self, model: &Model) -> Outcome<Rig> {
        if let Some(file) = &self.primitives {
            let skeleton = Skeleton::from_model(model)?;
            let list = Primitive::read(file)?;
            Primitive::check(&list, &skeleton).map_err(|e| e.in_file(file))?;
            self.options.primitives = list;
        }
        let tell = |progress| self.progress.tell(progress);
        let rig = match &self.cache {
            Some(dir) => Rig::prepare_cached(dir, model, &self.options, &tell),
            None => Rig::prepare(model, &self.options, &tell),
        };
        Ok(rig?)
    }
}

/// The number of rows of an array that is NULL only where it has none.
fn rows<T>(pointer: *const T, count: usize, name: &str) -> Outcome<usize> {
    if count > 0 {
        pointer::not_null(pointer, name)?;
    }
    Ok(count)
}

/// The profile curve, from memory or from a file.
///
/// # Safety
/// `given` is valid with all that it points to.
unsafe fn curve(given: &dm_rig_options) -> Outcome<Option<Profile>> {
    // SAFETY: the caller's promise, here and below.
    let file = unsafe { pointer::optional_path(given.profile_file, "options.profile_file")? };
    match (given.profile.is_null(), file) {
        (true, None) => Ok(None),
        (true, Some(file)) => Ok(Some(Profile::read(&file)?)),
        // SAFETY: see above.
        (false, None) => unsafe { shapes::profile(given.profile).map(Some) },
        (false, Some(_)) => Err(twice("options.profile_file")),
    }
}

fn twice(name: &str) -> Fault {
    Fault::argument(name, "the same is given in memory, too")
}

/// A profile that no joint asks for is a mistake.
fn check_profile(options: &Options) -> Outcome {
    let asked = options.joints.iter().any(|(_, o)| *o == Operator::Profile);
    if options.profile.is_some() && !asked {
        let reason = "no joint has DM_OPERATOR_PROFILE";
        return Err(Fault::argument("options.profile", reason));
    }
    Ok(())
}

/// # Safety
/// `joint` is valid with the text that it points to.
unsafe fn add_joint(options: &mut Options, joint: *const dm_joint_options) -> Outcome {
    // SAFETY: the caller's promise.
    let (given, name) = unsafe {
        let given = pointer::read(joint, "options.joints")?;
        let name = pointer::text(given.name, "options.joints.name")?;
        (given, name)
    };
    let operator = match given.op {
        DM_OPERATOR_DEFAULT => None,
        DM_OPERATOR_UNION => Some(Operator::Union),
        DM_OPERATOR_BLEND => Some(Operator::Blend),
        DM_OPERATOR_BULGE => Some(Operator::Bulge),
        DM_OPERATOR_CONTACT => Some(Operator::Contact),
        DM_OPERATOR_PROFILE => Some(Operator::Profile),
        other => return Err(unknown("op", &name, other)),
    };
    let opening = match given.opening {
        DM_CURVE_DEFAULT => None,
        DM_CURVE_ELBOW => Some(OpeningCurve::elbow()),
        DM_CURVE_FINGER => Some(OpeningCurve::finger()),
        DM_CURVE_POINTS => {
            let points = pairs(&given.opening_points);
            let exponents = exponents(given.opening_exponents);
            Some(OpeningCurve::new(points, exponents)?)
        }
        other => return Err(unknown("opening", &name, other)),
    };
    let controller = match given.controller {
        DM_CURVE_DEFAULT => None,
        DM_CURVE_ELBOW => Some(Controller::elbow()),
        DM_CURVE_FINGER => Some(Controller::finger()),
        DM_CURVE_FOLD => Some(Controller::fold()),
        DM_CURVE_NEVER => Some(Controller::never()),
        DM_CURVE_POINTS => {
            let points = pairs(&given.controller_points);
            let exponents = exponents(given.controller_exponents);
            Some(Controller::new(points, exponents)?)
        }
        other => return Err(unknown("controller", &name, other)),
    };
    options.joints.extend(operator.map(|o| (name.clone(), o)));
    options.openings.extend(opening.map(|o| (name.clone(), o)));
    options
        .controllers
        .extend(controller.map(|c| (name.clone(), c)));
    options.rigid.extend((given.rigid != 0).then_some(name));
    Ok(())
}

fn unknown(member: &str, joint: &str, value: u32) -> Fault {
    let reason = format!("{value} is unknown (joint {joint:?})");
    Fault::argument(&format!("options.joints.{member}"), reason)
}

fn pairs(x: &[f32; 6]) -> [(f32, f32); 3] {
    [(x[0], x[1]), (x[2], x[3]), (x[4], x[5])]
}

fn exponents(given: [f32; 2]) -> [f32; 2] {
    given.map(|x| if x == 0.0 { 1.0 } else { x })
}
