# Helpers of tools/test and tools/demo: what is there and what can be installed. Sourced, not run.

say() { printf '\n== %s\n' "$*"; }

die() { printf '%s\n' "$*" >&2; exit 1; }

# install_packages PACKAGE..: as root or with sudo, by apt-get; otherwise says what to install.
install_packages() {
    local root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null && root=(sudo)
        [ ${#root[@]} -gt 0 ] || die "Please have these packages installed (there is no sudo here): $*"
    fi
    command -v apt-get >/dev/null || die "This system has no apt-get. Please install what Debian calls: $*"
    say "installing $*"
    "${root[@]}" apt-get update -qq || true
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null ||
        die "apt-get could not install: $*"
}

has_rust() { command -v cargo >/dev/null; }

has_linker() { command -v cc >/dev/null; }

# Without -q, grep reads to the end: ldconfig would die of a broken pipe, which counts as a failure under pipefail.
has_loader() { PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep 'libvulkan\.so\.1' >/dev/null; }

has_driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] ||
        compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}

has_validation() {
    [ -n "${VK_LAYER_PATH:-}" ] ||
        ls /usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json >/dev/null 2>&1
}

has_shader_tools() {
    command -v cmake >/dev/null && command -v c++ >/dev/null && command -v python3 >/dev/null
}

# A compiler with its sanitizers, what builds by cmake, shaders, Vulkan's headers.
has_host_tools() {
    command -v cmake >/dev/null && command -v make >/dev/null && command -v pkg-config >/dev/null &&
        command -v glslangValidator >/dev/null && has_vulkan_headers && has_sanitizers
}

has_vulkan_headers() { [ -e /usr/include/vulkan/vulkan.h ] || pkg-config --exists vulkan || [ -n "${VULKAN_SDK:-}" ]; }

has_sanitizers() { echo 'int main(void) { return 0; }' | cc -x c -fsanitize=address,undefined -o /dev/null - 2>/dev/null; }

# need_rust: Rust is not installed for anybody; its own installer is the way.
need_rust() {
    [ -f "$HOME/.cargo/env" ] && . "$HOME/.cargo/env"
    has_rust || die "Rust is missing: see https://rustup.rs, then run this again."
}

# missing_packages [validation] [cpp] [host] [shaders]: names of the packages to install for building, and for what is named.
missing_packages() {
    has_linker || echo gcc libc6-dev
    has_loader || echo libvulkan1
    has_driver || echo mesa-vulkan-drivers
    case " $* " in *" validation "*) has_validation || echo vulkan-validationlayers ;; esac
    case " $* " in *" cpp "*) command -v c++ >/dev/null || echo g++ ;; esac
    case " $* " in *" host "*) has_host_tools || echo gcc libc6-dev cmake make pkg-config glslang-tools libvulkan-dev ;; esac
    case " $* " in *" shaders "*) has_shader_tools || echo cmake g++ python3 ;; esac
}

# need_packages [validation] [cpp] [host] [shaders]: installs what is missing.
need_packages() {
    local missing
    missing=$(missing_packages "$@" | tr '\n' ' ')
    # shellcheck disable=SC2086 # one word a package
    [ -z "$missing" ] || install_packages $missing
}
