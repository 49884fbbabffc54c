"""The named poses between which the arms of a cell move.

usage: poses.py --self-test"""
import sys
import unittest

APART = 0.1  # [rad or m] smallest difference in a joint of each arm


def common_poses(arms):
    """Names of the poses that all arms have, home first. `arms`: from `hecaton check -o json`."""
    common = set.intersection(*(set(arm["named"]) for arm in arms))
    return sorted(common, key=lambda name: (name != "home", name))


def apart(arms, one, other):
    return all(max(abs(a - b) for a, b in zip(arm["named"][one], arm["named"][other])) > APART for arm in arms)


def two_poses(arms, route=()):
    """The first two of the route, which all arms can have at once (docs/reference/cell-file.md), otherwise of all that they have in
    common; None: there are no two that are apart."""
    names = list(route) or common_poses(arms)
    return next(((names[0], other) for other in names[1:] if apart(arms, names[0], other)), None)


class PosesTest(unittest.TestCase):
    def arms(self, *poses):
        return [{"named": named} for named in poses]

    def test_home_and_the_next_common_pose(self):
        arms = self.arms({"ahead": [1.0], "home": [0.0], "up": [2.0]}, {"home": [0.0], "up": [2.0]})
        self.assertEqual(two_poses(arms), ("home", "up"))

    def test_pose_equal_to_home_does_not_count(self):
        arms = self.arms({"home": [0.7, 0.0], "left": [0.7, 0.05], "right": [-1.3, 0.0]})
        self.assertEqual(two_poses(arms), ("home", "right"))

    def test_pose_sequence_has_precedence(self):
        arms = self.arms({"home": [0.0], "left": [0.0], "right": [1.0], "up": [2.0]})
        self.assertEqual(two_poses(arms, ["left", "right"]), ("left", "right"))

    def test_one_pose_is_too_few(self):
        self.assertIsNone(two_poses(self.arms({"home": [0.0]})))
        self.assertIsNone(two_poses(self.arms({"home": [0.0], "up": [1.0]}, {"home": [0.0], "down": [1.0]})))


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
