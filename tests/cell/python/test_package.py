"""The package's files: stubs and documentation agree with the module."""

import ast
import inspect
import pathlib
import unittest

import hecaton
from hecaton import _hecaton

STUB = pathlib.Path(hecaton.__file__).with_name("_hecaton.pyi")


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


if __name__ == "__main__":
    unittest.main()
