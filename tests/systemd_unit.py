"""Checks the unit of the package with `systemd-analyze verify`, which needs no systemd that runs.

usage: systemd_unit.py UNIT PROGRAM     PROGRAM: what stands for /usr/bin/hecaton, which is not installed here

Exit code 77: there is none, or it cannot say; why is on stderr."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77  # exit code that CTest reports as skipped
OLDEST = 250  # the first that fails on what it warns of

# Each must be complained of, or the silence about the unit would say nothing.
MISTAKES = {"a key that there is not": ("OOMPolicy=", "OOMPolicies="),
            "a time without meaning": ("WatchdogSec=2s", "WatchdogSec=2 parsecs"),
            "a program that there is not": ("ExecStart=/", "ExecStart=/nowhere/")}


class CannotSay(Exception):
    """Why the unit cannot be checked here."""


def version():
    if shutil.which("systemd-analyze") is None:
        raise CannotSay("systemd-analyze is missing")
    said = subprocess.run(["systemd-analyze", "--version"], capture_output=True, text=True, check=True).stdout
    return int(re.match(r"systemd (\d+)", said)[1])


def complaints(text, name):
    """What is said of a unit with this text."""
    with tempfile.TemporaryDirectory() as folder:
        unit = pathlib.Path(folder) / name
        unit.write_text(text)
        # Its manual page is not installed here either.
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", str(unit)],
                              capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if done.returncode != 0 and name.partition("@")[0] not in said:
        raise CannotSay(f"systemd-analyze says nothing of the unit, but: {said or done.returncode}")
    return said


def check(path, program):
    """What is wrong."""
    if version() < OLDEST:
        raise CannotSay(f"systemd-analyze is older than {OLDEST}")
    text = re.sub(r"^ExecStart=\S+", f"ExecStart={program}", path.read_text(), flags=re.M)
    wrong = [complaint for complaint in [complaints(text, path.name)] if complaint]
    for what, (right, mistaken) in MISTAKES.items():
        if right not in text:
            wrong.append(f"the unit has no '{right}' any more: {what} cannot be tried")
        elif not complaints(text.replace(right, mistaken), path.name):
            wrong.append(f"{what} is not complained of")
    return wrong


def main():
    path, program = map(pathlib.Path, sys.argv[1:])
    try:
        wrong = check(path, program.resolve())
    except CannotSay as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        return SKIPPED
    print("\n".join(wrong) or f"{path.name}: nothing to complain of")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
