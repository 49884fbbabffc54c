#!/usr/bin/env python3
"""The cost of hecaton record: processor time, memory, size per minute and losses, while three_puma goes to random goals.

usage: recorder_cost.py BIN [--cell FILE] [--minutes 1] [--rounds 3]

BIN is the folder of Hecaton's programs. A round records for that time, from ten seconds after the begin of the recorder on.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile
import time

from cell_cost import ROOT, Cost, resident_megabytes, running

DOMAIN = 43
SETTLE = 10.0  # [s]


def await_text(path, text, process):
    until = time.monotonic() + 60.0
    while time.monotonic() < until and process.poll() is None:
        if text in path.read_text():
            return
        time.sleep(0.05)
    raise SystemExit(f"recorder_cost: '{text}' did not come: {path.read_text()[-2000:]}")


def missed(programs, recording):
    """Samples that were received, and those that the recording lacks for any reason."""
    info = json.loads(subprocess.run([programs / "hecaton", "-o", "json", "bag", "info", recording], check=True,
                                     capture_output=True).stdout)
    topics = info["losses"].values()
    # `lost` counts a gap of `missing` once more.
    lacks = sum(max(topic["missing"], topic["lost"]) + topic["overflowed"] + topic["refused"] for topic in topics)
    return sum(topic["received"] for topic in topics), lacks


def measure(programs, cell, seconds, recording, log):
    with running(log, programs / "hecaton", "--domain", DOMAIN, "record", cell, "-o", recording, stdout=log) as recorder:
        time.sleep(SETTLE)
        size = recording.stat().st_size
        with Cost(recorder.pid) as cost:
            time.sleep(seconds)
        growth = (recording.stat().st_size - size) * 60.0 / cost.seconds / 1e6
        memory = resident_megabytes(recorder.pid)
    received, lacks = missed(programs, recording)
    print(f"{100 * cost.share:8.1f} % {memory:7.1f} MB {growth:8.1f} MB/min {received:10} received {lacks:8} lost", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--cell", type=pathlib.Path, default=ROOT / "deploy/cells/three_puma.yaml")
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    programs = options.programs.resolve()
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as name:
        folder = pathlib.Path(name)
        path = folder / "log"
        with open(path, "w") as log, running(log, programs / "hecaton", "--domain", DOMAIN, "up", options.cell, "--headless",
                                             "--tasks", 1000000, stdout=log) as up:
            await_text(path, "the cell is up", up)
            for i in range(options.rounds):
                measure(programs, options.cell, 60.0 * options.minutes, folder / f"{i}.mcap", log)


main()
