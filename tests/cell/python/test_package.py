"""The package's files: stubs and documentation agree with the module."""

import ast
import importlib.util
import inspect
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import hecaton
from hecaton import _hecaton

STUB = pathlib.Path(hecaton.__file__).with_name("_hecaton.pyi")
HERE = pathlib.Path(__file__).parent
EXAMPLES = HERE.parents[2] / "examples" / "python"


class Stubs(unittest.TestCase):
    def setUp(self):
        self.tree = ast.parse(STUB.read_text())
        self.classes = {node.name: node for node in self.tree.body if isinstance(node, ast.ClassDef)}

    def test_stub_has_each_class_and_constant_of_the_module(self):
        constants = {node.target.id for node in self.tree.body if isinstance(node, ast.AnnAssign) and node.value is None}
        native = {name for name in dir(_hecaton) if not name.startswith("_")}
        self.assertEqual(native, set(self.classes) | constants)

    def test_stub_has_each_member_of_each_class(self):
        for name, node in self.classes.items():
            stub = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
            native = {key for key in vars(getattr(_hecaton, name)) if not key.startswith("_")}
            self.assertEqual(native, {member for member in stub if not member.startswith("_")}, name)

    def test_words_of_the_stub_are_those_of_the_module(self):
        words = {node.target.id: [each.value for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
                 for node in self.tree.body if isinstance(node, ast.AnnAssign) and node.value is not None}
        self.assertEqual(tuple(words["GoalState"][:-1]), hecaton.GOAL_STATES)
        self.assertEqual(tuple(words["FreeRotation"]), hecaton.FREE_ROTATIONS)
        self.assertEqual(tuple(words["Mode"][:-1]), hecaton.CELL_MODES)


    @unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
    def test_programs_with_types_pass_strict_mypy(self):
        environment = dict(os.environ, MYPYPATH=str(STUB.parent.parent))
        for program in (HERE / "typed_program.py", EXAMPLES / "camera_obstacles.py", EXAMPLES / "two_arms_hand_over.py"):
            with tempfile.TemporaryDirectory() as cache:
                done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", cache, program],
                                      env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Import(unittest.TestCase):
    """Imports a copy of the package whose native part has another file name."""

    def failure(self, native):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "hecaton"
            package.mkdir()
            for file in STUB.parent.glob("*.py"):
                (package / file.name).symlink_to(file.resolve())
            if native:
                (package / native).touch()
            done = subprocess.run([sys.executable, "-c", "import hecaton"], env=dict(os.environ, PYTHONPATH=folder),
                                  capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        return done.stderr.splitlines()[-1]

    def test_other_python_is_told_which_one_is_needed(self):
        failure = self.failure("_hecaton.cpython-299-x86_64-linux-gnu.so")
        self.assertIn("hecaton is built for CPython 2.99, but", failure)
        self.assertTrue(failure.endswith("run the program with python2.99"), failure)

    def test_missing_native_part_is_named(self):
        self.assertIn("the native part of hecaton is missing", self.failure(""))

    def test_broken_native_part_keeps_its_own_error(self):
        self.assertIn("file too short", self.failure(pathlib.Path(_hecaton.__file__).name))


class Documentation(unittest.TestCase):
    def test_each_public_class_and_method_has_a_docstring(self):
        for name in hecaton.__all__:
            value = getattr(hecaton, name)
            if not inspect.isclass(value) and not inspect.isfunction(value):
                continue
            self.assertTrue(value.__doc__, name)
            for key, member in vars(value).items():
                if not key.startswith("_") and (inspect.isfunction(member) or isinstance(member, property)):
                    self.assertTrue(member.__doc__, f"{name}.{key}")

    def test_all_lists_the_public_names(self):
        public = {name for name, value in vars(hecaton).items()
                  if not name.startswith("_") and not inspect.ismodule(value)}
        self.assertEqual(public, set(hecaton.__all__))


class Coverage(unittest.TestCase):
    """The package offers what the C++ library offers."""

    OTHER_NAMES = {"Arm.close_gripper": "Tool.close", "Arm.open_gripper": "Tool.open", "Arm.tool": "Tool.state",
                   "Arm.set_signal": "Signals.set", "Arm.wait_for_signal": "Signals.wait", "Arm.place_joint": "Arm.posture",
                   "Cell.connect": "connect"}
    LEFT_OUT = {"Cell.wait_until"}  # a loop over status() or updates() does the same
    ARGUMENTS = {"Vector3", "GripOptions", "Trajectory", "TrajectoryPoint"}  # arrays and keywords in Python

    def blocks(self, header, kind):
        """Class name and public part of each class or struct."""
        text = (HERE.parents[2] / "services" / "client" / "include" / "hecaton" / header).read_text()
        for name, body in re.findall(rf"^{kind} (?:HECATON_API )?(\w+)[^;{{]* {{\n(.*?)^}};", text, re.M | re.S):
            yield name, body.split(" private:")[0]

    def test_each_function_of_the_c_library_has_one_in_python(self):
        found = set()
        for name, body in self.blocks("client.hpp", "class"):
            if name not in {"Goal", "Arm", "World", "Cell"}:
                continue
            functions = re.findall(r"^  (?:\[\[nodiscard\]\] |static |const )*[\w:<>]+[&]? (\w+)\(", body, re.M)
            found |= {f"{name}.{function}" for function in functions if function != name}
        self.assertIn("Arm.follow", found)
        for function in sorted(found - self.LEFT_OUT):
            path = self.OTHER_NAMES.get(function, function).split(".")
            value = hecaton
            for part in path:
                value = getattr(value, part, None)
            self.assertIsNotNone(value, function)

    def test_each_field_of_the_c_library_has_one_in_python(self):
        found = 0
        for name, body in self.blocks("types.hpp", "struct"):
            if name in self.ARGUMENTS:
                continue
            fields = re.findall(r"^  [\w:<>, ]+ (\w+)(?:\{[^;]*\}| = [^;]+)?;", body, re.M)
            found += len(fields)
            for field in fields:
                self.assertTrue(hasattr(getattr(hecaton, name), field), f"{name}.{field}")
        self.assertGreater(found, 80)


if __name__ == "__main__":
    unittest.main()
