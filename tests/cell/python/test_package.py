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
PAGE = HERE.parents[2] / "docs" / "how-to" / "python.md"


class Stubs(unittest.TestCase):
    def setUp(self):
        self.tree = ast.parse(STUB.read_text())
        self.classes = {node.name: node for node in self.tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")}

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

# `./run test` installs mypy: a test that misses it fails there.
@unittest.skipUnless(importlib.util.find_spec("mypy") or "HECATON_SKIP_NOTHING" in os.environ, "mypy is not installed")
class Types(unittest.TestCase):
    """What mypy says to the package, its examples, and programs of users."""

    WRONG = """import hecaton

def drive(cell: hecaton.Cell, file: hecaton.CellFile) -> None:
    cell.arm(3)
    cell.arm("north").go_to("ready", time_limit="60")
    cell.arm("north").go_to("ready").kind
    cell.world.add("crate", hecaton.Box(0.2, 0.2), hecaton.Pose())
    row: int = file.arm("north").start
"""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def mypy(self, *arguments, module="mypy"):
        environment = dict(os.environ, MYPYPATH=str(STUB.parent.parent))
        return subprocess.run([sys.executable, "-m", module, *arguments], cwd=self.folder, env=environment,
                              capture_output=True, text=True)

    def strict(self, *arguments):
        return self.mypy("--strict", "--cache-dir", self.folder / "cache", *arguments)

    def test_package_examples_and_programs_with_types_pass_strict_mypy(self):
        examples = sorted(EXAMPLES.glob("*.py"))
        self.assertGreaterEqual(len(examples), 3)
        for what in (["-p", "hecaton"], [HERE / "typed_program.py"], *([example] for example in examples)):
            done = self.strict(*what)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    # pybind11 gives its classes a metaclass of its own, and the signature of no constructor.
    PYBIND11 = r"""
hecaton\._hecaton\.[A-Z]\w*
hecaton\._hecaton\.[A-Z]\w*\.__init__
"""

    def test_stub_agrees_with_the_module_in_the_kind_of_each_member(self):
        allowed = self.folder / "allowed"
        allowed.write_text(self.PYBIND11)
        done = self.mypy("hecaton._hecaton", "--allowlist", allowed, module="mypy.stubtest")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_each_wrong_line_of_a_program_is_found(self):
        (self.folder / "wrong.py").write_text(self.WRONG)
        done = self.strict("wrong.py")
        found = {int(line) for line in re.findall(r"^wrong\.py:(\d+): error:", done.stdout, re.M)}
        self.assertEqual(found, set(range(4, 9)), done.stdout + done.stderr)


class Import(unittest.TestCase):
    """Imports a copy of the package whose native part has another file name."""

    def failure(self, native, broken=()):
        """The last line of an import with another native part, and with `broken` modules that cannot be imported."""
        with tempfile.TemporaryDirectory() as folder:
            for name in broken:
                pathlib.Path(folder, name + ".py").write_text("raise ImportError")
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

    def test_missing_numpy_is_named(self):
        failure = self.failure(pathlib.Path(_hecaton.__file__).name, broken=["numpy"])
        self.assertIn("hecaton needs NumPy", failure)
        self.assertIn("install python3-numpy", failure)

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

    def test_each_public_class_says_what_it_is_when_printed(self):
        for name in hecaton.__all__:
            value = getattr(hecaton, name)
            if inspect.isclass(value):
                self.assertIsNot(value.__repr__, object.__repr__, name)

    def test_version_is_that_of_the_build(self):
        self.assertRegex(hecaton.__version__, r"^\d+\.\d+\.\d+$")

    def test_all_lists_the_public_names(self):
        public = {name for name, value in vars(hecaton).items()
                  if not name.startswith("_") and not inspect.ismodule(value)}
        self.assertEqual(public, set(hecaton.__all__))


def attribute(path):
    """The attribute of the package with that path, such as "Tool.close"; None: there is none."""
    value = hecaton
    for part in path.split("."):
        value = getattr(value, part, None)
    return value


def has_parameter(function, name):
    return name in inspect.signature(function).parameters


class Coverage(unittest.TestCase):
    """The package offers what the C++ library offers, without what docs/how-to/python.md names."""

    # Where the package has something else than a class, a function or a field of the same name.
    ELSEWHERE = {
        "Arm.close_gripper": lambda: hecaton.Tool.close, "Arm.open_gripper": lambda: hecaton.Tool.open,
        "Arm.tool": lambda: hecaton.Tool.state, "Arm.set_signal": lambda: hecaton.Signals.set,
        "Arm.wait_for_signal": lambda: hecaton.Signals.wait, "Arm.place_joint": lambda: hecaton.Arm.posture,
        "Cell.connect": lambda: hecaton.connect, "Rejected.cause": lambda: hecaton.Rejected("").kind,
        "Wait": lambda: has_parameter(hecaton.Goal.wait, "timeout"),
        "Wait.limit": lambda: has_parameter(hecaton.Goal.wait, "timeout"),
        "kForever": lambda: inspect.signature(hecaton.Goal.wait).parameters["timeout"].default is None,
        "kAnswerLimit": lambda: hecaton.ANSWER_LIMIT, "kGripperLimit": lambda: hecaton.GRIPPER_LIMIT,
        "is_final": lambda: hecaton.Progress.ended, "Outcome.text": lambda: "__str__" in vars(hecaton.Outcome),
        **dict.fromkeys(("Vector3", "Vector3.x", "Vector3.y", "Vector3.z"), lambda: len(hecaton.Pose.xyz(1, 2, 3).position) == 3),
        "TrajectoryPoint.time": lambda: has_parameter(hecaton.Arm.follow, "times"),
        "TrajectoryPoint.q": lambda: has_parameter(hecaton.Arm.follow, "positions"),
        "TrajectoryPoint.qd": lambda: has_parameter(hecaton.Arm.follow, "velocities"),
        "TrajectoryPoint.qdd": lambda: has_parameter(hecaton.Arm.follow, "accelerations"),
        "Trajectory.points": lambda: has_parameter(hecaton.Arm.follow, "positions")}
    # Structures whose fields are arguments of a function.
    ARGUMENTS = {"GoalOptions": hecaton.Arm.go_to, "ConnectOptions": hecaton.connect, "GripOptions": hecaton.Tool.close,
                 "Trajectory": hecaton.Arm.follow, "TrajectoryPoint": hecaton.Arm.follow}

    def setUp(self):
        rows = re.findall(r"^\| `([\w:]+)` \| (\S.*) \|$", PAGE.read_text(), re.M)
        self.left_out = {name.replace("::", ".") for name, why in rows}

    def public_names(self):
        """Names of the headers of the C++ library: NAME of a class, a function or a constant, NAME.MEMBER of a class."""
        for header in ("client.hpp", "types.hpp"):
            text = (HERE.parents[2] / "services" / "client" / "include" / "hecaton" / header).read_text()
            yield from re.findall(r"^inline constexpr \w+ (\w+)", text, re.M)
            yield from re.findall(r"^\[\[nodiscard\]\] constexpr \w+ (\w+)\(", text, re.M)
            yield from re.findall(r"^struct (\w+) {};", text, re.M)
            for name, body in re.findall(r"^(?:class|struct) (?:HECATON_API )?(\w+)[^;{]* {\n(.*?)^};", text, re.M | re.S):
                body = body.split(" private:")[0]
                yield name
                functions = re.findall(r"^  (?:\[\[nodiscard\]\] |static |const )*[\w:<>]+[&]? (\w+)\(", body, re.M)
                fields = re.findall(r"^  (?! |using |friend )[\w:<>, ]+ (\w+)(?:\{[^;]*\}| = [^;]+)?;", body, re.M)
                yield from (f"{name}.{member}" for member in functions + fields if member != name)

    def has(self, name):
        if name in self.ELSEWHERE:
            return bool(self.ELSEWHERE[name]())
        owner, _, member = name.partition(".")
        if owner in self.ARGUMENTS:
            return not member or has_parameter(self.ARGUMENTS[owner], member)
        return attribute(name) is not None

    def test_headers_are_read(self):
        names = set(self.public_names())
        self.assertGreater(len(names), 150)
        for name in ("Arm.follow", "Goal", "Wait.stop", "Receipt.edition", "Progress.trajectory_time", "kForever", "Box.x",
                     "Interrupted", "is_final", "GoalOptions.free_rotation", "Unreachable.reason", "Circle.centre"):
            self.assertIn(name, names)

    def test_package_has_each_name_that_the_page_does_not_leave_out(self):
        self.assertEqual({name for name in self.public_names() if not self.has(name)}, self.left_out)


if __name__ == "__main__":
    unittest.main()
