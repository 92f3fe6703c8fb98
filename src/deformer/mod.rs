//! The façade: a rig, a device and a method; poses in, skin out.
