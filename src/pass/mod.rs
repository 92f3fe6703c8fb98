//! One file a GPU pass: what it reads and writes, its constants and extent.
