//! The one error type; every variant names its subject.

use std::path::PathBuf;

/// Result of everything fallible in dermis.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What went wrong and with what.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused a file.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file's content is wrong.
    #[error("{}: {element}: {reason}", path.display())]
    Asset {
        /// The file.
        path: PathBuf,
        /// The element in the file, as a JSON pointer (`/accessors/3`) or a name.
        element: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A joint does not exist or cannot be used.
    #[error("joint {joint:?}: {reason}")]
    Joint {
        /// Name of the joint.
        joint: String,
        /// What is wrong with it.
        reason: String,
    },
    /// An extra primitive cannot be used.
    #[error("primitive {primitive:?}: {element}: {reason}")]
    Primitive {
        /// Name of the primitive.
        primitive: String,
        /// The key that is wrong.
        element: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A pose cannot be used.
    #[error("pose: {element}: {reason}")]
    Pose {
        /// The joint or frame.
        element: String,
        /// What is wrong with it.
        reason: String,
    },
    /// An argument is out of its range or contradicts another.
    #[error("{argument}: {reason}")]
    Argument {
        /// The argument as the user knows it.
        argument: String,
        /// What is wrong with it.
        reason: String,
    },
    /// No Vulkan device fits.
    #[error("no Vulkan device: {reason}")]
    NoDevice {
        /// Why not.
        reason: String,
    },
    /// A Vulkan call failed.
    #[error("{call} failed for {subject}: {code}")]
    Vulkan {
        /// Name of the call.
        call: &'static str,
        /// Buffer, image, pass or device that the call was for.
        subject: String,
        /// Name of the VkResult.
        code: String,
    },
    /// An allocation would pass a budget, or failed.
    #[error("memory for {name} ({class}): {bytes} bytes: {reason}")]
    Memory {
        /// Name of the allocation.
        name: String,
        /// Budget class.
        class: &'static str,
        /// Bytes asked for.
        bytes: u64,
        /// Why not.
        reason: String,
    },
    /// A shader and its declaration disagree.
    #[error("pass {pass}: {reason}")]
    Pass {
        /// Name of the pass.
        pass: &'static str,
        /// What disagrees.
        reason: String,
    },
}

impl Error {
    /// An [`Error::Asset`].
    pub fn asset(
        path: impl Into<PathBuf>,
        element: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        Self::Asset {
            path: path.into(),
            element: element.into(),
            reason: reason.into(),
        }
    }

    /// An [`Error::File`].
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::File {
            path: path.into(),
            source,
        }
    }

    /// The same, naming the file that a primitive is from; other errors as they are.
    #[must_use]
    pub fn in_file(self, path: impl Into<PathBuf>) -> Self {
        match self {
            Self::Primitive {
                primitive,
                element,
                reason,
            } => Self::asset(path, format!("primitive {primitive:?}: {element}"), reason),
            other => other,
        }
    }

    /// An [`Error::Argument`].
    pub fn argument(argument: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Argument {
            argument: argument.into(),
            reason: reason.into(),
        }
    }
}
