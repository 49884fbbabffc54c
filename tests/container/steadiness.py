"""Whether the machine ran while a test did: where it stood still, what the cell did says nothing of Hecaton."""
import threading
import time

STALL = 0.12  # [s] by which a timer is late where the machine itself stood still
UNSTEADY = 75  # exit code of a run that says nothing: it is to be repeated
UNSAFE = 70  # exit code of a run in which something was touched, or an arm followed an older command: never repeated


class TimerLateness:
    """How late this machine wakes a thread that asks for a millisecond: no detection can be more punctual."""

    def __init__(self):
        self.late = []  # [ms]
        self.stalls = []  # (until when a wake-up was later than STALL [ms, wall clock], by how much [ms])
        threading.Thread(target=self._measure, daemon=True).start()

    def _measure(self):
        while True:
            begin = time.monotonic()
            time.sleep(0.001)
            late = time.monotonic() - begin - 0.001
            self.late.append(late * 1e3)
            if late > STALL:
                self.stalls.append((time.time_ns() // 1_000_000, late * 1e3))

    def stood_still(self, since, until, stall=STALL):
        """For so long [s], STALL at least, and for some of that between these instants [ms, wall clock]."""
        return any(late > 1e3 * stall and at > since and at - late <= until for at, late in self.stalls)


class NodeLateness:
    """The same of the cell's own processes, as their heartbeats tell: they may get less of the machine than we do."""

    def __init__(self):
        self.stalls = []  # (host, node, ms), in the order in which they were told
        self._told = {}   # by node: process, and the largest of its last periods [ms]

    def hear(self, status):
        for entry in status["nodes"]:
            late = 1e-3 * entry["lateness_max_us"]
            told = self._told.get(entry["node"])
            # The first that a process tells of itself is how long it took to start.
            if told and told[0] == entry["pid"] and late > max(1e3 * STALL, told[1]):
                self.stalls.append((entry["host"], entry["node"], late))
            self._told[entry["node"]] = (entry["pid"], late)

    def of_others(self, disturbed):
        """Without the hosts that a test did something to."""
        return [stall for stall in self.stalls if stall[0] not in disturbed]
