"""What the measurements of a program's cost share: cells of N arms, processes, processor time and memory."""
import argparse
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_megabytes(pid="self"):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


class Cost:
    """The processor time of a process within a `with` block: `seconds` of the clock, `share` of a processor."""

    def __init__(self, pid):
        self._pid = pid

    def __enter__(self):
        self._spent, self._at = processor_seconds(self._pid), time.monotonic()
        return self

    def __exit__(self, *error):
        self.seconds = time.monotonic() - self._at
        self.share = (processor_seconds(self._pid) - self._spent) / self.seconds


def grid_cell(folder, arms, more=""):
    """A cell file of `arms` arms on a grid, with the lines `more`."""
    cell = folder / f"grid{arms}.yaml"
    subprocess.run([sys.executable, ROOT / "deploy/cells/grid_cell.py", str(arms), "-o", cell], check=True)
    cell.write_text(cell.read_text() + more)
    return cell


def with_keys(programs, cell):
    """Appends to the cell file the keys of a new keystore beside it, with the host localhost."""
    keystore = cell.with_suffix(".keys")
    for words in ["create", keystore], ["add", keystore, "localhost"]:
        subprocess.run([programs / "hecaton", "keystore", *words], check=True, stdout=subprocess.DEVNULL)
    cell.write_text(cell.read_text() + f"security: {{keystore: {keystore}}}\n")


@contextlib.contextmanager
def running(log, *command, **options):
    """A process that ends with the block. Its errors go to `log`."""
    process = subprocess.Popen([str(word) for word in command], stderr=log, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def for_each_size(description, sizes, heading, measure):
    """Reads the command line BIN [--arms N,N] [--seconds S] and calls measure(programs, cell, arms, seconds, folder, log) for
    each N. `cell` is the file of a grid of N arms, to which `measure` may append."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default=sizes)
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    print(heading, flush=True)
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as name:
        folder = pathlib.Path(name)
        for arms in map(int, options.arms.split(",")):
            cell = grid_cell(folder, arms)
            with open(folder / f"{arms}.log", "w") as log:
                measure(options.programs.resolve(), cell, arms, options.seconds, folder, log)
