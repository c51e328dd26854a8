# Minimal Debians in folders, made by debootstrap and entered by chroot, as root. Sourced by what tries things on them.
# shellcheck shell=bash

require_bare_systems() {
  [ "$(id -u)" -eq 0 ] || { echo "$1: not root; a system is made by debootstrap and entered by chroot" >&2; exit 2; }
  command -v debootstrap >/dev/null || { echo "$1: no debootstrap; run apt-get install debootstrap" >&2; exit 2; }
}

# make_bare_system ROOT SUITE PACKAGES: packages with commas between. Nothing where ROOT is one already. It has the host's way
# to packages: proxies, certificates and, of the same suite, its sources.
make_bare_system() {
  local root=$1 suite=$2 packages=$3
  [ ! -e "$root/etc/bare-system" ] || return 0
  debootstrap --variant=minbase --include="$packages" "$suite" "$root" >"$root.log" 2>&1
  cp -a /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
  cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
  [ -d /usr/local/share/ca-certificates ] && cp -a /usr/local/share/ca-certificates "$root/usr/local/share/"
  if [ "$suite" = "$(. /etc/os-release && echo "${VERSION_CODENAME:-}")" ] && [ -n "$(ls /etc/apt/sources.list.d 2>/dev/null)" ]; then
    cp -a /etc/apt/sources.list.d/. "$root/etc/apt/sources.list.d/"
    rm -f "$root/etc/apt/sources.list"
  fi
  chroot "$root" update-ca-certificates >/dev/null 2>&1 || true
  touch "$root/etc/bare-system"
}

# in_bare_system ROOT COMMAND: runs it there with /proc and /dev, and leaves nothing mounted.
in_bare_system() (
  root=$1
  trap 'umount -l "$root/proc" "$root/dev" 2>/dev/null || true' EXIT
  mount -t proc proc "$root/proc" || exit 1
  { mount --rbind /dev "$root/dev" && mount --make-rslave "$root/dev"; } || exit 1
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb LANG=C.UTF-8 bash -c "$2"
)
