#!/usr/bin/env bash
# Shows the viewer: scripts/demo.sh [MESH] [further arguments of the viewer]
#
# MESH is an OBJ, PLY, STL, glTF or GLB file; without it a built-in model is shown. Where there is a display a window
# opens; elsewhere a picture is drawn, and its path is the last line of the output.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$root/scripts/setup.sh"

viewer() { cargo run --quiet --manifest-path "$root/Cargo.toml" --example viewer -- "$@"; }

echo "Building the viewer; the first time this takes several minutes" >&2
if has_display; then
    viewer "$@"
else
    picture="$CARGO_TARGET_DIR/demo.png"
    # Not the picture of an earlier run.
    rm -f "$picture"
    viewer --screenshot "$picture" "$@"
    echo "$picture"
fi
