#!/usr/bin/env python3
"""Unpacks the Debian packages and uses them like installed ones: a cell of three arms, and a Python program that sends it goals.
That apt would install them, it only simulates.

usage: unpacked_packages.py FOLDER      the folder of the packages
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile

DOMAIN = "97"  # nothing else runs beside this
LIMIT = 120  # [s]


def run(words: list[str], **options: object) -> str:
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LIMIT, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)} failed with {done.returncode}:\n{done.stdout}")
    return done.stdout


def main() -> None:
    packages = sorted(str(path.resolve()) for path in pathlib.Path(sys.argv[1]).glob("*.deb"))
    if len(packages) != 4:
        sys.exit(f"{sys.argv[1]} has {len(packages)} packages, not 4")
    planned = run(["apt-get", "install", "--simulate", "--quiet", *packages])
    for name in ("hecaton", "hecaton-strategies", "libhecaton-dev", "python3-hecaton"):
        if f"Inst {name} " not in planned:
            sys.exit(f"apt would not install {name}:\n{planned}")
    with tempfile.TemporaryDirectory() as folder:
        for package in packages:
            run(["dpkg-deb", "--extract", package, folder])
        use(pathlib.Path(folder) / "usr")
    print("the packages can be installed; an unpacked cell of three arms reached goals of the unpacked Python package")


def use(usr: pathlib.Path) -> None:
    cell = str(usr / "share/hecaton/cells/three_puma.yaml")
    environment = dict(os.environ, HECATON_DOMAIN=DOMAIN, PYTHONPATH=str(usr / "lib/python3/dist-packages"))
    words = [str(usr / "bin/hecaton"), "up", cell, "--headless", "--start-timeout", f"{LIMIT}s"]
    # A shell in the background leaves SIGINT ignored to its children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(words, env=environment, stderr=subprocess.PIPE, text=True) as up:
        said = []
        try:
            for line in up.stderr:
                said.append(line)
                if "the cell is up" in line:
                    break
            else:
                sys.exit(f"{' '.join(words)} ended:\n{''.join(said)}")
            example = str(usr / "share/doc/python3-hecaton/examples/python/random_goals.py")
            told = run(["/usr/bin/python3", example, cell, "6"], env=environment)
            if "6 goals" not in told:
                sys.exit(f"random_goals.py says:\n{told}")
        finally:
            up.send_signal(signal.SIGINT)
            rest = up.stderr.read()
        if up.wait(LIMIT) != 0:
            sys.exit(f"{' '.join(words)} ended with {up.returncode}:\n{rest}")


main()
