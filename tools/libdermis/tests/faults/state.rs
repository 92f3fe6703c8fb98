//! What stands between dermis and Vulkan knows: which calls were made, which of them has to fail, and what is alive. Each
//! thread has its own, since each test has a device of its own.

use std::{
    cell::RefCell,
    collections::{BTreeMap, HashMap},
    ffi::{c_char, c_void},
};

use ash::vk;
use dermis::capi::DM_LOG_ERROR;

/// Which call fails: the one of this name before which `after` of the same name do not, and with what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) name: &'static str,
    pub(crate) after: usize,
    pub(crate) code: vk::Result,
}

#[derive(Default)]
struct State {
    /// Calls that can fail since [`begin`].
    calls: Vec<(&'static str, &'static [vk::Result])>,
    fault: Option<Fault>,
    struck: bool,
    lost: bool,
    /// Errors that a context's log was told.
    told: u32,
    /// Objects that dermis has made and not destroyed, how often each.
    live: BTreeMap<(&'static str, u64), u32>,
    /// Objects that are made once and handed out again: what they are made of, kind and handle.
    shared: HashMap<Vec<u8>, (&'static str, u64)>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

fn with<T>(work: impl FnOnce(&mut State) -> T) -> T {
    STATE.with_borrow_mut(work)
}

/// From now on calls are counted, and one may fail. A lost device is forgotten.
pub(crate) fn begin(fault: Option<Fault>) {
    with(|s| {
        s.calls.clear();
        (s.fault, s.struck, s.lost, s.told) = (fault, false, false, 0);
    });
}

/// Calls since [`begin`], with what each may fail with.
pub(crate) fn calls() -> Vec<(&'static str, &'static [vk::Result])> {
    with(|s| s.calls.clone())
}

/// The call that had to fail since [`begin`] was made.
pub(crate) fn struck() -> bool {
    with(|s| s.struck)
}

/// The log of contexts: counts errors.
pub(crate) unsafe extern "C" fn tell(_: *mut c_void, level: i32, _: *const c_char) {
    with(|s| s.told += u32::from(level == DM_LOG_ERROR));
}

/// Errors that the log was told since [`begin`].
pub(crate) fn told() -> u32 {
    with(|s| s.told)
}

/// Objects that are alive, how many of each kind.
pub(crate) fn live() -> BTreeMap<&'static str, u32> {
    with(|s| {
        let mut kinds = BTreeMap::new();
        for ((kind, _), count) in &s.live {
            *kinds.entry(*kind).or_default() += count;
        }
        kinds
    })
}

/// What a call is to do.
pub(crate) enum Verdict {
    Pass,
    Fail(vk::Result),
    /// From this call on the device is lost.
    Lose,
}

/// Counts a call. Once the device is lost every call that can tell so does.
pub(crate) fn strike(name: &'static str, codes: &'static [vk::Result]) -> Verdict {
    const LOST: vk::Result = vk::Result::ERROR_DEVICE_LOST;
    with(|s| {
        s.calls.push((name, codes));
        match &mut s.fault {
            Some(fault) if fault.name == name && !s.struck => match fault.after.checked_sub(1) {
                Some(after) => {
                    fault.after = after;
                    Verdict::Pass
                }
                None => {
                    assert!(codes.contains(&fault.code), "{fault:?}");
                    (s.struck, s.lost) = (true, fault.code == LOST);
                    if s.lost {
                        Verdict::Lose
                    } else {
                        Verdict::Fail(fault.code)
                    }
                }
            },
            _ if s.lost && codes.contains(&LOST) => Verdict::Fail(LOST),
            _ => Verdict::Pass,
        }
    })
}

/// Notes what a call has made.
pub(crate) fn made<T: vk::Handle + Copy>(
    kind: &'static str,
    result: vk::Result,
    out: *const T,
) -> vk::Result {
    if result == vk::Result::SUCCESS {
        // SAFETY: the driver has just written it.
        let handle = unsafe { *out };
        with(|s| *s.live.entry((kind, handle.as_raw())).or_default() += 1);
    }
    result
}

/// Notes that an object is destroyed; true where it is made once and stays.
pub(crate) fn gone(kind: &'static str, handle: u64) -> bool {
    with(|s| {
        let live = s.live.get_mut(&(kind, handle));
        let count = live.unwrap_or_else(|| panic!("{kind} {handle:#x} is destroyed but not alive"));
        *count -= 1;
        if *count == 0 {
            s.live.remove(&(kind, handle));
        }
        s.shared.values().any(|known| *known == (kind, handle))
    })
}

/// Hands out the object that was made of the same before, or makes it. What takes long is made once for all runs: dermis
/// does not see the difference, and the objects never change.
pub(crate) fn once<T: vk::Handle + Copy>(
    kind: &'static str,
    of: &[u64],
    out: *mut T,
    make: impl FnOnce() -> vk::Result,
) -> vk::Result {
    let mut key = kind.as_bytes().to_vec();
    key.extend(of.iter().flat_map(|word| word.to_ne_bytes()));
    let known = with(|s| s.shared.get(&key).copied());
    let result = match known {
        Some((_, handle)) => {
            // SAFETY: the caller's pointer for the result.
            unsafe { *out = T::from_raw(handle) };
            vk::Result::SUCCESS
        }
        None => make(),
    };
    if result == vk::Result::SUCCESS {
        // SAFETY: just written.
        let handle = unsafe { *out }.as_raw();
        with(|s| s.shared.insert(key, (kind, handle)));
    }
    made(kind, result, out)
}

/// The objects that are made once, with their kinds; forgets them.
pub(crate) fn forget() -> Vec<(&'static str, u64)> {
    with(|s| std::mem::take(&mut s.shared).into_values().collect())
}
