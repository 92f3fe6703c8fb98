//! One file a GPU pass, same name: the same computation on the CPU, plain and obvious.
