//! Reading and writing through the caller's pointers: NULL, sizes and text are checked, alignment does not matter.

use std::{
    ffi::{CStr, c_char},
    mem::MaybeUninit,
    path::PathBuf,
};

use bytemuck::{NoUninit, Pod, cast_slice_mut, zeroed_vec};

use super::guard::{Fault, Outcome, dm_result};

/// A struct of the header that begins with its size.
///
/// # Safety
/// The first member is a `u32`, and any bits are a value.
pub(super) unsafe trait Struct: Copy {
    /// Name in the header.
    const NAME: &'static str;
    /// Bytes that it had in earlier versions, which lack its last members; these are then 0.
    const EARLIER: &'static [usize];
}

/// Declares structs that begin with their size; of one that has grown, the member that an earlier version ended before.
macro_rules! structs {
    ($($name:ident $(since $member:ident)*),+) => {
        $(
            // SAFETY: `repr(C)`, `size: u32` first, and only numbers, pointers and optional functions in it.
            unsafe impl $crate::capi::pointer::Struct for $name {
                const NAME: &'static str = stringify!($name);
                const EARLIER: &'static [usize] = &[$(std::mem::offset_of!($name, $member)),*];
            }
        )+
    };
}
pub(super) use structs;

fn null(name: &str) -> Fault {
    Fault::new(dm_result::DM_ERROR_NULL, format!("{name} is NULL"))
}

/// Refuses NULL.
pub(super) fn not_null<T>(pointer: *const T, name: &str) -> Outcome {
    if pointer.is_null() {
        return Err(null(name));
    }
    Ok(())
}

/// Checks a struct that is to be read or written; gives the bytes that the caller has of it.
///
/// # Safety
/// `pointer` is NULL or points to at least the member `size`.
pub(super) unsafe fn check<T: Struct>(pointer: *const T, name: &str) -> Outcome<usize> {
    not_null(pointer, name)?;
    // SAFETY: not NULL; the caller's promise.
    let size = unsafe { pointer.cast::<u32>().read_unaligned() };
    if size as usize == size_of::<T>() || T::EARLIER.contains(&(size as usize)) {
        return Ok(size as usize);
    }
    let (kind, wanted) = (T::NAME, size_of::<T>());
    let message = format!("{name}: size is {size}, a {kind} of this version has {wanted} bytes");
    Err(Fault::new(dm_result::DM_ERROR_STRUCT_SIZE, message))
}

/// Reads a struct.
///
/// # Safety
/// `pointer` is NULL or points to as many bytes as the member `size` says.
pub(super) unsafe fn read<T: Struct>(pointer: *const T, name: &str) -> Outcome<T> {
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: the caller's promise; the size has been checked before the rest is read, it is at most the struct's, and any
    // bits are a value of it.
    unsafe {
        let size = check(pointer, name)?;
        let bytes = value.as_mut_ptr().cast::<u8>();
        bytes.copy_from_nonoverlapping(pointer.cast(), size);
        Ok(value.assume_init())
    }
}

/// Fills a struct behind its size, which the caller has set: as much of it as the caller has.
///
/// # Safety
/// `pointer` is NULL or points to as many bytes as the member `size` says, which may be written.
pub(super) unsafe fn fill<T: Struct>(pointer: *mut T, value: &T, name: &str) -> Outcome {
    let own = size_of::<u32>();
    // SAFETY: the caller's promise; the size has been checked and is at most the struct's.
    unsafe {
        let size = check(pointer, name)?;
        let from = std::ptr::from_ref(value).cast::<u8>();
        let to = pointer.cast::<u8>();
        to.add(own).copy_from(from.add(own), size - own);
    }
    Ok(())
}

/// Writes one value.
///
/// # Safety
/// `pointer` has been checked and may be written.
pub(super) unsafe fn put<T: Copy>(pointer: *mut T, value: T) {
    // SAFETY: the caller's promise.
    unsafe { pointer.write_unaligned(value) }
}

/// Copies an array in, over what `rows` has.
///
/// # Safety
/// `pointer` is NULL or points to as many values as `rows` has.
pub(super) unsafe fn copy_in<T: Pod>(pointer: *const T, rows: &mut [T], name: &str) -> Outcome {
    not_null(pointer, name)?;
    let bytes: &mut [u8] = cast_slice_mut(rows);
    // SAFETY: the caller's promise; bytes need no alignment, and nobody else holds `rows`.
    unsafe {
        pointer
            .cast::<u8>()
            .copy_to(bytes.as_mut_ptr(), bytes.len())
    };
    Ok(())
}

/// Copies `count` values, which have been bounded, into a new array.
///
/// # Safety
/// `pointer` is NULL or points to `count` values.
pub(super) unsafe fn array<T: Pod>(pointer: *const T, count: usize, name: &str) -> Outcome<Vec<T>> {
    let mut rows = zeroed_vec(count);
    // SAFETY: the caller's promise.
    unsafe { copy_in(pointer, &mut rows, name)? };
    Ok(rows)
}

/// Copies an array out, which has room for `room` values.
///
/// # Safety
/// `pointer` is NULL or points to `room` values that may be written.
pub(super) unsafe fn copy_out<T: NoUninit>(
    rows: &[T],
    pointer: *mut T,
    room: usize,
    name: &str,
) -> Outcome {
    not_null(pointer, name)?;
    if room < rows.len() {
        return Err(Fault::size(name, room, rows.len()));
    }
    // SAFETY: there is room; the caller's promise.
    unsafe { copy_wanted(rows, pointer) };
    Ok(())
}

/// Copies an array out unless `pointer` is NULL.
///
/// # Safety
/// `pointer` is NULL or has room for all of `rows`, which may be written.
pub(super) unsafe fn copy_wanted<T: NoUninit>(rows: &[T], pointer: *mut T) {
    if pointer.is_null() {
        return;
    }
    let bytes: &[u8] = bytemuck::cast_slice(rows);
    // SAFETY: there is room; bytes need no alignment, and `rows` is this library's own memory.
    unsafe { pointer.cast::<u8>().copy_from(bytes.as_ptr(), bytes.len()) };
}

/// Bytes for a buffer of the caller, who may ask for their number first: with `out` NULL and no room.
///
/// # Safety
/// `out` is NULL or has room for `room` bytes, `needed` is NULL or may be written.
pub(super) unsafe fn blob(bytes: &[u8], out: *mut u8, room: usize, needed: *mut usize) -> Outcome {
    if !needed.is_null() {
        // SAFETY: not NULL; the caller's promise.
        unsafe { put(needed, bytes.len()) };
    }
    if out.is_null() && room == 0 && !needed.is_null() {
        return Ok(());
    }
    // SAFETY: the caller's promise.
    unsafe { copy_out(bytes, out, room, "out") }
}

/// Text in UTF-8.
///
/// # Safety
/// `pointer` is NULL or points to text that ends with a zero byte.
pub(super) unsafe fn text(pointer: *const c_char, name: &str) -> Outcome<String> {
    not_null(pointer, name)?;
    // SAFETY: not NULL; the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    match text.to_str() {
        Ok(text) => Ok(text.to_owned()),
        Err(_) => Err(Fault::argument(name, "the text is not UTF-8")),
    }
}

/// A path, none for NULL.
///
/// # Safety
/// As [`text`].
pub(super) unsafe fn optional_path(pointer: *const c_char, name: &str) -> Outcome<Option<PathBuf>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    unsafe { text(pointer, name) }.map(|text| Some(text.into()))
}
