"""A search for strategies by one and by several processes of Open MPI: the same bytes, whatever their number.

usage: mpi_search.py MPIRUN HECATON_STRATEGIES CELL
"""
import os
import pathlib
import subprocess
import sys
import tempfile

mpirun, program, cell = sys.argv[1:]
SMALL = ["--tasks", "40", "--confirm", "60", "--alpha", "-2 2", "--beta", "-2.5 1", "--refine", "3", "-o", "json"]
# Root and more processes than processors are refused unless asked for; processes of a test share their processors.
LAUNCH = [mpirun, "--allow-run-as-root", "--oversubscribe", "--bind-to", "none"]


# Open MPI 5 loses parts of what it forwards when processes end: each writes into files of its own.
INTO_FILES = ["sh", "-c", 'exec "$@" > "$0.out.$OMPI_COMM_WORLD_RANK" 2> "$0.err.$OMPI_COMM_WORLD_RANK"']


def search(folder, ranks, more=(), file=cell):
    """Exit code, stderr, and what came out: stdout and both files. ranks 0: without mpirun."""
    for old in [*folder.glob("printed.*")]:
        old.unlink()
    before = [*LAUNCH, "-n", str(ranks), *INTO_FILES, folder / "printed"] if ranks else []
    environment = {**os.environ, "OMPI_MCA_rmaps_base_oversubscribe": "1"}
    ran = subprocess.run([*before, program, "search", file, *SMALL, "--results", folder / "found", *more],
                         capture_output=True, timeout=240, env=environment, check=False)
    printed = b"".join(f.read_bytes() for f in sorted(folder.glob("printed.out.*"))) if ranks else ran.stdout
    says = b"".join(f.read_bytes() for f in sorted(folder.glob("printed.err.*"))) if ranks else ran.stderr
    files = [folder / f"found.{ending}" for ending in ("csv", "yaml")]
    return ran.returncode, says.decode(), [printed, *[f.read_bytes() if f.exists() else b"" for f in files]]


def require(holds, what):
    if not holds:
        sys.exit(what)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    code, says, alone = search(folder, 0)
    require(code == 0 and all(alone), f"alone: exit code {code}: {says}")
    for ranks in (1, 2, 3):
        code, says, found = search(folder, ranks)
        require(code == 0, f"{ranks} ranks: exit code {code}: {says}")
        require(found == alone, f"{ranks} ranks find something else than one process without MPI")

    # What two ranks had done by the middle, three go on with.
    progress = (folder / "found.progress").read_text()
    (folder / "found.progress").write_text(progress[:len(progress) // 2])
    code, says, found = search(folder, 3, ["--resume"])
    require(code == 0 and found == alone, f"resumed by 3 ranks: exit code {code}, other results: {says}")

    code, says, _ = search(folder, 2, file=str(folder / "missing.yaml"))
    require(code == 3 and says.count("hecaton-strategies: ") == 1, f"2 ranks, no cell: exit code {code}, says: {says}")
    code, says, _ = search(folder, 2, ["--resume", "--seed", "9"])
    require(code == 3 and says.count("is of another search") == 1, f"2 ranks, other search: exit code {code}: {says}")
