#!/usr/bin/env bash
# Makes the root file system of a Debian release in DIR with debootstrap (root). Does nothing when DIR is there.
# usage: debian-root.sh SUITE DIR    e.g. debian-root.sh trixie /var/cache/hecaton/trixie
#   DEBIAN_MIRROR  the mirror; by default the one from which apt takes Debian on this machine, or else Debian's own
set -euo pipefail
suite=$1 directory=$2

[ ! -e "$directory" ] || exit 0
mirror=${DEBIAN_MIRROR:-$(apt-get indextargets --format '$(SITE) $(ORIGIN) $(LABEL)' 'Created-By: Packages' 2>/dev/null |
  awk '$2 == "Debian" && $3 == "Debian" && !found { print $1; found = 1 }')}
mkdir -p "$(dirname "$directory")"
work=$(mktemp -d "$directory.XXXXXX") # a root that is only half made is never taken for one
trap 'rm -rf "$work"' EXIT
debootstrap --variant=minbase "$suite" "$work/root" ${mirror:+"$mirror"} >&2
# Packages install faster without a sync after each file. A power cut then costs only this folder, which can be made again.
echo force-unsafe-io >"$work/root/etc/dpkg/dpkg.cfg.d/force-unsafe-io"
mv "$work/root" "$directory"
echo "made $directory, Debian $suite" >&2
