#!/bin/sh
# Installs what Cohort builds with, on Debian 12: only what is missing, saying what.
# Usage: sh examples/setup.sh   (root, or a user with sudo)
set -eu

packages="gcc g++ cmake make pkg-config libosd-dev libtbb-dev libopenimageio-dev libopencolorio-dev
libopenexr-dev libdeflate-dev libpng-dev libcmocka-dev"

missing=
for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q '^install ok installed' ||
        missing="$missing $package"
done
[ -n "$missing" ] || exit 0

sudo=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
        echo "setup: these packages are missing, and there is no sudo; install them as root:$missing" >&2
        exit 1
    }
    sudo=sudo
fi
echo "setup: installing$missing"
$sudo apt-get update -q
# shellcheck disable=SC2086
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
