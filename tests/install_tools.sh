#!/bin/sh
# Programs that tests use and pip cannot install. What is missing is installed where this machine
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
for package in $(missing); do
    echo "NOT TESTED: what needs $package (Debian: apt-get install $package)" >&2
done
exit 0
