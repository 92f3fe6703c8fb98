//! Timings, memory and device as plain data.
