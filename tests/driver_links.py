"""Checks what the arm driver is made of: neither a planner's search nor Bullet. A driver that starts fast, needs little
memory and can be certified has no code that it does not need.

usage: driver_links.py DRIVER CONTROL LIBRARY…
DRIVER must define no function of the static LIBRARYs, and need no shared library of Bullet. CONTROL, a planner, must
define some, so that this check can fail.
"""
import re
import subprocess
import sys


def functions(file):
    """Names of the functions that are defined there and could not come from a header."""
    out = subprocess.run(["nm", "--defined-only", file], capture_output=True, text=True, check=True).stdout
    return {name for kind, name in re.findall(r"^[0-9a-f]+ (\w) (\S+)$", out, re.M) if kind == "T"}


driver, control, *libraries = sys.argv[1:]
forbidden = set().union(*map(functions, libraries))
found = sorted(forbidden & functions(driver))
needed = subprocess.run(["readelf", "-d", driver], capture_output=True, text=True, check=True).stdout
bullet = re.findall(r"\[(lib(?:Bullet|LinearMath)[^\]]*)\]", needed)
for name in found[:20]:
    print(f"{driver} has {name}")
for name in bullet:
    print(f"{driver} needs {name}")
if not forbidden & functions(control):
    sys.exit(f"{control} has nothing of the libraries: this check could not fail")
sys.exit(1 if found or bullet else 0)
