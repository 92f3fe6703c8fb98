//! Offscreen pictures of deformed characters.
