# shellcheck shell=bash
# Sourced by the other scripts: sees to it that the project can be built and run on this machine.
#
# On Debian and Ubuntu it installs what is missing (with sudo unless run as root); elsewhere it says what is missing:
#   a C linker, a C++ compiler, Rust (said only), a Vulkan driver where there is none, and, where there is a display, three X11 libraries.
# Sets CARGO_TARGET_DIR and XDG_RUNTIME_DIR unless they are set.

export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$HOME/.cache/bevy_field_patterns/target}"
# Mesa's software driver complains on stderr without it.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-${TMPDIR:-/tmp}}"

has() { command -v "$1" >/dev/null 2>&1; }

die() {
    echo "error: $*" >&2
    exit 2
}

has_display() { [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; }

# Whether the dynamic linker knows a library.
has_library() { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -F "$1" >/dev/null; }

# Whether any of the files exists; patterns without a match are passed on as they are.
any_file() {
    local file
    for file in "$@"; do
        if [ -e "$file" ]; then return 0; fi
    done
    return 1
}

# Whether the Vulkan loader and a driver's description are there. These variables replace the usual places.
has_vulkan_driver() {
    local listed="${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" files
    has_library libvulkan.so.1 || return 1
    if [ -n "$listed" ]; then
        IFS=: read -r -a files <<<"$listed"
        any_file "${files[@]}" && return 0
        die "VK_DRIVER_FILES or VK_ICD_FILENAMES names no file that exists: $listed"
    fi
    any_file /usr/share/vulkan/icd.d/*.json /usr/local/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json \
        /run/opengl-driver/share/vulkan/icd.d/*.json "${XDG_DATA_HOME:-$HOME/.local/share}"/vulkan/icd.d/*.json
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Installs Debian packages, or says why they are not installed.
install_packages() {
    has apt-get || die "please install what these Debian packages hold: $*"
    [ "$(id -u)" -eq 0 ] || has sudo || die "please run as root: apt-get install $*"
    echo "Installing $*" >&2
    {
        as_root apt-get update -qq &&
            as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "$@"
    } >&2 || die "could not install: $*"
}

setup() {
    has cargo || die "Rust is missing; install it from https://rustup.rs"
    [ "$(uname -s)" = Linux ] || return 0
    local missing=()
    has cc || missing+=(gcc libc6-dev)
    has c++ || missing+=(g++)
    has_vulkan_driver || missing+=(mesa-vulkan-drivers)
    if has_display; then
        has_library libXcursor.so.1 || missing+=(libxcursor1)
        has_library libXi.so.6 || missing+=(libxi6)
        has_library libxkbcommon-x11.so.0 || missing+=(libxkbcommon-x11-0)
    fi
    if [ "${#missing[@]}" -gt 0 ]; then install_packages "${missing[@]}"; fi
}

setup
