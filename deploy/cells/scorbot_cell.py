"""Writes the cells of Mediavilla's motion problems: scorbot_2a, 2b, 2c and 3a.

usage: scorbot_cell.py PROBLEM [--spacing M] [--angle DEG] [--radius M] [--height M] [--pitch DEG] [--tables M]
       [--distance M] [--step RAD] [--opposite] [--urdf FILE] [-o FILE]

Bases stand at the corners of an equilateral triangle of --spacing, turned so that their x axes point at its centre.
Each arm's side tables are --angle to either side of that direction. There the tip of its gripper is --radius from the
axis of the base and --height above the floor, the hand --pitch above the horizon. The central table is in the middle.
Table tops are --tables high; 0: no tables. --opposite: the second arm begins at its other table. --distance is h and
--step Δ; --urdf says where the arm's file is.
"""
import argparse
import math

UPPER, FORE, HAND, SHOULDER = 0.28, 0.23, 0.25, 0.38
ARMS = {"2a": 2, "2b": 2, "2c": 2, "3a": 3}
# Between which of its poses each arm goes back and forth. Arms are named counter-clockwise from below. An arm's right
# table, clockwise of the direction to the centre, is the left table of its neighbour on that side.
AREAS = {"2a": [("left", "right"), ("left", "right")],
         "2b": [("left", "right"), ("right", "left")],
         "2c": [("left", "right"), ("right", "middle")],
         "3a": [("left", "right"), ("left", "right"), ("left", "right")]}
# What `hecaton-strategies search` found for the layout below (docs/explanation/strategies.md).
STRATEGIES = {"2a": [(-2, 1, 1), (2, 1, 1)],
              "2b": [(2, 1, 1), (-2, 1, 1)],
              "2c": [(0, 1, 1), (-2, 1, 1)],
              "3a": [(2, 1, 1), (2, 1, 1), (-2, 1, 1)]}
DOMAINS = {"2a": 52, "2b": 53, "2c": 54, "3a": 55}


def reach(radius, height, pitch):
    """Joints 2, 3, 4 [rad] that bring the tip there, elbow up."""
    x, z = radius - HAND * math.cos(pitch), height - HAND * math.sin(pitch) - SHOULDER
    d2 = x * x + z * z
    c = (d2 - UPPER ** 2 - FORE ** 2) / (2 * UPPER * FORE)
    if abs(c) > 1:
        raise SystemExit(f"the tip cannot be {radius} m out and {height} m up with the hand at {math.degrees(pitch)} deg")
    elbow = -math.acos(c)
    shoulder = math.atan2(z, x) - math.atan2(FORE * math.sin(elbow), UPPER + FORE * math.cos(elbow))
    return shoulder, elbow, pitch - shoulder - elbow


def cell(problem, a):
    side = reach(a.radius, a.height, math.radians(a.pitch))
    to_middle = a.spacing / math.sqrt(3)
    angle = math.radians(a.angle)
    pose = lambda q1, q: "[" + ", ".join(f"{x:.4f}" for x in (q1, *q, 0.0)) + "]"
    corners = [math.radians(120 * k - 150) for k in range(3)]
    names = ["robot1", "robot2", "robot3"]
    out = [f"# [Mediavilla02] problem {problem.upper()}: written by scorbot_cell.py, which explains the layout.",
           f"name: scorbot_{problem}", "", "network:", f"  domain: {DOMAINS[problem]}", "",
           "# A demonstration shares its machine with whatever else runs there: silence counts late.",
           "supervision:", "  heartbeat_deadline: 250ms", "  host_lease: 1s", "",
           "tasks:", "  areas:"]
    areas = list(AREAS[problem])
    if a.opposite:
        areas[1] = areas[1][::-1]
    if problem == "3a":
        out += ["    # The paper has it both ways: section 2.2 lets all three travel in the same direction, section 5 lets them",
                "    # start in opposite ones. Here all start in the same, from their left tables." if not a.opposite else
                "    # start in opposite ones. Here the second starts in the opposite one."]
    for k in range(ARMS[problem]):
        out.append(f"    {names[k]}: [{', '.join(areas[k])}]")
    out += ["  # ε_alea = 0.1 m over a reach of 0.85 m", "  spread: 0.1176", "  mean_wait: 10", "  time_limit: 60s", "",
            "defaults:", f"  urdf: {a.urdf}", "  limits:", "    acceleration: 6",
            "  method: strategy", "  strategy:",
            "    # h; and Δ = ε / reach = 0.05 m / 0.85 m", f"    distance: {a.distance:g}", f"    step: {a.step:g}", "  damper:",
            "    influence_distance: 0.10", "    security_distance: 0.015", "    self_influence_distance: 0.05",
            "    self_security_distance: 0.005", "    convergence_speed: 1.0",
            "  poses:", f"    home: {pose(-angle, side)}", f"    left: {pose(angle, side)}",
            f"    right: {pose(-angle, side)}"]
    if problem == "2c":
        middle = reach(min(a.radius, to_middle - 0.1), a.height, math.radians(a.pitch))
        out.append(f"    middle: {pose(0.0, middle)}")
    out += ["", "arms:"]
    for k in range(ARMS[problem]):
        x, y = to_middle * math.cos(corners[k]), to_middle * math.sin(corners[k])
        yaw = math.remainder(corners[k] + math.pi, 2 * math.pi)
        out += [f"  - name: {names[k]}",
                f"    base: {{xyz: [{x:.6f}, {y:.6f}, 0], rpy: [0, 0, {yaw:.6f}]}}",
                f"    start: {areas[k][0]}",
                f"    strategy: {{coefficients: {list(STRATEGIES[problem][k][:2])}, direction: {STRATEGIES[problem][k][2]}}}"]
    if a.tables > 0:
        out += ["", "obstacles:"]
        tables = {"centre": (0.0, 0.0)}
        for k in range(3):  # between two neighbours, outside the triangle
            out_at = math.radians(120 * k - 90)
            x0, y0 = to_middle * math.cos(corners[k]), to_middle * math.sin(corners[k])
            t = corners[k] + math.pi - angle
            reach_x, reach_y = x0 + a.radius * math.cos(t), y0 + a.radius * math.sin(t)
            r = reach_x * math.cos(out_at) + reach_y * math.sin(out_at)
            tables[f"table{k + 1}"] = (r * math.cos(out_at), r * math.sin(out_at), out_at)
        for name, place in tables.items():
            yaw = place[2] if len(place) > 2 else 0.0
            out += [f"  - name: {name}", "    shapes:",
                    f"      - {{type: box, size: [0.3, 0.5, {a.tables:g}]}}" if name != "centre" else
                    f"      - {{type: box, size: [0.3, 0.3, {a.tables:g}]}}",
                    f"    pose: {{xyz: [{place[0]:.4f}, {place[1]:.4f}, {a.tables / 2:g}], rpy: [0, 0, {yaw:.6f}]}}"]
    return "\n".join(out) + "\n"


parser = argparse.ArgumentParser(usage=__doc__)
parser.add_argument("problem", choices=sorted(ARMS))
parser.add_argument("--spacing", type=float, default=1.1)
parser.add_argument("--angle", type=float, default=65.0)
parser.add_argument("--radius", type=float, default=0.65)
parser.add_argument("--height", type=float, default=0.2)
parser.add_argument("--pitch", type=float, default=-20.0)
parser.add_argument("--tables", type=float, default=0.1)
parser.add_argument("--distance", type=float, default=0.05)
parser.add_argument("--step", type=float, default=0.0588)
parser.add_argument("--opposite", action="store_true")
parser.add_argument("--urdf", default="urdf/scorbot_er9.urdf")
parser.add_argument("-o", "--output", default="/dev/stdout")
arguments = parser.parse_args()
with open(arguments.output, "w", encoding="utf-8") as file:
    file.write(cell(arguments.problem, arguments))
