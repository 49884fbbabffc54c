"""Two arms hand over a part: one brings it to the shared zone, the other one fetches it there.

usage: two_arms_hand_over.py CELL        a running cell with arms north and west, such as three_puma
"""
import asyncio
import sys

import hecaton

PART = "part"


async def hand_over(cell: hecaton.Cell) -> None:
    north, west = cell.arm("north"), cell.arm("west")
    await asyncio.gather(north.go_to("home"), west.go_to("home"))

    # The part appears in front of the tool of north, which takes it.
    model = hecaton.load(sys.argv[1])
    in_gripper = hecaton.Pose.xyz(0, 0, 0.05).matrix
    tool = model.arm("north").forward(north.state().q)
    place = hecaton.Pose.from_matrix(tool.matrix @ in_gripper)
    # An edit waits for its answer: in a thread of its own it does not keep the other coroutines waiting.
    await asyncio.to_thread(cell.world.add, PART, hecaton.Box(0.04, 0.04, 0.04), place)
    await asyncio.to_thread(cell.world.attach, "north", PART)

    # North carries it to the shared zone, puts it down and leaves.
    await north.go_to("ready", time_limit=60)
    await asyncio.to_thread(cell.world.detach, "north", PART)
    await north.go_to("home", time_limit=60)

    # West reaches for the place of the part: 8 cm above it, with the tool downwards. Its yaw is free.
    obstacles = await asyncio.to_thread(cell.world.obstacles)
    part = next(state for state in obstacles if state.name == PART)
    x, y, z = part.pose.position
    print(f"the part is at {x:.3f} {y:.3f} {z:.3f}")
    above = hecaton.Pose.xyz_rpy(x, y, z + 0.08, 3.14159265, 0, 0)
    await west.go_to(above, free_rotation="yaw", position_tolerance=0.005, orientation_tolerance=0.1)
    await asyncio.to_thread(cell.world.attach, "west", PART)
    await west.go_to("home", time_limit=60)
    print(f"west carries {', '.join(west.state().carried)}")
    await asyncio.to_thread(cell.world.detach, "west", PART)
    await asyncio.to_thread(cell.world.remove, PART)


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: two_arms_hand_over.py CELL", file=sys.stderr)
        return 2
    try:
        with hecaton.connect(sys.argv[1], timeout=20) as cell:
            asyncio.run(hand_over(cell))
    except hecaton.Error as error:
        print(f"{error.kind}: {error}", file=sys.stderr)
        return 1
    return 0


sys.exit(main())
