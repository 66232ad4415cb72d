# Set-up shared by tools/demo and tools/test; sourced by bash, not run.
# Finds what is missing and installs it with apt on Debian and Ubuntu. When nothing is missing it
# needs no root and calls no apt.

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 1; }

# Whether any folder given as an argument has a file matching the pattern $1.
any_file() {
    local pattern=$1 folder
    shift
    for folder in "$@"; do
        compgen -G "$folder/$pattern" >/dev/null && return 0
    done
    return 1
}

# Sets vulkan_folders to the standard places of "vulkan/$1".
set_vulkan_folders() {
    local -a roots=(
        "${XDG_CONFIG_HOME:-${HOME:-}/.config}" /etc /etc/xdg /usr/local/etc
        "${XDG_DATA_HOME:-${HOME:-}/.local/share}" /usr/local/share /usr/share
    )
    vulkan_folders=("${roots[@]/%//vulkan/$1}")
}

has_linker() { command -v cc >/dev/null; }

has_loader() {
    local ldconfig
    ldconfig=$(PATH="$PATH:/usr/sbin:/sbin" command -v ldconfig) || return 1
    [[ $("$ldconfig" -p) == *libvulkan.so.1* ]] ||
        any_file libvulkan.so.1 ${LD_LIBRARY_PATH:+${LD_LIBRARY_PATH//:/ }}
}

has_driver() {
    [[ -n ${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}${VK_ADD_DRIVER_FILES:-} ]] && return 0
    set_vulkan_folders icd.d
    any_file '*.json' "${vulkan_folders[@]}"
}

has_validation() {
    [[ -n ${VK_LAYER_PATH:-}${VK_ADD_LAYER_PATH:-} ]] && return 0
    set_vulkan_folders explicit_layer.d
    any_file 'VkLayer_khronos_validation*.json' "${vulkan_folders[@]}"
}

# Whether a Python with NumPy is where the tests look for one.
has_numpy() {
    local python
    for python in python3 /usr/bin/python3; do
        "$python" -c 'import numpy' >/dev/null 2>&1 && return 0
    done
    return 1
}

# Whether a window can be opened on a virtual display: the X server, and the libraries that a window is opened with.
has_virtual_display() {
    command -v Xvfb >/dev/null || return 1
    local ldconfig libraries name
    ldconfig=$(PATH="$PATH:/usr/sbin:/sbin" command -v ldconfig) || return 0
    libraries=$("$ldconfig" -p)
    for name in libX11.so.6 libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libxkbcommon-x11.so.0; do
        [[ $libraries == *"$name"* ]] || return 1
    done
}

# Makes sure of a C linker, a Vulkan loader and a Vulkan driver; with the argument "tests", of the
# validation layers, of Python's NumPy and of a virtual display too.
ensure_system() {
    local -a apt=() dnf=() pacman=()
    has_linker || { apt+=(gcc libc6-dev); dnf+=(gcc); pacman+=(gcc); }
    has_loader || { apt+=(libvulkan1); dnf+=(vulkan-loader); pacman+=(vulkan-icd-loader); }
    has_driver || { apt+=(mesa-vulkan-drivers); dnf+=(mesa-vulkan-drivers); pacman+=(vulkan-swrast); }
    if [[ ${1:-} == tests ]] && ! has_validation; then
        apt+=(vulkan-validationlayers)
        dnf+=(vulkan-validation-layers)
        pacman+=(vulkan-validation-layers)
    fi
    if [[ ${1:-} == tests ]] && ! has_numpy; then
        apt+=(python3-numpy)
        dnf+=(python3-numpy)
        pacman+=(python-numpy)
    fi
    if [[ ${1:-} == tests ]] && ! has_virtual_display; then
        apt+=(xvfb libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0)
        dnf+=(xorg-x11-server-Xvfb libX11 libX11-xcb libXcursor libXi libxkbcommon-x11)
        pacman+=(xorg-server-xvfb libx11 libxcursor libxi libxkbcommon-x11)
    fi
    ((${#apt[@]} == 0)) && return 0

    if is_debian; then
        apt_install "${apt[@]}"
    else
        say "error: some system packages are missing; install them and run this again"
        say "  Debian, Ubuntu: apt-get install ${apt[*]}"
        say "  Fedora:         dnf install ${dnf[*]}"
        say "  Arch:           pacman -S ${pacman[*]}"
        exit 1
    fi
}

is_debian() {
    command -v apt-get >/dev/null || return 1
    local id
    id=$(. "${OS_RELEASE:-/etc/os-release}" 2>/dev/null && printf '%s' " ${ID:-} ${ID_LIKE:-} ") || return 1
    [[ $id == *' debian '* || $id == *' ubuntu '* ]]
}

apt_install() {
    local -a as_root=()
    if ((EUID != 0)); then
        command -v sudo >/dev/null || die "missing packages: run 'apt-get install $*' as root, then this again"
        as_root=(sudo)
    fi
    say "installing: $*"
    "${as_root[@]}" apt-get update -qq >&2 || say "warning: apt-get update failed, trying with the lists there are"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >&2 ||
        die "apt-get could not install: $*"
}

ensure_cargo() {
    if ! command -v cargo >/dev/null && [[ -x ${CARGO_HOME:-${HOME:-}/.cargo}/bin/cargo ]]; then
        PATH="${CARGO_HOME:-${HOME:-}/.cargo}/bin:$PATH"
    fi
    command -v cargo >/dev/null || die "cargo is missing: install Rust from https://rustup.rs, then run this again"
}
