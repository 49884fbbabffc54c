"""The command line of hecaton-chaos.

usage: command_line.py --self-test"""
import argparse
import contextlib
import io
import math
import pathlib
import sys
import unittest

from bad_input import BadInput
from duration import UNITS, parse_duration
from injections import KINDS

EXIT_CODES = """\
Data goes to stdout, everything else to stderr. SIGTERM ends a run after the episode under way, with what it found so far.
Exit codes: 0 all of it held; 1 it ran, and something did not; 2 usage; 3 bad input; 70 what did not hold is unsafe: a contact,
an older command that an arm followed, or a driver that lost its memory; 75 something did not hold while the machine itself
stood still, which says nothing of Hecaton; 77 there can be no hosts here (network namespaces), why is said."""


def whole_number(name, low):
    def read(text):
        if not (text.isascii() and text.isdecimal() and int(text) >= low):
            raise BadInput(f"{name} = '{text}' must be a whole number, at least {low}")
        return int(text)
    return read


def duration(name):
    def read(text):
        seconds = parse_duration(text)
        if seconds is None or not 0.0 < seconds < math.inf:
            raise BadInput(f"{name} = '{text}' must be a number with its unit ({UNITS}) above 0")
        return seconds
    return read


def parser_of(description):
    parser = argparse.ArgumentParser(prog="hecaton-chaos", description=description, epilog=EXIT_CODES, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cell", type=pathlib.Path, metavar="CELL", help="cell file")
    add_bounds(parser)
    add_choices(parser)
    parser.add_argument("-o", "--output", choices=("table", "json", "yaml"), default="json", help="how data is printed (json)")
    parser.add_argument("--report", type=pathlib.Path, metavar="FILE", help="also write the figures there, as JSON")
    parser.add_argument("--logs", type=pathlib.Path, metavar="DIR", help="folder for the hosts' logs (a new one)")
    # Folder of hecaton's programs: the launcher says its own.
    parser.add_argument("--programs", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    return parser


def add_bounds(parser):
    """When it is over."""
    parser.add_argument("--faults", type=whole_number("--faults", 1), metavar="N",
                        help="at least so many (30; with --duration as many as there is time for)")
    parser.add_argument("--duration", type=duration("--duration"), default=math.inf, metavar="T",
                        help="ends after the episode in which this is over: 90s, 10min")
    parser.add_argument("--quiet", type=duration("--quiet"), metavar="T", help="no faults: for so long nothing may be told")
    parser.add_argument("--findings", type=whole_number("--findings", 1), default=1, metavar="N", help="how many end it (1)")


def add_choices(parser):
    """What happens to whom."""
    parser.add_argument("--seed", type=whole_number("--seed", 0), default=1, metavar="S", help="of what happens to whom (1)")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=KINDS, metavar="KIND",
                        help=f"of these kinds ({', '.join(KINDS)})")
    parser.add_argument("--alone", action="store_true", help="one fault at a time, that lasts long enough to be told")
    parser.add_argument("--of", nargs="+", default=[""], metavar="NAME",
                        help="whose processes are killed and stopped: names begin so; of each in turn (driver planner …)")
    parser.add_argument("--no-standbys", action="store_true", help="without standbys, also those of the cell file")


def parse(words, description):
    """Ends the program with code 2 where the words are no command; raises BadInput."""
    options = parser_of(description).parse_args(words)
    if options.faults is None:
        options.faults = 30 if options.duration == math.inf else math.inf
    if options.report and (options.report.is_dir() or not options.report.parent.is_dir()):
        raise BadInput(f"--report = '{options.report}' must be a file in a folder that exists")
    return options


class CommandLineTest(unittest.TestCase):
    def parse(self, *words):
        return parse([*words, "--programs", "bin", "cell.yaml"], "")

    def test_a_run_ends_after_faults_or_a_duration(self):
        self.assertEqual((self.parse().faults, self.parse().duration), (30, math.inf))
        for words, faults in (("--duration", "10min"), math.inf), (("--faults", "7", "--duration", "10min"), 7):
            self.assertEqual((self.parse(*words).faults, self.parse(*words).duration), (faults, 600.0))

    def test_a_value_that_cannot_be_is_bad_input(self):
        for words in (("--duration", "90"), ("--duration", "0s"), ("--quiet", "30"), ("--faults", "0"),
                      ("--faults", "-1"), ("--faults", "many"), ("--seed", "1.5"), ("--findings", "0"),
                      ("--report", "/no/such/folder/report"), ("--report", "/")):
            with self.assertRaisesRegex(BadInput, f"^{words[0]} = '{words[1]}' must be ", msg=words):
                self.parse(*words)

    def test_what_is_no_command_is_a_usage_error(self):
        for words in ("--minutes", "3"), ("--only", "flood"), ("-o", "xml"), ("another.yaml",), ("--dur", "3s"):
            with self.assertRaises(SystemExit) as ended, contextlib.redirect_stderr(io.StringIO()):
                self.parse(*words)
            self.assertEqual(ended.exception.code, 2, words)


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
