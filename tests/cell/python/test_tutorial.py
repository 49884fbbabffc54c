"""The tutorial docs/tutorials/own-two-arm-cell.md: its commands are run as they stand, in one folder."""
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import threading
import unittest

from live_cell import BIN, SOURCE, Domain

GUIDE = SOURCE / "docs/tutorials/own-two-arm-cell.md"
LIMIT = 300  # [s] of a command, far more than needed
# What a test cannot do as it stands.
OTHERWISE = {"hecaton status --watch": "hecaton status",  # without an end
             "hecaton simulate my_cell.yaml --tasks 100": "hecaton simulate my_cell.yaml --tasks 10"}  # to save time


class Tutorial(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        domain = Domain()
        self.addCleanup(domain.close)
        self.environment = os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}", "HECATON_DOMAIN": str(domain.number)}

    def run_command(self, command):
        words = shlex.split(OTHERWISE.get(command, command))
        done = subprocess.run(words, cwd=self.folder, env=self.environment, text=True, capture_output=True, timeout=LIMIT)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def bring_up(self, command):
        """Starts the cell and waits for the line that the tutorial names."""
        process = subprocess.Popen(shlex.split(command) + ["--headless"], cwd=self.folder, env=self.environment, text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        lines = []
        up = threading.Event()

        def read():
            for line in process.stderr:
                lines.append(line)
                if "the cell is up" in line:
                    up.set()
            up.set()

        reader = threading.Thread(target=read, daemon=True)
        reader.start()

        def end():
            process.terminate()
            process.wait(LIMIT)
            reader.join()
            process.stderr.close()

        self.addCleanup(end)
        self.assertTrue(up.wait(LIMIT) and process.poll() is None, "".join(lines))

    def test_commands_work_as_they_stand(self):
        text = GUIDE.read_text()
        prose = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
        commands = re.findall(r"^ {4}(hecaton .*)$", prose, flags=re.M)
        self.assertGreaterEqual(len(commands), 8)
        for command in commands:
            if command.startswith("hecaton up "):
                self.bring_up(command)
            else:
                self.run_command(command)
        # Section 6: obstacles below the line `obstacles:`.
        obstacles = re.search(r"^```yaml\n(.*?)^```", text, flags=re.M | re.S)[1]
        cell = self.folder / "my_cell.yaml"
        before, line, after = cell.read_text().partition("\nobstacles:\n")
        self.assertTrue(line)
        cell.write_text(before + line + obstacles + after)
        self.run_command("hecaton check my_cell.yaml")


if __name__ == "__main__":
    sys.exit(unittest.main())
