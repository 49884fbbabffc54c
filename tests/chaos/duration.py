"""Durations with their unit, as everywhere in Hecaton (services/config/text.cpp).

usage: duration.py --self-test"""
import re
import sys
import unittest

UNITS = "ns, us, ms, s or min"
SECONDS = {"ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0}
SPELLING = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?) *(ns|us|µs|ms|s|min)", re.ASCII)


def parse_duration(text):
    """Returns seconds; None if the text is not a number with a unit."""
    spelled = SPELLING.fullmatch(text)
    return float(spelled[1]) * SECONDS[spelled[2]] if spelled else None


class DurationTest(unittest.TestCase):
    def test_each_unit(self):
        for text, seconds in {"10min": 600.0, "90s": 90.0, "1.5 s": 1.5, "500ms": 0.5, "20us": 2e-5, "20µs": 2e-5, "5ns": 5e-9,
                              ".5s": 0.5, "1e3ms": 1.0, "-1s": -1.0}.items():
            self.assertAlmostEqual(parse_duration(text), seconds, places=12, msg=text)

    def test_anything_else_is_none(self):
        for text in ("", "10", "s", "10 m", "10h", "10s ", " 10s", "1_0s", "1,5s", "infs", "nans", "١s"):
            self.assertIsNone(parse_duration(text), text)


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
