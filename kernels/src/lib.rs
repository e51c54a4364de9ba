//! SIMD ray kernels of irt.
