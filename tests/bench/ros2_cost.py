#!/usr/bin/env python3
"""The cost of hecaton-ros2 for cells of N arms: processor time, memory, traffic to one reader, and latency.

usage: ros2_cost.py BIN [--arms 3,30] [--seconds 20]

BIN is the folder of Hecaton's programs and of cyclone_peer, which needs Cyclone DDS. hecaton-ros2 is the real one. One process
publishes the states of all arms, which move, every 2 ms. A program of another DDS vendor reads /joint_states, /tf,
/diagnostics and the four topics of markers; its payload counts. In a second row, marked +, it also reads the topics of each
arm, /ARM/joint_states and /ARM/status. The latency is that from the arrival of an arm's state to the arrival of the joint states with the same positions.
"""
import json
import subprocess

from cell_cost import Cost, for_each_size, resident_megabytes, running

DOMAIN, ROS_DOMAIN = 41, 40
MARKERS = "visualization_msgs::msg::MarkerArray"


def watched(seconds, single):
    """Topics for cyclone_peer, also those of the arms `single`: it reads until the first one has sent that long."""
    topics = [("/joint_states", "sensor_msgs::msg::JointState", int(50 * seconds)),
              ("/tf", "tf2_msgs::msg::TFMessage", 1), ("/diagnostics", "diagnostic_msgs::msg::DiagnosticArray", 0)]
    topics += [(f"/hecaton/{name}", MARKERS, 0) for name in ("obstacles", "goals", "plans", "binding_pairs")]
    for arm in single:
        topics += [(f"/{arm}/joint_states", "sensor_msgs::msg::JointState", 0),
                   (f"/{arm}/status", "diagnostic_msgs::msg::DiagnosticStatus", 0)]
    return [f"rt{name},{kind},reliable,{count}" for name, kind, count in topics]


def measure(programs, cell, arms, seconds, folder, log):
    cell.write_text(cell.read_text() + f"network: {{domain: {DOMAIN}}}\nros2: {{domain: {ROS_DOMAIN}, control: true}}\n")
    for mark, single in (" ", []), ("+", [f"arm{i}" for i in range(arms)]):
        measure_reader(programs, cell, f"{arms}{mark}", single, seconds, folder, log)


def measure_reader(programs, cell, row, single, seconds, folder, log):
    name = next(line.split()[1] for line in cell.read_text().splitlines() if line.startswith("name:"))
    samples = folder / "samples.jsonl"
    peer = programs / "cyclone_peer"
    watch = [peer, "watch", str(ROS_DOMAIN), "", samples]
    with running(log, programs / "supervision-crowd", cell), running(log, programs / "hecaton-ros2", cell) as bridge:
        subprocess.run([*watch, *watched(1, single)], check=True)
        with Cost(bridge.pid) as cost:
            subprocess.run([*watch, *watched(seconds, single)], check=True)
        with open(samples) as lines:
            payload = sum(len(json.loads(line)["cdr"]) // 2 for line in lines)
        latency = subprocess.run([peer, "latency", str(DOMAIN), name, "arm0", str(ROS_DOMAIN), "rt/joint_states", "1000"],
                                 check=True, capture_output=True, text=True)
        late = json.loads(latency.stdout)
        print(f"{row:>6} {100 * cost.share:8.1f} % {resident_megabytes(bridge.pid):6.0f} MB "
              f"{payload / cost.seconds / 1e3:8.0f} kB/s {late['p50_ms']:7.1f} {late['p99_ms']:6.1f} ms", flush=True)


def main():
    for_each_size(__doc__, "3,30", f"{'arms':>6} {'processor':>10} {'memory':>9} {'payload':>13} {'latency p50':>7}, p99", measure)


if __name__ == "__main__":
    main()
