"""Draws all ready cells, as they start, with `hecaton render`.

usage: draw_cells.py HECATON          in the root of the repository, with chromium

docs/reference/ready-cells.md shows the pictures; tests/reference_pages.py writes its table."""
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path("docs/figures/cells")
FROM_ABOVE = {"corridor", "corridor_three", "mobile_rectangle", "narrow_passage", "planar_2r", "planar_3r"}


def main():
    hecaton = sys.argv[1]
    FOLDER.mkdir(exist_ok=True)
    for cell in [*sorted(pathlib.Path("deploy/cells").glob("*.yaml")), *sorted(pathlib.Path("deploy/cells/named").glob("*.yaml"))]:
        picture = FOLDER / f"{cell.stem}.png"
        view = "top" if cell.stem in FROM_ABOVE else "free"
        subprocess.run([hecaton, "render", cell, "-o", picture, "--width", "360", "--height", "240", "--view", view], check=True)


main()
