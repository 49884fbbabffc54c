"""What a run of chaos measures beside what the cell tells, and how figures are written."""
import collections
import re
import statistics


def quantiles(values):
    """For the report; nothing without values."""
    ordered = sorted(values)
    if not ordered:
        return None
    p99 = ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))]
    return {"n": len(ordered), "p50": statistics.median(ordered), "p99": p99, "max": ordered[-1]}


def figures(values, unit="ms"):
    """p50, p99 and the largest."""
    told = quantiles(values)
    return f"{told['p50']:8.1f} {told['p99']:8.1f} {told['max']:8.1f} {unit}" if told else f"{'–':>34}"


# By key of the report: what a line of a log tells [ms] and how the summary puts it.
LOG_FIGURES = {
    "standby_gap_ms": (r'event=follows (?!.* instead_of="").*gap_ms=([0-9.e+]+)',
                       "commands of a standby", "after the last of its predecessor"),
    "arm_stop_ms": (r"mode=stopped .*commands ceased.*command_age_ms=([0-9.e+]+)",
                    "arms came to rest", "after their last command"),
    "supervisor_knew_everybody_ms": (r"supervisor knows everybody.* after_ms=([0-9]+)",
                                     "supervisors knew all", "after their first word from anybody"),
    "supervisor_knew_everybody_after_matching_ms": (r"supervisor knows everybody.*after_matching_ms=([0-9]+)",
                                                    "the same", "after it had matched everybody"),
}


def log_figures(lines):
    """Values by the keys of LOG_FIGURES."""
    lines = list(lines)
    return {key: [float(value) for line in lines for value in re.findall(pattern, line)]
            for key, (pattern, _, _) in LOG_FIGURES.items()}


class FiguresByFault:
    """The same by the kind of a fault that came alone: what a driver that stands still makes an arm wait is no standby's."""

    def __init__(self):
        self._lines = []  # of the episode
        self._values = collections.defaultdict(lambda: collections.defaultdict(list))

    def hear(self, line):
        self._lines.append(line)

    def end_episode(self, kind):
        """`kind`: of its only fault; None: there were several, or none."""
        lines, self._lines = self._lines, []
        for key, values in log_figures(lines).items():
            if kind and values:
                self._values[kind][key] += values

    def report(self):
        return {kind: {key: quantiles(values) for key, values in sorted(by_key.items())}
                for kind, by_key in sorted(self._values.items())}

    def summary(self):
        for kind, by_key in sorted(self._values.items()):
            for key, values in sorted(by_key.items()):
                _, what, since = LOG_FIGURES[key]
                yield f"{kind:22} {len(values):5} {figures(values)} {what} {since}"
