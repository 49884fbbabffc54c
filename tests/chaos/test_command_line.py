"""Errors of hecaton-chaos before it starts a cell, and exit codes.

usage: test_command_line.py PROGRAM FOLDER_OF_CELLS"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM, CELLS = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
CELL = CELLS / "three_hosts.yaml"


def asked(*words):
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)


class Asking(unittest.TestCase):
    def assert_refused(self, code, saying, *words):
        done = asked(*words)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertRegex(done.stderr, saying)
        return done.stderr

    def assert_bad_input(self, saying, *words):
        """The error must be one sentence."""
        said = self.assert_refused(3, f"^hecaton-chaos: .*{saying}", *words)
        self.assertEqual(said.count("\n"), 1, said)
        return said


class CommandLineTest(Asking):
    def test_help_goes_to_stdout(self):
        done = asked("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for word in ("CELL", "--duration", "Exit codes", "70", "75", "77"):
            self.assertIn(word, done.stdout)

    def test_unknown_options_are_usage_errors(self):
        cell = CELLS / "three_hosts.yaml"
        for words in ((), (cell, "--nonsense"), (cell, "--only", "flood"), (cell, "-o", "xml"), (cell, cell),
                      (cell, "--soak", "3s", "--duration", "3s")):
            self.assert_refused(2, "usage: hecaton-chaos", *words)

    def test_unreadable_cell_file_is_bad_input(self):
        self.assert_bad_input("missing.yaml", "missing.yaml")
        self.assert_bad_input("robot", CELLS / "urdf" / "puma560.urdf")

    def test_invalid_cell_file_gives_the_error_of_hecaton_check(self):
        with tempfile.TemporaryDirectory() as folder:
            cell = pathlib.Path(folder) / "cell.yaml"
            cell.write_text("name: cell\narms: []\n")
            check = subprocess.run([pathlib.Path(PROGRAM).with_name("hecaton"), "check", cell], capture_output=True, text=True)
            self.assertEqual(asked(cell).stderr, check.stderr.replace("hecaton: ", "hecaton-chaos: ", 1))
            self.assert_bad_input("arms", cell)

    def test_three_hosts_cannot_be_split(self):
        self.assert_bad_input("--only = 'split' needs a cell of at least 4 hosts; this cell has 3",
                              CELLS / "three_machines.yaml", "--only", "split")

    def test_arms_need_two_poses(self):
        with tempfile.TemporaryDirectory() as folder:
            cell = pathlib.Path(folder) / "cell.yaml"
            cell.write_text(f"name: cell\narms:\n  - name: left\n    urdf: {CELLS}/urdf/puma560.urdf\n"
                            "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n")
            self.assert_bad_input("two named poses", cell)

    def test_invalid_values_are_bad_input(self):
        cell = CELLS / "three_hosts.yaml"
        self.assert_bad_input("--duration = '90'", cell, "--duration", "90")
        self.assert_bad_input("--of = 'diver'", cell, "--of", "diver")
        self.assert_bad_input("--report = ", cell, "--report", "/no/such/folder/report.json")
        self.assert_bad_input("--logs = .* must be a folder", cell, "--logs", cell)

    def test_paths_below_run_are_rejected(self):
        self.assert_bad_input("CELL = .* must not be below /run", "/run/cell.yaml")
        self.assert_bad_input("--report = .* must not be below /run", CELL, "--report", "/run/report.json")
        self.assert_bad_input("--logs = .* must not be below /run", CELL, "--logs", "/run/logs")

    def test_missing_programs_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assert_bad_input("hecaton is missing", CELL, "--programs", folder)
            for name in "hecaton", "hecaton-agent":
                (pathlib.Path(folder) / name).touch()
            self.assert_bad_input("hecaton-planner is missing", CELL, "--programs", folder)


class CellFileTest(Asking):
    """With a copy of a cell file; the robot stays at its place."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.text = CELL.read_text().replace("urdf: urdf/", f"urdf: {CELLS}/urdf/")

    def write(self, name="cell.yaml", text=None):
        file = self.folder / name
        file.write_text(text or self.text)
        return file

    def test_cell_file_is_not_overwritten(self):
        cell = self.write("chaos-cell.yaml")
        self.assert_bad_input("--logs = .* must not overwrite the cell file", cell, "--logs", self.folder)
        self.assert_bad_input("--report = .* must not overwrite the cell file", cell, "--report", cell)
        link = self.folder / "link"
        link.symlink_to(cell)
        self.assert_bad_input("--report = .* must not overwrite the cell file", cell, "--report", link)
        self.assert_bad_input("--logs = .* must not overwrite the cell file", self.write("west-pc.log"), "--logs", self.folder)
        self.assertEqual(cell.read_text(), self.text)

    def test_report_must_not_be_a_log(self):
        logs = self.folder / "logs"
        logs.mkdir()
        for name in "north-pc.log", "chaos-cell.yaml":
            self.assert_bad_input("--report = .* must not be a file in --logs", self.write(), "--logs", logs, "--report", logs / name)

    def test_keystore_of_another_run_is_not_touched(self):
        (self.folder / "keys").mkdir()
        self.assert_bad_input("--logs = .* must not have a keystore", CELL, "--keys", "--logs", self.folder)

    def test_cell_file_must_be_text(self):
        cell = self.write()
        cell.write_bytes("# größer\n".encode("latin-1") + cell.read_bytes())
        self.assert_bad_input("cell.yaml: ", cell, "--logs", self.folder)
        cell.write_bytes(b"name: \xff\n")
        self.assert_bad_input("name", cell)

    def refused_by_report(self, cell):
        """Must be rejected only for this reason."""
        self.assert_bad_input("--report = .* must not overwrite", cell, "--report", cell)

    def test_network_interface_may_be_of_another_machine(self):
        text = self.text.replace("  domain: 43\n", "  domain: 43\n  interface: eth77\n")
        self.assertNotEqual(text, self.text)
        self.refused_by_report(self.write(text=text))
        cell = self.write(text=text.replace("host: west-pc", "host: nowhere-pc"))
        self.assertIn(f"{cell}: ", self.assert_bad_input("nowhere-pc", cell))

    def test_paths_are_relative_to_the_link_of_the_cell_file(self):
        elsewhere = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (elsewhere / "cell.yaml").write_text(CELL.read_text().replace("  domain: 43\n", "  domain: 43\n  interface: eth77\n"))
        link = self.folder / "cell.yaml"
        link.symlink_to(elsewhere / "cell.yaml")
        (self.folder / "urdf").symlink_to(CELLS / "urdf")
        self.refused_by_report(link)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
