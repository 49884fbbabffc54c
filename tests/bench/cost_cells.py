"""What benchmarks of a service's cost share: cells of N arms on a grid, and processes that end with the measurement."""
import contextlib
import subprocess
import sys

from supervision_cost import ROOT


def grid_cell(folder, arms, more):
    """A cell file of `arms` arms, with the lines `more`."""
    cell = folder / f"grid{arms}.yaml"
    subprocess.run([sys.executable, ROOT / "deploy/cells/grid_cell.py", str(arms), "-o", cell], check=True)
    cell.write_text(cell.read_text() + more)
    return cell


@contextlib.contextmanager
def running(log, *commands, **options):
    """The processes of the commands; their errors go to `log`."""
    with contextlib.ExitStack() as stack:
        processes = []
        for command in commands:
            process = subprocess.Popen([str(word) for word in command], stderr=log, **options)
            stack.callback(process.wait)
            stack.callback(process.terminate)
            processes.append(process)
        yield processes
