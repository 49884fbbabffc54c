"""Measurements of a run from the logs, and the format of figures.

usage: figures.py LOG…         figures of the logs of a cell's hosts
       figures.py --self-test"""
import collections
import datetime
import re
import statistics
import sys
import unittest


def quantiles(values):
    """For the report; None without values."""
    ordered = sorted(values)
    if not ordered:
        return None
    p99 = ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))]
    return {"n": len(ordered), "p50": statistics.median(ordered), "p99": p99, "max": ordered[-1]}


def figures(values, unit="ms"):
    """p50, p99 and maximum as text."""
    told = quantiles(values)
    return f"{told['p50']:8.1f} {told['p99']:8.1f} {told['max']:8.1f} {unit}" if told else f"{'–':>34}"


# Texts of the summary, by key of the report; all in ms.
LOG_FIGURES = {
    "standby_gap_ms": ("commands of a standby", "after the last of its predecessor"),
    "arm_stop_ms": ("moving arms stood", "after their last command, where commands ceased"),
    "arm_braking_ms": ("moving arms stood", "after they began to brake, for whatever reason"),
    "all_nodes_heard_ms": ("all nodes heard", "after the first message to a supervisor"),
    "all_nodes_heard_after_matching_ms": ("the same", "after matching all nodes"),
}
# Values that one log line contains.
PATTERNS = {
    "standby_gap_ms": r'event="planner changed" (?!.* instead_of="").*gap_ms=([0-9.e+]+)',
    "all_nodes_heard_ms": r"all nodes heard.* after_ms=([0-9]+)",
    "all_nodes_heard_after_matching_ms": r"all nodes heard.*after_matching_ms=([0-9]+)",
}
MODE = re.compile(r'time=(\S+) .* node=(driver/\S+) event="arm mode" mode=(\w+) reason="(.*)" command_age_ms=([0-9.e+-]+)')
CLOCK_SET = 5.0  # [s] longer braking means that the host's clock was set


def arm_stops(lines):
    """(key, ms) of each arm that braked to rest. An arm at rest only changes its mode when it is held."""
    braking = {}  # by driver: start
    for line in lines:
        told = MODE.search(line)
        if not told:
            continue
        at, driver, mode, reason, age = told.groups()
        at = datetime.datetime.fromisoformat(at)
        began = braking.pop(driver, None)
        if mode == "braking":
            braking[driver] = at
        elif mode == "stopped" and began:
            took = (at - began).total_seconds()
            if 0.0 <= took < CLOCK_SET:
                yield "arm_braking_ms", 1000 * took
            if reason.startswith("commands ceased"):
                yield "arm_stop_ms", float(age)


def log_figures(lines):
    """Values by the keys of LOG_FIGURES."""
    lines = list(lines)
    values = {key: [] for key in LOG_FIGURES}
    for key, pattern in PATTERNS.items():
        values[key] += [float(value) for line in lines for value in re.findall(pattern, line)]
    for key, value in arm_stops(lines):
        values[key].append(value)
    return values


def described(values_by_key):
    """Lines of the summary."""
    for key, values in values_by_key.items():
        what, since = LOG_FIGURES[key]
        yield f"{what:22} {len(values):5} {figures(values)} {since}"


class FiguresByFault:
    """The same by kind of single faults, so that a stopped driver's delays do not count for a standby."""

    def __init__(self):
        self._lines = []  # of the present episode
        self._values = collections.defaultdict(lambda: collections.defaultdict(list))

    def hear(self, line):
        self._lines.append(line)

    def end_episode(self, kind):
        """`kind`: of the only fault of the episode; None: several faults, or none."""
        lines, self._lines = self._lines, []
        for key, values in log_figures(lines).items():
            if kind and values:
                self._values[kind][key] += values

    def report(self):
        return {kind: {key: quantiles(values) for key, values in sorted(by_key.items())}
                for kind, by_key in sorted(self._values.items())}

    def summary(self):
        for kind, by_key in sorted(self._values.items()):
            yield from (f"{kind:22} {line}" for line in described(dict(sorted(by_key.items()))))


def mode(which, at, age, reason="commands ceased: none for more than 50 ms", arm="west"):
    """A log line of a driver."""
    return (f'time=2026-01-31T12:00:{at:06.3f}Z level=info node=driver/{arm} event="arm mode" mode={which} '
            f'reason="{reason}" command_age_ms={age}\n')


class ArmStopsTest(unittest.TestCase):
    def test_moving_arm_is_timed_from_last_command_and_from_start_of_braking(self):
        self.assertEqual(list(arm_stops([mode("braking", 1.0, 52), mode("stopped", 1.25, 302)])),
                         [("arm_braking_ms", 250.0), ("arm_stop_ms", 302.0)])

    def test_held_arm_still_has_commands(self):
        held = "the arm is held: by people"
        self.assertEqual(list(arm_stops([mode("braking", 1.0, 4, held), mode("stopped", 1.1, 2, held)])), [("arm_braking_ms", 100.0)])

    def test_resting_or_continuing_arm_is_not_timed(self):
        self.assertEqual(list(arm_stops([mode("stopped", 1.0, 54), mode("running", 2.0, 2, ""), mode("braking", 3.0, 52),
                                         mode("running", 3.1, 2, ""), mode("stopped", 4.0, 54)])), [])

    def test_arms_are_timed_separately_and_not_across_a_clock_change(self):
        self.assertEqual(list(arm_stops([mode("braking", 1.0, 52), mode("braking", 2.0, 52, arm="east"),
                                         mode("stopped", 2.5, 552, arm="east"), mode("stopped", 40.0, 200)])),
                         [("arm_braking_ms", 500.0), ("arm_stop_ms", 552.0), ("arm_stop_ms", 200.0)])


class FiguresByFaultTest(unittest.TestCase):
    def test_figures_are_of_single_faults(self):
        by_fault = FiguresByFault()
        for kind, ages in (None, (999.0,)), ("stop driver", (52.0, 58.0)), (None, (999.0,)), ("stop driver", (54.0,)), ("cut", ()):
            for age in ages:
                by_fault.hear(mode("braking", 1.0, 50))
                by_fault.hear(mode("stopped", 1.125, age))
            by_fault.end_episode(kind)
        self.assertEqual(by_fault.report(), {"stop driver": {"arm_braking_ms": {"n": 3, "p50": 125.0, "p99": 125.0, "max": 125.0},
                                                             "arm_stop_ms": {"n": 3, "p50": 54.0, "p99": 58.0, "max": 58.0}}})
        self.assertEqual(len(list(by_fault.summary())), 2)


def main():
    if sys.argv[1:] == ["--self-test"]:
        unittest.main(argv=sys.argv[:1])
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    values = collections.defaultdict(list)
    for name in sys.argv[1:]:
        with open(name, errors="replace") as log:
            for key, found in log_figures(log).items():
                values[key] += found
    print("\n".join(described(values)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
