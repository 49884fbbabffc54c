"""Two arms hand over a part: one brings it to the shared zone, the other one fetches it there."""
# %% Options. A notebook has no command line: there the default counts.
import argparse
import sys

import hecaton

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("cell", nargs="?", default="deploy/cells/three_puma.yaml",
                    help="cell file with arms north and west (%(default)s)")
options = parser.parse_args([] if "ipykernel" in sys.modules else None)

# %% Both arms go home at the same time.
model = hecaton.load(options.cell)
cell = hecaton.connect(options.cell, timeout=20)
north, west, world = cell.arm("north"), cell.arm("west"), cell.world
cell.wait_all([north.go_to("home"), west.go_to("home")])

# %% The part appears in front of the tool of north, which takes it.
tool = model.arm("north").forward(north.state().q)
in_gripper = hecaton.Pose.xyz(0, 0, 0.05)
world.add("part", hecaton.Box(0.04, 0.04, 0.04), hecaton.Pose.from_matrix(tool.matrix @ in_gripper.matrix))
world.attach("north", "part")

# %% North carries it to the shared zone, puts it down and leaves.
north.go_to("ready", time_limit=60).wait()
world.detach("north", "part")
north.go_to("home", time_limit=60).wait()

# %% West reaches for the part: 8 cm above it, with the tool downwards. Its yaw is free.
part = next(state for state in world.obstacles() if state.name == "part")
x, y, z = part.pose.position
print(f"the part is at {x:.3f} {y:.3f} {z:.3f}")
above = hecaton.Pose.xyz_rpy(x, y, z + 0.08, 3.14159265, 0, 0)
west.go_to(above, free_rotation="yaw", position_tolerance=0.005, orientation_tolerance=0.1).wait()

# %% West takes it home.
world.attach("west", "part")
west.go_to("home", time_limit=60).wait()
print(f"west carries {', '.join(west.state().carried)}")
world.detach("west", "part")
world.remove("part")
cell.close()
