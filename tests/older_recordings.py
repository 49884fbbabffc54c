#!/usr/bin/env python3
"""Makes a small recording of this version of the messages for tests/data/recordings, and what must be read from it.

usage: older_recordings.py FOLDER_OF_PROGRAMS

Run it after a change of SCHEMA_VERSION: from then on a test proves that this version stays readable.
"""
import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def main():
    hecaton = pathlib.Path(sys.argv[1]).resolve() / "hecaton"
    version = re.search(r"SCHEMA_VERSION = (\d+);", (ROOT / "idl/common.idl").read_text())[1]
    target = ROOT / f"tests/data/recordings/version-{version}.mcap"
    target.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        # The recording has the names of the files: they shall not be those of a machine.
        deploy = pathlib.Path("/tmp/hecaton/deploy")
        shutil.copytree(ROOT / "deploy", deploy, dirs_exist_ok=True)
        subprocess.run([hecaton, "simulate", deploy / "cells/three_puma.yaml", "--tasks", "1", "--seed", "3",
                        "--record", target], check=True)
        shutil.rmtree(deploy.parent)
        subprocess.run([hecaton, "bag", "export", target, "--csv", "-o", folder], check=True)
        info = json.loads(subprocess.run([hecaton, "bag", "info", target, "-o", "json"], check=True,
                                         stdout=subprocess.PIPE).stdout)
        rows = {}
        q = {}
        csv.field_size_limit(1 << 30)
        for path in sorted(pathlib.Path(folder).iterdir()):
            with path.open(newline="") as table:
                lines = list(csv.DictReader(table))
            rows[path.stem] = len(lines)
            if path.stem != "ArmState":
                continue
            for line in lines:
                q[line["arm"]] = [value for column, value in line.items() if re.fullmatch(r"q\[\d+\]", column) and value]
    expected = {"messages": info["messages"], "at": round(info["duration_s"] / 2, 1), "rows": rows, "q": q}
    target.with_suffix(".json").write_text(json.dumps(expected, indent=1) + "\n")
    print(target, target.stat().st_size, "bytes")


if __name__ == "__main__":
    main()
