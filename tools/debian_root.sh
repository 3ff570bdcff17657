# shellcheck shell=bash
# A bare Debian 12 in a folder, from this system's own apt sources. Root only.

# make_debian_root DIR: mirror, proxy and apt settings are read from apt at run time.
# shellcheck disable=SC2016  # apt expands these itself
make_debian_root() {
    local root=$1 mirror keyring proxy
    mirror=$(apt-get indextargets --format '$(CODENAME) $(REPO_URI)' 'Created-By: Packages' |
        awk '$1 == "bookworm" { print $2; exit }')
    [ -n "$mirror" ] || { echo "no apt source of bookworm found" >&2; return 1; }
    keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    proxy=$(apt-config dump --format '%v%n' Acquire::http::Proxy | head -n 1)
    http_proxy=${proxy:-${http_proxy:-}} debootstrap --variant=minbase --keyring="$keyring" \
        bookworm "$root" "$mirror" || return 1

    rm -f "$root/etc/apt/sources.list"
    cp -a /etc/apt/sources.list "$root/etc/apt/" 2> /dev/null || true
    cp -a /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/debian*.sources \
        "$root/etc/apt/sources.list.d/" 2> /dev/null || true
    cp -a /etc/apt/auth.conf* "$root/etc/apt/" 2> /dev/null || true
    apt-config dump --format '%F "%v";%n' Acquire > "$root/etc/apt/apt.conf.d/99host"
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    # Services are not started in a chroot.
    printf '#!/bin/sh\nexit 101\n' > "$root/usr/sbin/policy-rc.d"
    chmod +x "$root/usr/sbin/policy-rc.d"
}

# in_debian_root DIR COMMAND...: runs it as root in there. The mounts live in a namespace of their
# own and go with it, however the command ends.
# shellcheck disable=SC2016  # the inner shell expands these
in_debian_root() {
    local root=$1
    shift
    unshare --mount --pid --fork --kill-child bash -c '
        mount --make-rprivate / && mount -t proc proc "$0/proc" &&
        exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 TERM=dumb \
            DEBIAN_FRONTEND=noninteractive chroot "$0" "$@"' "$root" "$@"
}
