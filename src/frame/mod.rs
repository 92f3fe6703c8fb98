//! A frame as data: an ordered list of passes; derives barriers, adds labels and timestamps, records.
