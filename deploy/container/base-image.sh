#!/usr/bin/env bash
# Makes the image debian:12 where no registry can be reached, from a Debian mirror (DEBIAN_MIRROR, or Debian's own), from which
# also the image of the Containerfile then takes its packages. Nothing is done when it is there.
# usage: base-image.sh [DIR]    DIR: a root file system that debootstrap has made already
set -euo pipefail
export CONTAINERS_CONF=${CONTAINERS_CONF:-$(dirname "$(realpath "$0")")/containers.conf}
image=debian:12

podman image exists "$image" && exit
if [ $# = 1 ]; then
  root=$1
else
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  root=$work/root
  debootstrap --variant=minbase bookworm "$root" ${DEBIAN_MIRROR:+"$DEBIAN_MIRROR"} >&2
fi
tar -C "$root" --one-file-system -c . | podman import --change 'CMD ["bash"]' - "$image" >/dev/null
echo "made $image" >&2
