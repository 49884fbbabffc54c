#!/usr/bin/env python3
"""Writes a cell file of N PUMA 560 on a square grid, to simulate or run cells of any size. Tools go to points all around the
bases, also in the places of neighbours.

    python3 deploy/cells/grid_cell.py 30 -o grid30.yaml
    hecaton simulate grid30.yaml --tasks 30 --timing

With --clock 0.1 all arms move ten times more slowly, and all periods and limits of time are ten times longer, up to 10 s. So a machine with
a tenth of the processors that a live cell needs can run it.
"""
import argparse
import math
import pathlib
import sys

LONGEST = 10000  # that a period or limit may have [ms]; DDS deadlines are whole milliseconds
SPACING = 1.1  # between neighbours [m]: their reaches of about 1 m overlap, those of the next but one do not


def slower(ms):
    return f"""
timing: {{control_period: {ms(10)}, driver_period: {ms(2)}, world_period: {ms(10)}, command_timeout: {ms(50)}}}
supervision: {{heartbeat_period: {ms(10)}, heartbeat_deadline: {ms(250)}, host_lease: {ms(1000)}, failover_timeout: {ms(20)}}}
"""


def network(interface, clock):
    keys = [f"lease: {min(2 / clock, 20):.6g}s"] * (clock != 1.0) + [f"interface: {interface}"] * bool(interface)
    return f"network: {{{', '.join(keys)}}}\n" if keys else ""


def cell_file(count, urdf, clock=1.0, interface=None):
    columns = math.ceil(math.sqrt(count))

    def ms(time):
        return f"{min(math.ceil(time / clock), LONGEST)}ms"

    text = f"""# {count} PUMA 560 on a grid, {SPACING} m apart; written by grid_cell.py.
name: grid_{count}
{network(interface, clock)}
tasks:
  frame: base
  centre: [0, 0, 0.55]
  radius: 0.9
  half_height: 0
  posture: ready
  time_limit: {30 / clock:.6g}s
{slower(ms) if clock != 1.0 else ""}
defaults:
  urdf: {urdf}
  limits: {{velocity: {1.5 * clock:.6g}, acceleration: {10 * clock**2:.6g}}}
{f"  state_age_limit: {ms(250)}{chr(10)}" if clock != 1.0 else ""}  damper:
    influence_distance: 0.12
    security_distance: 0.03
    convergence_speed: {0.55 * clock:.6g}
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
    parser.add_argument("--clock", default=1.0, type=float, help="share of the usual speed, 0.03 to 1")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="instead of standard output")
    parser.add_argument("--interface", help="the only network interface, by name or IPv4 address")
    options = parser.parse_args()
    if not 1 <= options.arms <= 128:
        parser.error(f"N = {options.arms} must be within 1 and 128")
    if not 0.03 <= options.clock <= 1.0:
        parser.error(f"--clock {options.clock} must be within 0.03 and 1")
    text = cell_file(options.arms, options.urdf.resolve(), options.clock, options.interface)
    if options.output:
        options.output.write_text(text)
    else:
        sys.stdout.write(text)


main()
