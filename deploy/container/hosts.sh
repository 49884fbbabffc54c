#!/usr/bin/env bash
# Starts the hosts of a cell file as podman containers on a bridge, each with the address that the cell file gives it.
#
# usage: hosts.sh up CELL | down CELL | run CELL COMMAND…     e.g. hosts.sh run three_hosts.yaml status
#   HECATON_IMAGE  the image (hecaton)
set -euo pipefail
export CONTAINERS_CONF=${CONTAINERS_CONF:-$(dirname "$(realpath "$0")")/containers.conf}
image=${HECATON_IMAGE:-hecaton}

usage() {
  sed -n 's/^# usage: /usage: /p' "$0" >&2
  exit 2
}
[ $# -ge 2 ] && [ -r "$2" ] || usage
action=$1
file=$(realpath "$2")
shift 2
folder=$(dirname "$file")
look=(podman run --rm --network none --volume "$folder:$folder:ro" "$image" check "$file" -o yaml)

# "name address" of each host, one a line.
hosts() {
  "${look[@]}" | awk '
    { gsub(/"/, "") }
    /^[a-z]/ { inside = ($1 == "hosts:") }
    inside && /- name:/ { name = $3 }
    inside && /address:/ { print name, $2 }'
}
cell=$("${look[@]}" | awk '{ gsub(/"/, "") } $1 == "cell:" { print $2 }')
network=hecaton-$cell

case $action in
  up)
    # What a run must remember is in the machine's memory: see compose.yaml. (Podman 4.3 would also keep the container's own.)
    read -r _ address <<<"$(hosts)"
    podman network create --disable-dns --subnet "${address%.*}.0/24" "$network" >/dev/null
    hosts | while read -r host address; do
      podman run --detach --name "$network-$host" --hostname "$host" --network "$network" --ip "$address" \
        --restart unless-stopped --memory 1g --cap-add IPC_LOCK --cap-add SYS_NICE --read-only --tmpfs /tmp --volume "$folder:$folder:ro" \
        --volume /dev/shm:/run/hecaton --env TMPDIR=/run/hecaton \
        "$image" agent "$file" --host "$host" >/dev/null
      echo "$host $address"
    done
    ;;
  down)
    hosts | while read -r host _; do podman rm --force --ignore "$network-$host" >/dev/null; done
    podman network rm --force "$network" >/dev/null
    ;;
  run)
    podman run --rm --network "$network" --volume "$folder:$folder:ro" "$image" "$@" --cell "$file"
    ;;
  *) usage ;;
esac
