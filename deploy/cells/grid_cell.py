#!/usr/bin/env python3
"""Writes a cell file of N PUMA 560 on a square grid, whose tools go to points all around their bases, at one height and
as far as into their neighbours' places: for `hecaton simulate` on cells of any size.

    python3 deploy/cells/grid_cell.py 30 -o grid30.yaml
    hecaton simulate grid30.yaml --tasks 30 --timing
"""
import argparse
import math
import pathlib
import sys

SPACING = 1.1  # between neighbours [m]: their reaches of about 1 m overlap, those of the next but one do not


def cell_file(count, urdf):
    columns = math.ceil(math.sqrt(count))
    text = f"""# {count} PUMA 560 on a grid, {SPACING} m apart; written by grid_cell.py.
name: grid_{count}

tasks:
  frame: base
  centre: [0, 0, 0.55]
  radius: 0.9
  half_height: 0
  posture: ready
  time_limit: 30s

defaults:
  urdf: {urdf}
  limits: {{velocity: 1.5, acceleration: 10}}
  damper:
    influence_distance: 0.12
    security_distance: 0.03
    convergence_speed: 0.55
    self_influence_distance: 0.11
    self_security_distance: 0.01
  poses:
    home: [0, -1.9, 2.6, 0, 0.6, 0]
    ready: [0, -1.25, 3.5, 0, 0.89, 0]
  start: home

arms:
"""
    for i in range(count):
        x, y = SPACING * (i % columns), SPACING * (i // columns)
        text += f"  - {{name: arm{i}, base: {{xyz: [{x:.6g}, {y:.6g}, 0]}}}}\n"
    return text


def main():
    here = pathlib.Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("arms", metavar="N", type=int, help="how many arms, 1 to 128")
    parser.add_argument("--urdf", default=here / "urdf" / "puma560.urdf", type=pathlib.Path, help="of every arm")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="instead of standard output")
    options = parser.parse_args()
    if not 1 <= options.arms <= 128:
        parser.error(f"N = {options.arms} must be within 1 and 128")
    text = cell_file(options.arms, options.urdf.resolve())
    if options.output:
        options.output.write_text(text)
    else:
        sys.stdout.write(text)


main()
