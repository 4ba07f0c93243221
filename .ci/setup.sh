# Sourced by ./play and ./check: makes sure that a Vulkan driver, a C++ compiler and cargo are there.
# As root it installs what is missing with apt-get; otherwise it prints the line that does so, and stops.

# Prints a line about the set-up to the error stream, so that the output of the command stays clean.
say() { printf '%s\n' "$*" >&2; }

# Whether the loader library and at least one driver description exist (macOS and Windows bring their own API).
have_vulkan() {
    case "$(uname -s)" in
        Linux) ;;
        *) return 0 ;;
    esac
    local loader=false driver=false path
    if ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1'; then loader=true; fi
    for path in /usr/lib/libvulkan.so.1 /usr/lib64/libvulkan.so.1 /usr/lib/*/libvulkan.so.1; do
        if [ -e "$path" ]; then loader=true; fi
    done
    if [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]; then driver=true; fi
    for path in /usr/share/vulkan/icd.d/*.json /usr/local/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json; do
        if [ -e "$path" ]; then driver=true; fi
    done
    $loader && $driver
}

# A C++ compiler and linker, which the FLIP metric and Rust itself need.
have_compiler() { command -v c++ >/dev/null || command -v g++ >/dev/null || command -v clang++ >/dev/null; }

# Installs the packages given, or says how and stops.
install_packages() {
    if ! command -v apt-get >/dev/null; then
        say "error: missing on this machine: $* (Debian's names). Install them with your package manager and run again."
        exit 1
    fi
    if [ "$(id -u)" != 0 ]; then
        say "error: something is missing. Install it with this line and run again:"
        say "    sudo apt-get update && sudo apt-get install -y $*"
        exit 1
    fi
    say "installing $* ..."
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq >&2
    apt-get install -y -qq --no-install-recommends "$@" >&2
}

missing=()
have_vulkan || missing+=(mesa-vulkan-drivers libvulkan1)
have_compiler || missing+=(g++)
if [ "${#missing[@]}" != 0 ]; then install_packages "${missing[@]}"; fi
unset missing

if ! command -v cargo >/dev/null && [ -x "${CARGO_HOME:-$HOME/.cargo}/bin/cargo" ]; then
    PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
fi
if ! command -v cargo >/dev/null; then
    say "error: cargo is missing. Install Rust (1.95 or newer) as https://rustup.rs says, for instance with"
    say "    curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y"
    say "and run again."
    exit 1
fi

# Mesa's device-selection layer complains about a missing XDG_RUNTIME_DIR on machines without a desktop, twice a run.
# The program chooses its adapter itself (--adapter), so that nothing is lost without the layer.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then export NODEVICE_SELECT=1; fi
