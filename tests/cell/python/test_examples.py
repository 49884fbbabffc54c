"""The programs of examples/python against a running cell."""

import contextlib
import importlib.util
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import time
import types
import unittest
import unittest.mock

import hecaton
from live_cell import SOURCE, LiveCell

EXAMPLES = SOURCE / "examples" / "python"
PAGE = SOURCE / "docs" / "how-to" / "python.md"


class Examples(LiveCell):
    def run_example(self, name, *arguments):
        environment = dict(os.environ, HECATON_DOMAIN=str(self.domain.number))
        done = subprocess.run([sys.executable, EXAMPLES / name, self.file, *arguments], env=environment,
                              capture_output=True, text=True, timeout=900)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def test_two_arms_hand_over_a_part(self):
        done = self.run_example("two_arms_hand_over.py")
        self.assertIn("west carries part", done.stdout)

    def test_a_hundred_random_goals_have_no_lost_outcome_and_no_contact_and_a_plot(self):
        # `./run test` installs matplotlib: a test that misses it fails there.
        drawn = importlib.util.find_spec("matplotlib") is not None or "HECATON_SKIP_NOTHING" in os.environ
        with tempfile.TemporaryDirectory() as folder:
            plot = pathlib.Path(folder, "times.png")
            begun = time.monotonic()
            done = self.run_example("random_goals.py", "100", plot)
            print(f"{time.monotonic() - begun:.0f} s:", *done.stdout.splitlines(), sep="\n  ")
            if drawn:
                self.assertIn(f"plot in {plot}", done.stdout)
                self.assertTrue(plot.read_bytes().startswith(b"\x89PNG\r\n"))
                self.assertGreater(plot.stat().st_size, 5000)
        self.assertIn("100 goals: ", done.stdout)
        self.assertNotIn("unanswered", done.stdout)
        self.assertIn("contacts: 0", done.stdout)

    def test_camera_obstacles_come_and_go(self):
        done = self.run_example("camera_obstacles.py", "40")
        self.assertEqual(done.stderr, "")
        self.assertIn("40 frames; obstacles left: 0", done.stdout)


class Notebooks(LiveCell):
    """The examples as VS Code and Jupytext see them: cells that begin with `# %%`."""

    def cells(self, example):
        return re.split(r"^# %%.*\n", example.read_text(), flags=re.M)

    def test_each_example_has_cells(self):
        for example in EXAMPLES.glob("*.py"):
            self.assertGreater(len(self.cells(example)), 4, example)

    def test_cells_run_one_after_the_other_without_a_command_line(self):
        printed = io.StringIO()
        kernel = {"ipykernel": types.ModuleType("ipykernel")}
        environment = {"HECATON_DOMAIN": str(self.domain.number)}
        program = {}
        with unittest.mock.patch.dict(sys.modules, kernel), unittest.mock.patch.dict(os.environ, environment), \
                contextlib.chdir(SOURCE), contextlib.redirect_stdout(printed):
            for cell in self.cells(EXAMPLES / "two_arms_hand_over.py"):
                exec(compile(cell, "two_arms_hand_over.py", "exec"), program)
        self.assertIn("west carries part", printed.getvalue())


class Page(LiveCell):
    """The blocks of docs/how-to/python.md, as they stand, in one program."""

    def test_blocks_run_as_they_stand(self):
        blocks = [textwrap.dedent(block) for block in re.findall(r"(?:^ {4}.*\n|^\n(?= {4}))+", PAGE.read_text(), re.M)]
        programs = [block for block in blocks if "PYTHONPATH=" not in block]
        self.assertEqual(len(programs), 3)
        program = {"hecaton": hecaton}
        printed = io.StringIO()
        environment = {"HECATON_DOMAIN": str(self.domain.number)}
        with unittest.mock.patch.dict(os.environ, environment), contextlib.chdir(SOURCE), contextlib.redirect_stdout(printed):
            for block in programs:
                if "cell" in program:  # `with` of the first block has closed it
                    program |= {"cell": self.cell, "q": hecaton.load(self.file).arm("north").start}
                exec(compile(block, str(PAGE), "exec"), program)
        self.assertIn("reached", printed.getvalue())


if __name__ == "__main__":
    unittest.main()
