#!/usr/bin/env bash
# Makes the image debian:N of the Debian release of this machine where no registry can be reached, from the mirror of
# debian-root.sh, from which also the image of the Containerfile then takes its packages. Does nothing when the image is there.
# usage: base-image.sh [DIR]    DIR: a root file system that debootstrap has made already
set -euo pipefail
export CONTAINERS_CONF=${CONTAINERS_CONF:-$(dirname "$(realpath "$0")")/containers.conf}
. /etc/os-release
image=debian:$VERSION_ID

podman image exists "$image" && exit
if [ $# = 1 ]; then
  root=$1
else
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  root=$work/root
  "$(dirname "$0")/debian-root.sh" "$VERSION_CODENAME" "$root"
fi
tar -C "$root" --one-file-system -c . | podman import --change 'CMD ["bash"]' - "$image" >/dev/null
echo "made $image" >&2
