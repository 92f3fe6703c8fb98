//! What is wrong with which element of a file; becomes [`Error::Asset`](crate::Error) once the path is known.

use std::{fmt, path::Path};

use crate::Error;

/// Result inside the importer.
pub(super) type Checked<T> = Result<T, Fault>;

/// An element of the file and what is wrong with it.
#[derive(Debug)]
pub(super) struct Fault {
    /// JSON pointer or part of the GLB container.
    element: String,
    reason: String,
}

impl Fault {
    pub(super) fn new(element: impl fmt::Display, reason: impl Into<String>) -> Self {
        let mut element = element.to_string();
        // The pointer to the whole document is empty, which reads badly in a message.
        if element.is_empty() {
            element.push('/');
        }
        Self {
            element,
            reason: reason.into(),
        }
    }

    pub(super) fn with_path(self, path: &Path) -> Error {
        Error::asset(path, self.element, self.reason)
    }
}

/// Shorthand for `Err(Fault::new(..))`.
pub(super) fn refuse<T>(element: impl fmt::Display, reason: impl Into<String>) -> Checked<T> {
    Err(Fault::new(element, reason))
}

/// A JSON pointer (RFC 6901) as a chain on the stack; text is made only when something is wrong.
#[derive(Clone, Copy)]
pub(super) enum Pointer<'a> {
    Root,
    Key(&'a Pointer<'a>, &'a str),
    Row(&'a Pointer<'a>, usize),
}

impl fmt::Display for Pointer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pointer::Root => Ok(()),
            Pointer::Key(parent, key) => {
                write!(f, "{parent}/{}", key.replace('~', "~0").replace('/', "~1"))
            }
            Pointer::Row(parent, row) => write!(f, "{parent}/{row}"),
        }
    }
}
