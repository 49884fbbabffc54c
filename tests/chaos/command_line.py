"""The command line of hecaton-chaos.

usage: command_line.py --self-test"""
import argparse
import contextlib
import io
import math
import os
import pathlib
import sys
import unittest

from bad_input import BadInput
from duration import UNITS, parse_duration
from injections import KINDS

EXIT_CODES = """\
Data goes to stdout, everything else to stderr. SIGTERM or SIGINT (Ctrl-C) ends a run after the episode under way, with what
it found so far; a second one ends it at once, with 143 or 130. Who sends it to all processes there are, as systemd does unless
KillMode=mixed, also ends the cell.
Exit codes: 0 all of it held; 1 it ran, and something did not; 2 usage; 3 bad input, also a cell whose arms do not go back and forth
when nothing is done to them; 4 it was ended before anything was tested; 70 what did not hold is unsafe: a contact, an older
command that an arm followed, or a driver that lost its memory; 75 something did not hold while the machine itself stood still,
or most episodes were discarded for that, which says nothing of Hecaton; 77 there can be no hosts here (network namespaces), why
is said."""


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
    parser.add_argument("--duration", type=duration("--duration"), metavar="T",
                        help="ends after the episode in which this is over: 90s, 10min")
    parser.add_argument("--soak", type=duration("--soak"), metavar="T", help="no faults: for so long nothing may be told")
    parser.add_argument("--findings", type=whole_number("--findings", 1), default=1, metavar="N", help="how many end it (1)")


def add_choices(parser):
    """What happens to whom."""
    parser.add_argument("--seed", type=whole_number("--seed", 0), default=1, metavar="S", help="of what happens to whom (1)")
    parser.add_argument("--only", nargs="+", choices=KINDS, metavar="KIND",
                        help=f"of these kinds ({', '.join(KINDS)})")
    parser.add_argument("--alone", action="store_true", help="one fault at a time, that lasts long enough to be told")
    parser.add_argument("--of", nargs="+", metavar="NAME",
                        help="whose processes are killed and stopped: names begin so; of each in turn (driver planner …), at "
                             "best more than 10 s apart: who dies sooner ten times in a row is only started every minute")
    parser.add_argument("--timeout-scale", type=whole_number("--timeout-scale", 1), default=1, metavar="N",
                        help="silence counts so many times later than the cell file says (1): for machines that stand still at times")
    parser.add_argument("--no-standbys", action="store_true", help="without standbys, also those of the cell file")


def parse(words, description):
    """Ends the program with code 2 where the words are no command; raises BadInput."""
    parser = parser_of(description)
    options = parser.parse_args(words)
    for name in ("faults", "duration", "only", "alone", "of"):  # by which nothing goes where there are no faults
        if options.soak is not None and getattr(options, name):
            parser.error(f"argument --{name}: not allowed with argument --soak")
    if options.faults is None:
        options.faults = 30 if options.duration is None else math.inf
    options.duration = options.duration or math.inf
    options.only = options.only or KINDS
    options.of = options.of or [""]
    require_report(options.report)
    return options


def require_report(file):
    if not file:
        return
    if file.is_dir() or not file.parent.is_dir():
        raise BadInput(f"--report = '{file}' must be a file in a folder that exists")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise BadInput(f"--report = '{file}' must be a file that can be written")


class CommandLineTest(unittest.TestCase):
    def parse(self, *words):
        return parse([*words, "--programs", "bin", "cell.yaml"], "")

    def test_a_run_ends_after_faults_or_a_duration(self):
        self.assertEqual((self.parse().faults, self.parse().duration), (30, math.inf))
        for words, faults in (("--duration", "10min"), math.inf), (("--faults", "7", "--duration", "10min"), 7):
            self.assertEqual((self.parse(*words).faults, self.parse(*words).duration), (faults, 600.0))

    def test_a_value_that_cannot_be_is_bad_input(self):
        for words in (("--duration", "90"), ("--duration", "0s"), ("--soak", "30"), ("--faults", "0"),
                      ("--faults", "-1"), ("--faults", "many"), ("--seed", "1.5"), ("--timeout-scale", "0"), ("--findings", "0"),
                      ("--report", "/no/such/folder/report"), ("--report", "/")):
            with self.assertRaisesRegex(BadInput, f"^{words[0]} = '{words[1]}' must be ", msg=words):
                self.parse(*words)

    def test_by_default_everything_happens_to_everybody(self):
        options = self.parse()
        self.assertEqual((options.only, options.of, options.alone), (KINDS, [""], False))
        options = self.parse("--only", "kill", "cut", "--of", "driver")
        self.assertEqual((options.only, options.of), (["kill", "cut"], ["driver"]))

    def test_a_soak_run_has_no_faults_to_choose(self):
        self.assertEqual(self.parse("--soak", "30s", "--findings", "2", "--no-standbys").soak, 30.0)

    def test_what_is_no_command_is_a_usage_error(self):
        for words in (("--minutes", "3"), ("--only", "flood"), ("-o", "xml"), ("another.yaml",), ("--dur", "3s"),
                      ("--soak", "3s", "--duration", "3s"), ("--soak", "3s", "--faults", "3"),
                      ("--soak", "3s", "--only", "kill"), ("--soak", "3s", "--alone"), ("--soak", "3s", "--of", "driver")):
            with self.assertRaises(SystemExit) as ended, contextlib.redirect_stderr(io.StringIO()):
                self.parse(*words)
            self.assertEqual(ended.exception.code, 2, words)


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
