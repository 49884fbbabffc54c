"""What hecaton-chaos says before it starts anything, and its exit codes.

usage: test_command_line.py PROGRAM FOLDER_OF_CELLS"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM, CELLS = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()


def asked(*words):
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)


class CommandLineTest(unittest.TestCase):
    def assert_refused(self, code, saying, *words):
        done = asked(*words)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertRegex(done.stderr, saying)
        return done.stderr

    def assert_bad_input(self, saying, *words):
        """In one sentence."""
        said = self.assert_refused(3, f"^hecaton-chaos: .*{saying}", *words)
        self.assertEqual(said.count("\n"), 1, said)

    def test_help_is_data(self):
        done = asked("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for word in ("CELL", "--duration", "Exit codes", "70", "75", "77"):
            self.assertIn(word, done.stdout)

    def test_what_is_no_command_is_a_usage_error(self):
        cell = CELLS / "three_hosts.yaml"
        for words in ((), (cell, "--nonsense"), (cell, "--only", "flood"), (cell, "-o", "xml"), (cell, cell)):
            self.assert_refused(2, "usage: hecaton-chaos", *words)

    def test_a_cell_file_that_cannot_be_read_is_bad_input(self):
        self.assert_bad_input("missing.yaml", "missing.yaml")
        self.assert_bad_input("robot", CELLS / "urdf" / "puma560.urdf")

    def test_an_invalid_cell_file_is_refused_as_hecaton_check_refuses_it(self):
        with tempfile.TemporaryDirectory() as folder:
            cell = pathlib.Path(folder) / "cell.yaml"
            cell.write_text("name: cell\narms: []\n")
            check = subprocess.run([pathlib.Path(PROGRAM).with_name("hecaton"), "check", cell], capture_output=True, text=True)
            self.assertEqual(asked(cell).stderr, check.stderr.replace("hecaton: ", "hecaton-chaos: ", 1))
            self.assert_bad_input("arms", cell)

    def test_arms_with_one_pose_have_nowhere_to_go(self):
        with tempfile.TemporaryDirectory() as folder:
            cell = pathlib.Path(folder) / "cell.yaml"
            cell.write_text(f"name: cell\narms:\n  - name: left\n    urdf: {CELLS}/urdf/puma560.urdf\n"
                            "    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n")
            self.assert_bad_input("two named poses", cell)

    def test_values_that_cannot_be_are_bad_input(self):
        cell = CELLS / "three_hosts.yaml"
        self.assert_bad_input("--duration = '90'", cell, "--duration", "90")
        self.assert_bad_input("--of = 'diver'", cell, "--of", "diver")
        self.assert_bad_input("--report = ", cell, "--report", "/no/such/folder/report.json")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
