#!/bin/sh
# Builds notcurses' library from Debian's newest source package into .venv-bench/lib, for systems
# that have no libnotcurses-core3. It changes nothing of the system, and needs of it
#     apt install dpkg-dev cmake gcc pkg-config libncurses-dev libunistring-dev zlib1g-dev
set -eu
library=$(pwd)/.venv-bench/lib
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p lists/partial cache/archives/partial
# The mirror is the system's own; its keys say whether the source is Debian's.
mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | head -n 1)
echo "deb-src $mirror sid main" > sources.list
set -- -qq -o Dir::Etc::SourceList="$work/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User=root
apt-get "$@" update
apt-get "$@" source notcurses
cmake -S notcurses-*/ -B build -DCMAKE_BUILD_TYPE=Release -DUSE_MULTIMEDIA=none -DUSE_CXX=OFF \
    -DUSE_PANDOC=OFF -DUSE_POC=OFF -DUSE_STATIC=OFF -DUSE_DEFLATE=OFF -DBUILD_EXECUTABLES=OFF \
    -DBUILD_TESTING=OFF > log
cmake --build build --target notcurses-core >> log 2>&1 || { tail log; exit 1; }
mkdir -p "$library"
cp -P build/libnotcurses-core.so.3* "$library"
