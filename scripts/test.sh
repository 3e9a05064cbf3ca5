#!/usr/bin/env bash
# Runs every check of the project: formatting, lints, documentation, all tests, and the tests on a device with no more
# than WebGPU's default limits. Stops at the first failure. Needs no GPU and no display.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

heading() { printf '\n=== %s\n' "$*"; }

heading "Formatting"
cargo fmt --check

# Naming an example makes cargo choose the features of Bevy that the lints above chose; `--lib` alone would compile
# Bevy a third time.
heading "Lints"
cargo clippy --all-features --all-targets -- -D warnings

# The crate's own features change nothing of Bevy's, so that only the crate is checked again.
heading "Lints without features"
cargo clippy --tests -- -D warnings

heading "Documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --all-features --no-deps --lib --example viewer

heading "Tests"
cargo test --all-features --tests --examples --benches

heading "Examples in the documentation"
cargo test --all-features --doc

heading "Tests at WebGPU's default limits"
WGPU_SETTINGS_PRIO=webgpu cargo test --all-features --test '*'

heading "All checks passed"
