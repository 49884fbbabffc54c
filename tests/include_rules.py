"""Checks which folder includes which: the rules of ARCHITECTURE.md, from the #include lines.

usage: include_rules.py ROOT
"""
import pathlib
import re
import sys

# folder → the project's folders it may include (its own is always allowed). Longest match wins.
ALLOWED = {
    "world/model": [],
    "world/sim": ["world/model"],
    "planner/simd": [],
    "planner/model": ["planner/simd", "world/model"],
    "planner/collision": ["planner/model", "planner/simd", "world/model"],
    "planner/trajectory": ["planner/model"],
    "planner/qp": ["planner/model"],
    "planner/local": ["planner/collision", "planner/model", "planner/qp", "planner/trajectory", "world/model"],
    # the interface of motion methods, and the registry: the one place that names them
    "planner/methods": ["planner/methods/boundary_following", "planner/methods/potential_field", "planner/methods/sensed_cspace",
                        "planner/methods/strategy", "planner/local", "planner/collision", "planner/model", "world/model"],
    "planner/methods/boundary_following": ["planner/methods", "planner/local", "planner/qp", "planner/model"],
    "planner/methods/potential_field": ["planner/methods", "planner/local", "planner/collision", "planner/model", "world/model"],
    "planner/methods/sensed_cspace": ["planner/methods", "planner/local", "planner/trajectory", "planner/model", "planner/simd",
                                      "world/model"],
    "planner/methods/strategy": ["planner/methods", "planner/methods/boundary_following", "planner/local", "planner/collision",
                                 "planner/model", "planner/simd", "world/model"],
    # tick, local planner, arm_controller, goal_check, cell: what one arm's planner is
    "planner": ["planner/simd", "planner/methods", "planner/local", "planner/qp", "planner/collision", "planner/model",
                "planner/trajectory", "world/model"],
    "planner/strategy_search": ["planner", "planner/methods", "planner/methods/strategy", "planner/local", "planner/collision",
                                "planner/model", "planner/simd", "world/model"],
    "planner/rollout": ["planner", "planner/methods", "planner/local", "planner/collision", "planner/model", "planner/trajectory",
                        "world/model"],
    # the interface of global planners, what they share, and the registry: the one place that names them
    "planner/global": ["planner/global/rrt_connect", "planner/global/rrt", "planner/global/est", "planner/global/prm",
                       "planner/local", "planner/collision", "planner/trajectory", "planner/model", "planner/simd", "world/model"],
    "planner/global/rrt_connect": ["planner/global"],
    "planner/global/rrt": ["planner/global"],
    "planner/global/est": ["planner/global"],
    "planner/global/prm": ["planner/global"],
    "planner/route": ["planner", "planner/methods", "planner/global", "planner/local", "planner/collision", "planner/model", "world/model"],
    "planner/arm_planner": ["planner", "planner/methods", "planner/rollout", "planner/route", "planner/local", "planner/collision", "planner/model", "world/model"],
    "planner/simulation": ["planner", "planner/arm_planner", "planner/methods", "planner/methods/strategy", "planner/rollout", "planner/route", "planner/local", "planner/collision", "planner/model",
                           "planner/trajectory", "world/model", "world/sim"],
    "services/bus": ["idl"],
    "services/security": ["services/bus"],
    "services/messages": ["idl", "planner/local", "planner/model", "planner/trajectory", "world/model"],
    "services/config": ["planner", "planner/methods", "planner/methods/strategy", "planner/local", "planner/collision", "planner/model", "planner/trajectory",
                        "world/model"],
    "services/arm_driver/devices": ["services/arm_driver/devices/program", "services/arm_driver/devices/ros2_control", "planner/model", "planner/trajectory", "planner/simulation",
                                    "services/runtime"],
    # the devices that use DDS
    "services/arm_driver/devices/program": ["services/arm_driver/devices", "services/bus", "idl"],
    "services/arm_driver/devices/ros2_control": ["services/arm_driver/devices", "services/bus", "services/ros2_messages",
                                                 "services/runtime", "planner/model", "planner/trajectory"],
    "services/runtime": ["idl", "services/bus", "services/config", "services/security", "planner/model"],
    "services/command_line": ["services/config", "services/runtime", "world/model"],
    "services/strategies": ["services/command_line", "services/config", "planner", "planner/model", "planner/strategy_search"],
}
# What every service may include, and what each needs beside it.
SERVICE = ["idl", "services/bus", "services/config", "services/runtime", "services/security"]
BESIDE = {
    "agent": ["planner/model", "services/arm_driver", "services/arm_driver/devices"],
    "supervisor": ["services/arm_driver", "services/messages", "planner/trajectory"],
    "arm_driver": ["services/messages", "services/arm_driver/devices", "planner/simulation", "planner/collision", "planner/model", "planner/trajectory",
                   "world/model"],
    "view": ["services/client", "services/messages", "services/ros2_messages", "services/view/foxglove", "planner", "planner/collision", "planner/local", "planner/model", "world/model"],
    "view/foxglove": ["services/messages", "services/ros2_messages", "services/view", "planner", "planner/model", "world/model"],
    "ros2_messages": ["services/messages", "planner", "planner/model", "world/model"],
    "ros2": ["services/client", "services/ros2_messages", "services/messages", "planner", "planner/local", "planner/model", "planner/trajectory", "world/model"],
    "recorder": ["services/view"],  # its ROS 2 topics show the state of a cell
    "tick_log": ["services/messages", "planner", "planner/arm_planner", "planner/local", "planner/model", "world/model"],
    "replay": ["services/recorder", "services/view", "services/messages", "services/ros2_messages", "services/tick_log", "planner", "planner/arm_planner"],
    # what the nodes of a live cell would publish: made by their own code
    "simulation_recording": ["services/messages", "services/planner", "services/recorder", "services/tick_log", "services/world",
                             "planner", "planner/simulation", "world/model"],
    "picture": ["services/agent", "services/replay", "services/view", "services/messages", "planner", "planner/model", "world/model"],
    "world": ["services/messages", "planner", "planner/model", "planner/simulation", "world/model", "world/sim"],
    "planner": ["services/messages", "services/tick_log", "planner", "planner/arm_planner", "planner/collision", "planner/local", "planner/methods",
                "planner/model", "planner/trajectory", "planner/rollout", "planner/route", "world/model"],
    "python": ["services/client", "planner", "planner/global", "planner/model", "planner/simulation", "planner/trajectory", "world/model"],
    "cli": ["services/client", "services/recorder", "services/replay", "services/picture", "services/simulation_recording", "services/tick_log", "services/arm_driver", "services/arm_driver/devices", "services/messages", "services/command_line", "planner", "planner/collision", "planner/methods", "planner/methods/sensed_cspace", "planner/global", "planner/local", "planner/model",
            "planner/methods/potential_field", "planner/simulation", "planner/trajectory", "world/model", "world/sim"],
}
for service, rooms in BESIDE.items():
    ALLOWED[f"services/{service}"] = SERVICE + rooms
ALLOWED["services/client"] = [*SERVICE, "services/messages", "planner/model", "world/model"]

# These may include every folder of the project.
FREE = ["tests", "examples"]

# third-party header → the only places that may include it
ONLY_IN = {
    r"^(urdf_parser|urdf_model|urdf_world|urdf_exception|console_bridge)/": ["planner/model/urdf_"],
    r"^fcl/": ["tests/"],
    r"^(bt[A-Z]\w*\.h|Bullet\w*/|LinearMath/)": ["world/sim/", "tests/"],
    r"^assimp/": ["planner/model/mesh_"],
    r"^libqhull": ["planner/model/convex_hull"],
    r"^nlopt": ["planner/strategy_search/search"],
    r"^mpi\.h$": ["services/strategies/search_execution"],
    r"^boost/": ["planner/strategy_search/evaluate", "services/view/web_", "tests/unit/services/view/"],
    r"^(zlib|zstd)\.h$": ["services/recorder/mcap_", "tests/unit/services/recorder/"],
    r"^yaml-cpp/": ["services/config/"],
    r"^(fastdds|fastrtps)/": ["services/bus/", "tests/unit/services/bus/", "tests/cell/bus_"],
    r"^dds/": ["tests/cell/interop/", "tests/robots/"],
    r"PubSubTypes\.h": ["services/bus/", "tests/unit/services/bus/", "tests/cell/ros2/", "tests/robots/"],
    r"^spdlog/": ["services/", "tests/unit/services/"],
    r"^CLI/": ["services/", "tests/unit/services/", "tests/bench/"],
    r"^openssl/": ["services/security/", "tests/cell/security/"],
    r"^nlohmann/": ["services/", "tests/"],
    r"^(pybind11/|Python\.h)": ["services/python/"],
}

# Pure parts: standard library, the generated values of idl/ and themselves only.
PURE = ["services/runtime/cause", "services/runtime/orders", "services/runtime/stall_compensated_clock",
        "services/supervisor/detection/", "services/supervisor/fault_list", "services/supervisor/cell_mode", "services/supervisor/clipped_text",
        "services/supervisor/failover/leadership", "services/supervisor/failover/planner_failover",
        "services/supervisor/replication/unreplicated",
        "services/runtime/arm_lease", "services/runtime/latest_faults", "services/runtime/node_name", "services/runtime/progress_watchdog",
        "services/runtime/standstill", "services/security/expiry"]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def folder_of(path, folders):
    matches = [folder for folder in folders if path == folder or path.startswith(folder + "/")]
    return max(matches, key=len) if matches else None


def check(root):
    problems = []
    folders = [*ALLOWED, "idl", *FREE]
    for file in sorted([*root.rglob("*.hpp"), *root.rglob("*.cpp")]):
        path = file.relative_to(root).as_posix()
        if path.split("/")[0] not in ("world", "planner", "services", *FREE):
            continue
        own = folder_of(path, folders)
        if own is None:
            problems.append(f"{path}: this folder has no include rule; add one to tests/include_rules.py")
            continue
        for kind, included in INCLUDE.findall(file.read_text(encoding="utf-8")):
            target = folder_of(included, folders)
            if own not in FREE and target and target != own and target not in ALLOWED[own]:
                problems.append(f"{path}: may not include {included} ({own} may include: "
                                f"{', '.join(ALLOWED[own]) or 'nothing of ours'})")
            for pattern, places in ONLY_IN.items():
                if re.search(pattern, included) and not any(path.startswith(place) for place in places):
                    problems.append(f"{path}: may not include {included} (only {', '.join(places)} may)")
            if any(path.startswith(pure if pure.endswith("/") else pure + ".") for pure in PURE):
                own_part = any(included.startswith(pure) for pure in PURE)
                values = included.startswith("idl/") and not included.endswith("PubSubTypes.h")
                standard = kind == "<" and "/" not in included and not included.endswith(".h")
                if not (own_part or standard or values):
                    problems.append(f"{path}: is pure and may include the standard library and idl values only, not {included}")
    return problems


found = check(pathlib.Path(sys.argv[1]))
print("\n".join(found) or "include rules hold")
sys.exit(1 if found else 0)
