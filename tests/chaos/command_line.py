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
Data goes to stdout, messages to stderr. SIGTERM or SIGINT (Ctrl-C) ends the run after the present episode, with the findings so
far, and exit code 130 or 143 unless there is a finding; a second signal ends it at once. A signal to all processes, as systemd sends it unless
KillMode=mixed, also ends the cell.
Exit codes: 0 no finding; 1 a finding; 2 usage; 3 bad input, or a cell whose arms do not move back and forth without faults; 4 ended
before the first episode; 70 an unsafe finding: a contact, an arm that followed an older command, or a driver that lost its
checkpoint; 75 a finding while the machine stalled, or most episodes were discarded for that reason, so that nothing is known; 77
this machine does not support hosts (network namespaces); the reason is printed; 130 interrupted by Ctrl-C (SIGINT) or 143 by SIGTERM,
without a finding so far."""


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
    parser.add_argument("-o", "--output", choices=("table", "json", "yaml"), default="json", help="output format (json)")
    parser.add_argument("--report", type=pathlib.Path, metavar="FILE", help="also write the report to this file, as JSON")
    parser.add_argument("--record", type=pathlib.Path, metavar="FILE",
                        help="record the cell into this file (.mcap), for hecaton replay --verify and explain; an existing file stays")
    parser.add_argument("--second-record", type=pathlib.Path, metavar="FILE", help="also record it into this file, by another recorder")
    parser.add_argument("--logs", type=pathlib.Path, metavar="DIR", help="folder of the hosts' logs (a new one)")
    # Folder of Hecaton's programs; the launcher sets it.
    parser.add_argument("--programs", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    return parser


def add_bounds(parser):
    """Options that end the run."""
    parser.add_argument("--faults", type=whole_number("--faults", 1), metavar="N",
                        help="smallest number of faults (30; with --duration: no limit)")
    parser.add_argument("--duration", type=duration("--duration"), metavar="T",
                        help="end after the episode in which this time has passed: 90s, 10min")
    parser.add_argument("--calm", type=duration("--calm"), default=0.0, metavar="T",
                        help="let the arms work undisturbed for this time after each episode: 30s")
    parser.add_argument("--soak", type=duration("--soak"), metavar="T", help="inject nothing for this time; each reported fault is a finding")
    parser.add_argument("--findings", type=whole_number("--findings", 1), default=1, metavar="N", help="number of findings that ends the run (1)")


def add_choices(parser):
    """Options that select faults."""
    parser.add_argument("--seed", type=whole_number("--seed", 0), default=1, metavar="S", help="of the random faults (1)")
    parser.add_argument("--only", nargs="+", choices=KINDS, metavar="KIND",
                        help=f"only these kinds of fault ({', '.join(KINDS)})")
    parser.add_argument("--alone", action="store_true", help="one fault at a time, long enough to be reported")
    parser.add_argument("--of", nargs="+", metavar="NAME",
                        help="kill and stop only processes whose names begin with NAME, each NAME in turn (driver planner …). An agent "
                             "restarts a process that died ten times within 10 s of its start only once a minute")
    parser.add_argument("--timeout-scale", type=whole_number("--timeout-scale", 1), default=1, metavar="N",
                        help="factor of the cell's time-outs (1), for machines that stall")
    parser.add_argument("--no-standbys", action="store_true", help="without standbys, also without those of the cell file")
    parser.add_argument("--keys", action="store_true",
                        help="with keys: a new keystore in the folder of the logs has identities of all hosts")


def parse(words, description):
    """Exits with code 2 on a usage error; raises BadInput."""
    parser = parser_of(description)
    options = parser.parse_args(words)
    for name in ("faults", "duration", "only", "alone", "of"):  # have no meaning without faults
        if options.soak is not None and getattr(options, name):
            parser.error(f"argument --{name}: not allowed with argument --soak")
    if options.faults is None:
        options.faults = 30 if options.duration is None else math.inf
    options.duration = options.duration or math.inf
    options.only = options.only or KINDS
    options.of = options.of or [""]
    require_report(options.report)
    require_recording("--record", options.record)
    require_recording("--second-record", options.second_record)
    return options


def require_report(file):
    if not file:
        return
    if file.is_dir() or not file.parent.is_dir():
        raise BadInput(f"--report = '{file}' must be a file in a folder that exists")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise BadInput(f"--report = '{file}' must be a file that can be written")


def require_recording(name, file):
    if file and (file.suffix != ".mcap" or file.exists() or not file.parent.is_dir() or not os.access(file.parent, os.W_OK)):
        raise BadInput(f"{name} = '{file}' must be a new file that ends in .mcap, in a folder that can be written")


class CommandLineTest(unittest.TestCase):
    def parse(self, *words):
        return parse([*words, "--programs", "bin", "cell.yaml"], "")

    def test_run_ends_after_faults_or_duration(self):
        self.assertEqual((self.parse().faults, self.parse().duration), (30, math.inf))
        for words, faults in (("--duration", "10min"), math.inf), (("--faults", "7", "--duration", "10min"), 7):
            self.assertEqual((self.parse(*words).faults, self.parse(*words).duration), (faults, 600.0))

    def test_invalid_value_is_bad_input(self):
        for words in (("--duration", "90"), ("--duration", "0s"), ("--soak", "30"), ("--faults", "0"),
                      ("--faults", "-1"), ("--faults", "many"), ("--seed", "1.5"), ("--timeout-scale", "0"), ("--findings", "0"),
                      ("--report", "/no/such/folder/report"), ("--report", "/"), ("--record", "/no/such/folder/run.mcap"),
                      ("--record", "run.txt"), ("--second-record", "run.txt"), ("--calm", "20")):
            with self.assertRaisesRegex(BadInput, f"^{words[0]} = '{words[1]}' must be ", msg=words):
                self.parse(*words)

    def test_defaults_are_all_kinds_and_all_processes(self):
        options = self.parse()
        self.assertEqual((options.only, options.of, options.alone), (KINDS, [""], False))
        options = self.parse("--only", "kill", "cut", "--of", "driver")
        self.assertEqual((options.only, options.of), (["kill", "cut"], ["driver"]))

    def test_soak_accepts_no_options_of_faults(self):
        self.assertEqual(self.parse("--soak", "30s", "--findings", "2", "--no-standbys").soak, 30.0)

    def test_unknown_options_are_usage_errors(self):
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
