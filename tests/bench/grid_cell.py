"""Prints a cell file of N PUMA 560 on a square grid that swing past each other: hecaton simulate on growing cells.

usage: grid_cell.py N [URDF] > cell.yaml
"""
import math
import pathlib
import sys

SPACING = 1.3  # between neighbours [m]: each reaches into its neighbours' place, and no farther


def main():
    count = int(sys.argv[1])
    urdf = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "deploy/cells/urdf/puma560.urdf").resolve()
    columns = math.ceil(math.sqrt(count))
    print(f"""name: grid_{count}
timing: {{control_period: 10ms}}
tasks: {{route: [left, right], time_limit: 20s}}
defaults:
  urdf: {urdf}
  limits: {{velocity: 1.5, acceleration: 10}}
  damper: {{influence_distance: 0.12, security_distance: 0.03, convergence_speed: 0.55}}
  poses:
    home: [0, -1.9, 2.6, 0, 0.6, 0]
    left: [1.2, -1.25, 3.5, 0, 0.89, 0]
    right: [-1.2, -1.25, 3.5, 0, 0.89, 0]
arms:""")
    for i in range(count):
        x, y = SPACING * (i % columns), SPACING * (i // columns)
        print(f"  - {{name: arm{i}, base: {{xyz: [{x:.6g}, {y:.6g}, 0]}}}}")


main()
