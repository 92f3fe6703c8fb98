//! The table of handles: the one state that all contexts share. A handle is a number, never an address.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{
    context::Context,
    deformer::Instance,
    embed::HostOutput,
    flesh::Fleshed,
    guard::{Fault, Outcome, dm_result},
    levels::Opened,
    particles::Flying,
    rig::Character,
    spine::SharedSpine,
};
use crate::sphere_mesh::{Collider, Hierarchy};

/// A device, or the CPU in its place. Zero is no context.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_context {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A character, prepared once; immutable, and independent of contexts. Zero is no rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_rig {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// One instance of a rig in a context, or several, which follow poses. Zero is no deformer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_deformer {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A buffer of the host's that frames of one deformer, or particles, are written into. Zero is no output.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_output {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A curve that meshes are bent along; immutable, and independent of contexts. Zero is no spine.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_spine {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// Vertices registered on a spine, to be bent with it. Zero is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_flesh {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A sphere-mesh with all its levels; immutable, and independent of contexts. Zero is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_sphere_mesh {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A level of a sphere-mesh; immutable, and independent of contexts. Zero is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_level {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// A level at one time, ready for collisions; immutable, and independent of contexts. Zero is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_collider {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

/// Particles in a context, and the level that they bounce off. Zero is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct dm_particles {
    /// Number of the handle; it never names another object in the life of the process.
    pub id: u64,
}

type Shared<T> = Arc<Mutex<T>>;

/// What a handle stands for.
#[derive(Clone)]
pub(super) enum Object {
    Context(Shared<Context>),
    Rig(Shared<Character>),
    Deformer(Shared<Instance>),
    Output(Shared<HostOutput>),
    Spine(Shared<SharedSpine>),
    Flesh(Shared<Fleshed>),
    SphereMesh(Shared<Arc<Hierarchy>>),
    Level(Shared<Arc<Opened>>),
    Collider(Shared<Arc<Collider>>),
    Particles(Shared<Flying>),
}

/// A typed handle.
pub(super) trait Handle: Copy {
    /// What it stands for.
    type Object;
    /// How messages call it.
    const NAME: &'static str;
    /// Upper four bits of the number.
    const KIND: u64;

    fn id(self) -> u64;
    fn from_id(id: u64) -> Self;
    fn wrap(object: Shared<Self::Object>) -> Object;
    fn unwrap(object: &Object) -> Option<&Shared<Self::Object>>;
}

macro_rules! handle {
    ($handle:ident, $object:ty, $variant:ident, $kind:literal) => {
        impl Handle for $handle {
            type Object = $object;
            const NAME: &'static str = stringify!($handle);
            const KIND: u64 = $kind;

            fn id(self) -> u64 {
                self.id
            }

            fn from_id(id: u64) -> Self {
                Self { id }
            }

            fn wrap(object: Shared<$object>) -> Object {
                Object::$variant(object)
            }

            fn unwrap(object: &Object) -> Option<&Shared<$object>> {
                match object {
                    Object::$variant(object) => Some(object),
                    _ => None,
                }
            }
        }
    };
}

handle!(dm_context, Context, Context, 1);
handle!(dm_rig, Character, Rig, 2);
handle!(dm_deformer, Instance, Deformer, 3);
handle!(dm_output, HostOutput, Output, 4);
handle!(dm_spine, SharedSpine, Spine, 5);
handle!(dm_flesh, Fleshed, Flesh, 6);
handle!(dm_sphere_mesh, Arc<Hierarchy>, SphereMesh, 7);
handle!(dm_level, Arc<Opened>, Level, 8);
handle!(dm_collider, Arc<Collider>, Collider, 9);
handle!(dm_particles, Flying, Particles, 10);

/// A row of the table.
struct Slot {
    /// How many objects the row has had, from 1 on.
    generation: u32,
    object: Option<Object>,
}

/// Kind in 4 bits, row in 28, generation in 32.
#[derive(Default)]
struct Table {
    slots: Vec<Slot>,
    free: Vec<usize>,
}

const ROWS: usize = 1 << 28;

static TABLE: Mutex<Table> = Mutex::new(Table {
    slots: Vec::new(),
    free: Vec::new(),
});

/// The table is consistent between any two statements.
fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Table {
    fn insert(&mut self, kind: u64, object: Object) -> Option<u64> {
        let row = match self.free.pop() {
            Some(row) => row,
            None if self.slots.len() < ROWS => {
                self.slots.push(Slot {
                    generation: 1,
                    object: None,
                });
                self.slots.len() - 1
            }
            None => return None,
        };
        let slot = &mut self.slots[row];
        slot.object = Some(object);
        Some(kind << 60 | (row as u64) << 32 | u64::from(slot.generation))
    }

    fn slot(&mut self, kind: u64, id: u64) -> Option<(usize, &mut Slot)> {
        let row = (id >> 32) as usize % ROWS;
        let slot = self.slots.get_mut(row)?;
        let fits = id >> 60 == kind && slot.generation == id as u32 && slot.object.is_some();
        fits.then_some((row, slot))
    }

    fn remove(&mut self, kind: u64, id: u64) -> Option<Object> {
        let (row, slot) = self.slot(kind, id)?;
        let object = slot.object.take();
        // A row that has used up its numbers is left.
        if let Some(next) = slot.generation.checked_add(1) {
            slot.generation = next;
            self.free.push(row);
        }
        object
    }
}

/// Puts an object into the table.
pub(super) fn insert<H: Handle>(object: H::Object) -> Outcome<H> {
    let object = H::wrap(Arc::new(Mutex::new(object)));
    let id = table().insert(H::KIND, object);
    id.map(H::from_id)
        .ok_or_else(|| Fault::new(dm_result::DM_ERROR_MEMORY, "too many handles"))
}

/// The object of a handle, alive until the last holder lets go.
pub(super) fn get<H: Handle>(handle: H) -> Outcome<Shared<H::Object>> {
    let mut table = table();
    let slot = table.slot(H::KIND, handle.id());
    let object = slot.and_then(|(_, slot)| H::unwrap(slot.object.as_ref()?).cloned());
    object.ok_or_else(|| no_such(handle))
}

/// Locks an object; after a panic within it, it is refused for good.
pub(super) fn lock<T>(object: &Mutex<T>) -> Outcome<MutexGuard<'_, T>> {
    let locked = object.lock().map_err(|_| {
        let message = "the object was in use when a defect in dermis showed; destroy it";
        Fault::new(dm_result::DM_ERROR_PANIC, message)
    })?;
    #[cfg(test)]
    super::panic_tests::defect();
    Ok(locked)
}

/// Runs `work` on the object of a handle.
pub(super) fn with<H: Handle, T>(
    handle: H,
    work: impl FnOnce(&mut H::Object) -> Outcome<T>,
) -> Outcome<T> {
    let object = get(handle)?;
    let mut object = lock(&object)?;
    work(&mut object)
}

/// Takes an object out of the table; it goes as soon as nothing uses it any more.
pub(super) fn destroy<H: Handle>(handle: H) -> Outcome {
    // Dropped after the table is free again: a device waits for its work.
    let object = table().remove(H::KIND, handle.id());
    object.map(drop).ok_or_else(|| no_such(handle))
}

fn no_such<H: Handle>(handle: H) -> Fault {
    let (name, id) = (H::NAME, handle.id());
    let message = match (id, id >> 60) {
        (0, _) => format!("{name}: the handle is zero"),
        (_, kind) if kind != H::KIND => format!("{name}: {id:#x} is a handle of another kind"),
        _ => format!("{name}: {id:#x} was destroyed or never made"),
    };
    Fault::new(dm_result::DM_ERROR_HANDLE, message)
}
