//! What the fragment shader draws.
