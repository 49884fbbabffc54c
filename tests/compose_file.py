"""Checks that a compose file starts the hosts of a cell file, each with its address and nothing else.

usage: compose_file.py COMPOSE CELL     CELL: the one that its services name by where the package has it"""
import copy
import ipaddress
import pathlib
import sys

import yaml  # Debian package python3-yaml

INSTALLED = "/usr/share/hecaton/cells/"


def agents(compose):
    """Services by name, without those that a person starts."""
    return {name: service for name, service in compose["services"].items() if "profiles" not in service}


def complaints(compose, cell, cell_name):
    """What is wrong."""
    network = ipaddress.ip_network(compose["networks"]["cell"]["ipam"]["config"][0]["subnet"])
    started = agents(compose)
    for host in sorted(set(cell["hosts"]) ^ set(started)):
        yield f"{host}: {'no service' if host in cell['hosts'] else 'no host of the cell'}"
    for host in sorted(set(cell["hosts"]) & set(started)):
        service, wanted = started[host], f"agent {INSTALLED}{cell_name} --host {host}"
        address = service["networks"]["cell"]["ipv4_address"]
        if service["command"] != wanted:
            yield f"{host}: its command is not '{wanted}'"
        if address != cell["hosts"][host]:
            yield f"{host}: {address} is not the address that the cell gives it"
        if ipaddress.ip_address(address) not in network:
            yield f"{host}: {address} is not in {network}"
    for name, service in compose["services"].items():
        if name not in started and service["environment"]["HECATON_CELL"] != INSTALLED + cell_name:
            yield f"{name}: it is given another cell"


def with_mistakes(compose):
    """(what is wrong with it, a copy), of which each must be complained of."""
    first = next(iter(agents(compose)))
    for mistake, change in (
            ("a host without a service", lambda copied: copied["services"].pop(first)),
            ("another address", lambda copied: copied["services"][first]["networks"]["cell"].update(ipv4_address="10.0.0.1")),
            ("another host's command", lambda copied: copied["services"][first].update(command="agent elsewhere")),
            ("another cell", lambda copied: copied["services"]["operator"]["environment"].update(HECATON_CELL="elsewhere"))):
        copied = copy.deepcopy(compose)
        change(copied)
        yield mistake, copied


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    compose_file, cell_file = map(pathlib.Path, sys.argv[1:])
    compose, cell = yaml.safe_load(compose_file.read_text()), yaml.safe_load(cell_file.read_text())
    wrong = list(complaints(compose, cell, cell_file.name))
    wrong += [f"{mistake} is not complained of" for mistake, copied in with_mistakes(compose)
              if not list(complaints(copied, cell, cell_file.name))]
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
