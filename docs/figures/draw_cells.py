"""Draws all ready cells with `hecaton render`, and writes the page that shows them.

usage: draw_cells.py HECATON          in the root of the repository, with chromium

Each picture has the cell as it starts; its text is the first sentence of the cell file, without a figure or section of a paper, and
without details behind a semicolon or a colon."""
import pathlib
import re
import subprocess
import sys

FOLDER = pathlib.Path("docs/figures/cells")
PAGE = pathlib.Path("docs/reference/ready-cells.md")
FROM_ABOVE = {"corridor", "corridor_three", "mobile_rectangle", "narrow_passage", "planar_2r", "planar_3r"}
HEAD = """# Ready cells

For newcomers who look for a cell to begin with. The files are in `deploy/cells`: `hecaton up CELL` runs one, `hecaton simulate CELL` simulates it.

| cell | as it starts | what it is |
|---|---|---|
"""


def sentence_of(cell):
    lines = []
    for line in cell.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line[1:].strip())
    sentence = re.match(r".+?(?<!fig)\.(?=\s+[A-Z\[]|$)", " ".join(lines)).group()
    text = re.sub(r"^\[\w+\] (fig\.|sections?) [\d to]+: ", "", sentence.rstrip("."))
    text = re.split("[:;] ", text)[0]
    return (text[0].upper() + text[1:]).replace("|", "\\|")


def main():
    hecaton = sys.argv[1]
    FOLDER.mkdir(exist_ok=True)
    rows = []
    for cell in [*sorted(pathlib.Path("deploy/cells").glob("*.yaml")), *sorted(pathlib.Path("deploy/cells/named").glob("*.yaml"))]:
        picture = FOLDER / f"{cell.stem}.png"
        view = "top" if cell.stem in FROM_ABOVE else "free"
        subprocess.run([hecaton, "render", cell, "-o", picture, "--width", "360", "--height", "240", "--view", view], check=True)
        name = cell.relative_to("deploy/cells").with_suffix("")
        rows.append(f"| `{name}` | ![{name}](../figures/cells/{cell.stem}.png) | {sentence_of(cell)} |\n")
    PAGE.write_text(HEAD + "".join(rows), encoding="utf-8")


main()
