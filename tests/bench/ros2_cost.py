#!/usr/bin/env python3
"""The cost of hecaton-ros2 for cells of N arms: processor time, memory, traffic to one reader of all topics, and latency.

usage: ros2_cost.py BIN [--arms 3,30] [--seconds 20]

BIN is the folder of Hecaton's programs and of cyclone_peer, which needs Cyclone DDS. hecaton-ros2 is the real one. One process
publishes the states of all arms, which move, every 2 ms. A program of another DDS vendor reads all topics; its payload counts.
The latency is that from the arrival of an arm's state to the arrival of the joint states with the same positions.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile
import time

from cost_cells import grid_cell, running
from supervision_cost import processor_seconds, resident_megabytes

DOMAIN, ROS_DOMAIN = 41, 40
MARKERS = "visualization_msgs::msg::MarkerArray"


def watched(seconds):
    """Topics for cyclone_peer: it reads until the first one has sent that long."""
    topics = [("/joint_states", "sensor_msgs::msg::JointState", int(50 * seconds)),
              ("/tf", "tf2_msgs::msg::TFMessage", 1), ("/diagnostics", "diagnostic_msgs::msg::DiagnosticArray", 0)]
    topics += [(f"/hecaton/{name}", MARKERS, 0) for name in ("obstacles", "goals", "plans", "binding_pairs")]
    return [f"rt{name},{kind},reliable,{count}" for name, kind, count in topics]


def measure(programs, arms, seconds, folder):
    cell = grid_cell(folder, arms, f"network: {{domain: {DOMAIN}}}\nros2: {{domain: {ROS_DOMAIN}, control: true}}\n")
    name = next(line.split()[1] for line in cell.read_text().splitlines() if line.startswith("name:"))
    samples = folder / "samples.jsonl"
    with open(folder / f"{arms}.log", "w") as log, running(log, [programs / "supervision-crowd", cell],
                                                           [programs / "hecaton-ros2", cell]) as (_, bridge):
        peer = [programs / "cyclone_peer", "watch", str(ROS_DOMAIN), "", samples]
        subprocess.run([*peer, *watched(1)], check=True)
        spent, at = processor_seconds(bridge.pid), time.monotonic()
        subprocess.run([*peer, *watched(seconds)], check=True)
        passed = time.monotonic() - at
        spent = processor_seconds(bridge.pid) - spent
        with open(samples) as lines:
            payload = sum(len(json.loads(line)["cdr"]) // 2 for line in lines)
        latency = subprocess.run([programs / "cyclone_peer", "latency", str(DOMAIN), name, "arm0", str(ROS_DOMAIN),
                                  "rt/joint_states", "1000"], check=True, capture_output=True, text=True)
        late = json.loads(latency.stdout)
        print(f"{arms:5} {100 * spent / passed:8.1f} % {resident_megabytes(bridge.pid):6.0f} MB "
              f"{payload / passed / 1e3:8.0f} kB/s {late['p50_ms']:7.1f} {late['p99_ms']:6.1f} ms", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default="3,30")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    print(f"{'arms':>5} {'processor':>10} {'memory':>9} {'payload':>13} {'latency p50':>7}, p99")
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as folder:
        for arms in options.arms.split(","):
            measure(options.programs.resolve(), int(arms), options.seconds, pathlib.Path(folder))


if __name__ == "__main__":
    main()
