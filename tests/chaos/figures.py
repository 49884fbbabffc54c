"""What a run of chaos measures beside what the cell tells, and how figures are written."""
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


def log_figures(lines):
    """From the logs [ms]. From the drivers': how long a standby's first command came after the last of its predecessor; how long
    after its last command an arm was at rest. From the supervisors': how long after its first word from anybody one had heard
    from everybody."""
    lines = list(lines)
    gaps = [float(gap) for line in lines if "event=follows" in line and 'instead_of=""' not in line
            for gap in re.findall(r"gap_ms=([0-9.e+]+)", line)]
    rests = [float(age) for line in lines if "mode=stopped" in line and "commands ceased" in line
             for age in re.findall(r"command_age_ms=([0-9.e+]+)", line)]
    acquainted = [float(after) for line in lines if "supervisor knows everybody" in line
                  for after in re.findall(r"after_ms=([0-9]+)", line)]
    return gaps, rests, acquainted
