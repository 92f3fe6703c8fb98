//! What the device can do at best, measured in the same run as everything else.
