"""What decides which strategies of problem 2A are without fault [Mediavilla02]: the search with one thing changed at a time.

usage: strategy_sensitivity.py HECATON_STRATEGIES [-o FILE.csv] [--threads N] [--only GROUP]

Prints a table and writes FILE.csv, which `hecaton-strategies plot FILE.csv` draws. Every row is a search of the 576 strategies in
300 tasks of each arm and, for those without fault, in two sets of 300 more (or as the row says). Ctrl-C ends with the rows so far and
exit code 130.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
URDF = ROOT / "deploy/cells/urdf/scorbot_er9.urdf"
# Group, variant, arguments of scorbot_cell.py, arguments of `search`.
ROWS = [
    ("layout", "as documented", [], []),
    ("layout", "bases 1.0 m apart", ["--spacing", "1.0"], []),
    ("layout", "bases 1.2 m apart", ["--spacing", "1.2"], []),
    ("layout", "side tables at 55 deg", ["--angle", "55"], []),
    ("layout", "side tables at 75 deg", ["--angle", "75"], []),
    ("layout", "grippers 0.60 m out", ["--radius", "0.6"], []),
    ("layout", "grippers 0.25 m up", ["--height", "0.25"], []),
    ("layout", "hand 35 deg down", ["--pitch", "-35"], []),
    ("layout", "no tables", ["--tables", "0"], []),
    ("h", "h = 0.03 m", ["--distance", "0.03"], []),
    ("h", "h = 0.08 m", ["--distance", "0.08"], []),
    ("neighbours", "nearest to the goal first", [], ["--neighbours", "nearest"]),
    ("basis", "from the last axis down", [], ["--basis", "last"]),
    ("basis", "from the first axis up", [], ["--basis", "first"]),
    ("step", "step 0.03 rad", ["--step", "0.03"], []),
    ("trials", "100 tasks, 2 x 100", [], ["--tasks", "100", "--confirm", "100"]),
    ("trials", "600 tasks, 2 x 600", [], ["--tasks", "600", "--confirm", "600"]),
    ("trials", "300 tasks, 2 x 1800", [], ["--confirm", "1800"]),
    ("trials", "300 tasks, 2 x 300, seed 101", [], ["--seed", "101"]),
]


def search(program, threads, cell_arguments, search_arguments, folder):
    cell = folder / "cell.yaml"
    subprocess.run([sys.executable, ROOT / "deploy/cells/scorbot_cell.py", "2a", "--urdf", URDF,
                    *cell_arguments, "-o", cell], check=True)
    arguments = search_arguments if "--confirm" in search_arguments else ["--confirm", "300", *search_arguments]
    ran = subprocess.run([program, "search", cell, "--threads", str(threads), "-o", "json", *arguments],
                         stdout=subprocess.PIPE,
                         stderr=None if sys.stderr.isatty() else subprocess.PIPE, check=False)
    if ran.returncode == 130:
        raise KeyboardInterrupt  # the terminal has signalled the search as well
    if ran.returncode not in (0, 1):
        sys.exit((ran.stderr or b"").decode(errors="replace"))
    return json.loads(ran.stdout)


parser = argparse.ArgumentParser(usage=__doc__)
parser.add_argument("program")
parser.add_argument("-o", "--output")
parser.add_argument("--threads", type=int, default=2)
parser.add_argument("--only", help="one group")
options = parser.parse_args()
table = [("group", "variant", "candidates", "screened", "confirmed", "time")]
rows = [row for row in ROWS if options.only in (None, row[0])]
interrupted = False
with tempfile.TemporaryDirectory() as name:
    for group, variant, cell_arguments, search_arguments in rows:
        try:
            report = search(options.program, options.threads, cell_arguments, search_arguments, pathlib.Path(name))
        except KeyboardInterrupt:
            interrupted = True
            break
        stages, best = report["stages"], report["strategies"]
        table.append((group, variant, stages[0]["candidates"], stages[0]["without_fault"], stages[-1]["without_fault"],
                      f"{best[0]['time_steps']:.2f}"))
        print(f"{group:11} {variant:30} {table[-1][3]:4} {table[-1][4]:4} {table[-1][5]:>8}", flush=True)
if options.output:
    with open(options.output, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(table)
if interrupted:
    print(f"interrupted: {len(table) - 1} of {len(rows)} rows done", file=sys.stderr)
    sys.exit(130)
