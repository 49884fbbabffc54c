"""The copy of a cell file that faults are injected into.

usage: cell_copy.py --self-test

In a copy, paths are absolute, obstacles do not move (an arm without driver cannot give way), and holds of faults end by themselves,
because there is no operator. The limits of silence are longer, because all hosts share this machine."""
import ipaddress
import os
import sys
import unittest

import cell_document
from duration import parse_duration
from injections import longest_stop
from limits import Limits

NETWORK = ipaddress.ip_network("10.43.0.0/24")
FIRST = 11  # of the hosts' addresses in it
# Limits for hosts that share a machine, as in deploy/cells/three_hosts.yaml.
SHARED_LIMITS = {"heartbeat_deadline": "250ms", "host_lease": "1s"}
SHARED_FAILOVER_TIMEOUT = "150ms"  # avoids failovers when such a machine stalls
WATCHDOG = 10.0  # [s] by default (docs/reference/cell-file.md)
MOST_HOSTS = 64  # of a cell (docs/reference/cell-file.md), like the next one
LONGEST_NAME = 64
PATHS = ("urdf", "srdf")


def copy_of(document, folder, timeout_scale=1):
    """Changes the document of a cell file in `folder` in place, and returns it."""
    make_paths_absolute(document, folder)
    for obstacle in document.get("obstacles") or []:
        stand_still(obstacle)
    supervision = section(document, "supervision")
    supervision.pop("recovery", None)  # by default, contacts wait for an operator
    if not SHARED_LIMITS.keys() & supervision.keys():
        supervision.update(SHARED_LIMITS)
    supervision.setdefault("failover_timeout", SHARED_FAILOVER_TIMEOUT)
    scale_timeouts(document, timeout_scale)
    # An agent must not kill a process that is stopped for a while.
    supervision["watchdog"] = f"{max(WATCHDOG, 2 * longest_stop(Limits.of(document).silence)):g}s"
    section(document, "network").pop("interface", None)  # the hosts' interface has another name here
    return document


def scale_timeouts(document, factor):
    """Multiplies the limits of silence, for a machine that stalls for as long as they allow."""
    supervision = section(document, "supervision")
    if factor == 1:
        return
    for key in (*SHARED_LIMITS, "failover_timeout"):
        if key in supervision:
            supervision[key] = f"{factor * parse_duration(supervision[key]):g}s"


def section(document, key):
    """A map of the cell file; created if it does not exist."""
    if not document.get(key):
        document[key] = {}
    return document[key]


def make_paths_absolute(document, folder):
    beside(folder, document.get("security"), ("keystore",))
    for arm in [document.get("defaults") or {}, *document["arms"]]:
        for holder, keys in ((arm, PATHS), (arm.get("packages"), arm.get("packages")), (arm.get("strategy"), ("file",))):
            beside(folder, holder, keys)
    for obstacle in document.get("obstacles") or []:
        for shape in obstacle["shapes"]:
            beside(folder, shape, ("file",))


def beside(folder, holder, keys):
    for key in keys or ():
        if holder and key in holder:
            holder[key] = cell_document.Quoted(os.path.join(folder, holder[key]))


def stand_still(obstacle):
    """Keeps the obstacle at its initial pose."""
    motion = obstacle.pop("motion", None) or {}
    if "poses" in motion:
        obstacle["pose"] = motion["poses"][0]


def why_spread(document):
    """Why the hosts of the file cannot be used; None: they can."""
    hosts = document.get("hosts") or {}
    if len(hosts) < 2:
        return "it has a single host"
    try:
        addresses = {ipaddress.IPv4Address(address) for address in hosts.values()}
    except ValueError:
        return "its hosts have names for addresses"
    if len(addresses) < len(hosts):
        return "its hosts share addresses"
    if any(address.is_loopback for address in addresses):
        return "its hosts are all this machine (127.0.0.0/8)"
    network = ipaddress.ip_network((min(addresses), 24), strict=False)
    if not addresses <= set(list(network.hosts())[1:]):
        return "its hosts are not in one network of 256 addresses, of which the first is the operator's"
    return None


def spread(document):
    """Gives each arm, the world and the supervisor a host, and removes standbys. Arms share hosts if a cell cannot have so many."""
    remove_standbys(document)
    hosts = [f"{arm['name'][:LONGEST_NAME - len('-pc')]}-pc" for arm in document["arms"]][:MOST_HOSTS - 2]
    for i, arm in enumerate(document["arms"]):
        arm["host"] = hosts[i % len(hosts)]
    section(document, "world")["host"] = "world-pc"
    section(document, "supervision")["host"] = "supervisor-pc"
    names = dict.fromkeys([*(arm["host"] for arm in document["arms"]), "world-pc", "supervisor-pc"])
    document["hosts"] = {name: str(NETWORK[FIRST + i]) for i, name in enumerate(names)}
    network = section(document, "network")
    for key in ("transport", "peers"):
        network.pop(key, None)
    network["discovery"] = "unicast"


def has_standbys(document):
    return any("standby_host" in service for service in watched(document))


def remove_standbys(document):
    for service in watched(document):
        service.pop("standby_host", None)


def watched(document):
    """Services that may have a standby."""
    return [*document["arms"], section(document, "supervision")]


def put_standbys_in_a_ring(document, others=None):
    """Each arm's on the next arm's host, the supervisor's on the world's. `others`: {host: another host of its standbys}."""
    standbys = {**ring_of(document), **(others or {})}
    for service in watched(document):
        service["standby_host"] = standbys[service["host"]]


def ring_of(document):
    """{host of an arm or of the supervisor: host of its standbys}."""
    ring = list(dict.fromkeys(arm["host"] for arm in document["arms"]))
    standbys = dict(zip(ring, ring[1:] + ring[:1]))
    standbys.setdefault(document["supervision"]["host"], document["world"]["host"])
    # A host that would be its own neighbour gets another one.
    return {host: standby if standby != host else next(other for other in document["hosts"] if other != host)
            for host, standby in standbys.items()}


def services(document):
    """Names of all services that agents start."""
    names = ["world", "supervisor"] + [f"{kind}/{arm['name']}" for arm in document["arms"] for kind in ("driver", "planner")]
    names += [f"planner/{arm['name']}@{arm['standby_host']}" for arm in document["arms"] if "standby_host" in arm]
    standby = document["supervision"].get("standby_host")
    return names + ([f"supervisor@{standby}"] if standby else [])


SINGLE = """
name: "012"
defaults:
  urdf: urdf/puma.urdf
  packages: {robots: ../robots}
  poses: {home: [0, 1e-1, on]}
arms:
  - {name: a, strategy: {file: found.yaml}}
  - {name: b, urdf: /robots/b.urdf}
obstacles:
  - name: cart
    shapes: [{type: mesh, file: cart.stl}]
    motion: {type: waypoints, poses: [{xyz: [1, 0, 0]}, {xyz: [2, 0, 0]}], speed: 1}
  - name: ball
    shapes: [{type: sphere, radius: 010}]
    pose: {xyz: [3, 0, 0]}
    motion: {type: circle, centre: [0, 0, 0], angular_speed: 1}
network: {transport: shm, interface: lo}
supervision: {recovery: {node_silent: resume}, watchdog: 1s}
security: {keystore: keys}
"""

SEVERAL = """
name: several
hosts: {left-pc: 10.0.0.11, right-pc: 10.0.0.12, cell-pc: 10.0.0.13}
world: {host: cell-pc}
supervision: {host: cell-pc, heartbeat_deadline: 40ms}
arms:
  - {name: left, host: left-pc}
  - {name: right, host: right-pc}
"""


def document_of(text):
    return copy_of(cell_document.read(text), "/cells")


class CopyTest(unittest.TestCase):
    def test_paths_are_absolute(self):
        document = document_of(SINGLE)
        self.assertEqual(document["defaults"]["urdf"], "/cells/urdf/puma.urdf")
        self.assertEqual(document["defaults"]["packages"], {"robots": "/cells/../robots"})
        self.assertEqual(document["arms"][0]["strategy"]["file"], "/cells/found.yaml")
        self.assertEqual(document["arms"][1]["urdf"], "/robots/b.urdf")
        self.assertEqual(document["obstacles"][0]["shapes"][0]["file"], "/cells/cart.stl")
        self.assertEqual(document["security"]["keystore"], "/cells/keys")

    def test_obstacles_rest_at_their_initial_pose(self):
        cart, ball = document_of(SINGLE)["obstacles"]
        self.assertEqual((cart["pose"]["xyz"], ball["pose"]["xyz"]), (["1", "0", "0"], ["3", "0", "0"]))
        self.assertFalse("motion" in cart or "motion" in ball)

    def test_scalars_are_written_unchanged(self):
        text = cell_document.write(document_of(SINGLE))
        for line in ('name: "012"', "- 1e-1", "- on", "radius: 010"):
            self.assertRegex(text, rf"(?m)^ *(- )?{line}$")
        self.assertEqual(cell_document.read(text), document_of(SINGLE))

    def test_default_limits_are_for_a_shared_machine(self):
        self.assertEqual(document_of(SINGLE)["supervision"], {**SHARED_LIMITS, "failover_timeout": "150ms", "watchdog": "10s"})
        stated = document_of(SEVERAL)["supervision"]
        self.assertEqual((stated["heartbeat_deadline"], stated.get("host_lease")), ("40ms", None))


    def test_timeout_scale_multiplies_limits(self):
        document = copy_of(cell_document.read(SEVERAL), "/cells", timeout_scale=4)
        self.assertEqual({key: document["supervision"][key] for key in ("heartbeat_deadline", "failover_timeout", "watchdog")},
                         {"heartbeat_deadline": "0.16s", "failover_timeout": "0.6s", "watchdog": "10s"})
        self.assertEqual(copy_of(cell_document.read(SINGLE), "/cells", timeout_scale=2)["supervision"]["host_lease"], "2s")

    def test_watchdog_is_longer_than_all_stops(self):
        for deadline, watchdog in ("40ms", "10s"), ("4s", "18s"), ("60s", "242s"):
            supervision = document_of(SEVERAL.replace("40ms", f"{deadline}, host_lease: 60.5s"))["supervision"]
            self.assertEqual(supervision["watchdog"], watchdog)


class SpreadTest(unittest.TestCase):
    def spread(self):
        document = document_of(SINGLE)
        spread(document)
        return document

    def why(self, **hosts):
        return why_spread({"hosts": hosts})

    def test_hosts_need_own_addresses_in_one_network(self):
        self.assertIsNone(why_spread(document_of(SEVERAL)))
        self.assertIn("single host", why_spread(document_of(SINGLE)))
        self.assertIn("share", self.why(a="127.0.0.1", b="127.0.0.1"))
        self.assertIn("this machine", self.why(a="127.0.0.2", b="127.0.0.3"))
        self.assertIn("this machine", self.why(a="10.0.0.2", b="127.0.0.1"))
        self.assertIn("names", self.why(a="10.0.0.2", b="b.example"))
        self.assertIn("one network", self.why(a="10.0.0.2", b="10.0.1.2"))
        self.assertIn("operator's", self.why(a="10.0.0.1", b="10.0.0.2"))

    def test_each_arm_world_and_supervisor_have_a_host(self):
        document = self.spread()
        self.assertEqual(document["hosts"], {"a-pc": "10.43.0.11", "b-pc": "10.43.0.12", "world-pc": "10.43.0.13",
                                             "supervisor-pc": "10.43.0.14"})
        self.assertEqual([service["host"] for service in watched(document)], ["a-pc", "b-pc", "supervisor-pc"])
        self.assertEqual(document["network"], {"discovery": "unicast"})
        self.assertIsNone(why_spread(document))

    def test_many_arms_share_the_largest_number_of_hosts(self):
        document = document_of(SINGLE)
        document["arms"] = [{"name": f"{'a' * 60}{i}"} for i in range(100, 170)]
        spread(document)
        self.assertLessEqual(len(document["hosts"]), MOST_HOSTS)
        document["arms"] = [{"name": f"arm{i}"} for i in range(70)]
        spread(document)
        self.assertEqual(len(document["hosts"]), MOST_HOSTS)
        self.assertEqual((document["arms"][61]["host"], document["arms"][62]["host"]), ("arm61-pc", "arm0-pc"))
        put_standbys_in_a_ring(document)
        self.assertTrue(all(service["host"] != service["standby_host"] for service in watched(document)))
        self.assertIsNone(why_spread(document))

    def test_standbys_are_in_a_ring(self):
        document = self.spread()
        self.assertFalse(has_standbys(document))
        put_standbys_in_a_ring(document)
        self.assertEqual([service["standby_host"] for service in watched(document)], ["b-pc", "a-pc", "world-pc"])
        self.assertEqual(services(document), ["world", "supervisor", "driver/a", "planner/a", "driver/b", "planner/b",
                                              "planner/a@b-pc", "planner/b@a-pc", "supervisor@world-pc"])
        remove_standbys(document)
        self.assertFalse(has_standbys(document))

    def test_no_host_is_its_own_standby(self):
        document = document_of(SEVERAL)
        put_standbys_in_a_ring(document)
        self.assertEqual([service["standby_host"] for service in watched(document)], ["right-pc", "left-pc", "left-pc"])
        document["arms"].pop()
        put_standbys_in_a_ring(document)
        self.assertEqual([service["standby_host"] for service in watched(document)], ["right-pc", "left-pc"])


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
