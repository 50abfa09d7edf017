#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs the Debian packages that are missing, as root or through sudo; asks nothing. Where nothing is missing it
# does nothing, and needs no network.
#
#   cmake/setup-debian.sh                        all
#   cmake/setup-debian.sh examples benchmarks    what these need; or blender, for its add-on; or tests, which is all
set -euo pipefail

examples=(g++ make cmake libglm-dev libembree-dev libtbb-dev libassimp-dev libcli11-dev libopenexr-dev libstb-dev
    libtinygltf-dev libdraco-dev libmeshoptimizer-dev libvulkan-dev mesa-vulkan-drivers glslc nlohmann-json3-dev)
benchmarks=(libbenchmark-dev gnuplot-nox jq libopenmpi-dev openmpi-bin)
blender=(blender python3-numpy)
tests=(xvfb xauth libxtst6 doctest-dev chromium vulkan-validationlayers clang libclang-rt-14-dev clang-format-14 clang-tidy-14 doxygen)

wanted=("${examples[@]}")
for part in "${@:-tests}"; do
    case $part in
    examples) ;;
    benchmarks) wanted+=("${benchmarks[@]}") ;;
    blender) wanted+=("${blender[@]}") ;;
    tests) wanted+=("${benchmarks[@]}" "${blender[@]}" "${tests[@]}") ;;
    *)
        echo "setup-debian.sh: there are examples, benchmarks, blender and tests to set up, but no '$part'" >&2
        exit 2
        ;;
    esac
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    echo "There is no apt here. These must be installed; the names are those of Debian 12's packages:"
    printf '    %s\n' "${wanted[@]}"
    exit 0
fi

missing=()
for package in "${wanted[@]}"; do
    state=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$state" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

echo "Installing ${missing[*]}"
as_root=(env DEBIAN_FRONTEND=noninteractive)
if [ "$(id -u)" -ne 0 ]; then
    if ! sudo -n true 2>/dev/null; then
        echo "That takes root's rights, and sudo is not there or asks for a password. Run this, then try again:" >&2
        echo "    sudo apt-get update && sudo apt-get install ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo -n "${as_root[@]}")
fi
apt=("${as_root[@]}" apt-get --quiet --option DPkg::Lock::Timeout=300)
"${apt[@]}" update
"${apt[@]}" install --yes --no-install-recommends "${missing[@]}"
