"""Stalls of the machine during a test: a failure during a stall says nothing about Hecaton.

usage: steadiness.py --self-test"""
import os
import sys
import threading
import time
import unittest

REPORTED_WITHIN = 500  # [ms] until a stall of a process is known, by its next heartbeat and the next status
STALL = 0.12  # [s] timer lateness that counts as a stall of the machine
UNSTEADY = 75  # exit code: failed during a stall of the machine; repeat the run
UNSAFE = 70  # exit code: contact, or an arm that followed an older command; do not repeat


def unix_ms():
    return time.time_ns() // 1_000_000


def between(since, until, at, late):
    """True if a stall of `late` ms that ended at `at` overlaps this interval [ms, wall clock]."""
    return at > since and at - late <= until


class TimerLateness:
    """Lateness of a timer of 1 ms on this machine, a lower bound of all detection times."""

    def __init__(self, stall=STALL):
        self.late = []  # [ms]
        self._stall = stall  # [s]
        self.stalls = []  # (end of a stall [ms, wall clock], lateness [ms])
        self._over = False
        threading.Thread(target=self._measure, daemon=True).start()

    def _measure(self):
        while not self._over:
            begin = time.monotonic()
            time.sleep(0.001)
            late = time.monotonic() - begin - 0.001
            self.late.append(late * 1e3)
            if late > self._stall:
                self.stalls.append((unix_ms(), late * 1e3))

    def wait_until_steady(self, quiet=15, limit=240):
        """Returns after `quiet` seconds without a stall of the machine, and after `limit` seconds at the latest."""
        began = time.monotonic()
        while time.monotonic() < began + limit:
            now = unix_ms()
            last = self.stalls[-1][0] if self.stalls else 0
            if min(now - last, 1e3 * (time.monotonic() - began)) >= 1e3 * quiet:
                return
            time.sleep(0.1)

    def end(self):
        """Ends the measurement; after that this program may delay its own thread."""
        self._over = True

    def stood_still(self, since, until, stall=STALL):
        """For so long [s], the stall that is kept at least, and for some of that between these instants [ms, wall clock]."""
        return any(late > 1e3 * stall and between(since, until, at, late) for at, late in self.stalls)


class NodeLateness:
    """Lateness of the cell's processes, from their heartbeats; they may get less processor time than this program."""

    def __init__(self):
        self.stalls = []  # (end [ms, wall clock], lateness [ms], node, host), as reported
        self._told = {}   # by node: process, and the largest of its last periods [ms]

    def hear(self, status):
        for entry in status["nodes"]:
            late = 1e-3 * entry["lateness_max_us"]
            told = self._told.get(entry["node"])
            # The first value of a process is the duration of its start.
            if told and told[0] == entry["pid"] and late > max(1e3 * STALL, told[1]):
                self.stalls.append((unix_ms(), late, entry["node"], entry["host"]))
            self._told[entry["node"]] = (entry["pid"], late)

    def of_others(self, disturbed):
        """Without hosts that a test has disturbed."""
        return [stall for stall in self.stalls if stall[-1] not in disturbed]

    def meanwhile(self, since, until, disturbed):
        """Of these, those that were between these instants [ms, wall clock]."""
        return [stall for stall in self.of_others(disturbed) if between(since, until + REPORTED_WITHIN, *stall[:2])]


def judge_failures(failed, stalls):
    """The exit code after failed tests: UNSTEADY only if the machine stalled during each of them. `failed`: (name, since, until
    [ms, wall clock]); `stalls`: (end [ms, wall clock], lateness [ms], node, host)."""
    code = UNSTEADY
    for name, since, until in failed:
        meanwhile = [stall for stall in stalls if between(since, until + REPORTED_WITHIN, *stall[:2])]
        if not meanwhile:
            print(f"{name} failed, without a stall of the machine", file=sys.stderr)
            code = 1
            continue
        _, late, what, where = max(meanwhile, key=lambda stall: stall[1])
        print(f"{name} failed, during {len(meanwhile)} stalls of the machine, at most {late:.0f} ms ({what} of "
              f"{where})", file=sys.stderr)
    return code


class SpannedResult(unittest.TextTestResult):
    """A test result that also records the time of each failed test."""

    def __init__(self, *arguments, **keywords):
        super().__init__(*arguments, **keywords)
        self.failed = []  # for judge_failures()
        self._since = unix_ms()

    def startTest(self, test):
        self._since = unix_ms()
        super().startTest(test)

    def stopTest(self, test):
        super().stopTest(test)
        self._since = unix_ms()  # what fails before the next one begins is what the tests of a class share

    def names_of_failed(self):
        """In their module: of tests, and of classes that failed in what their tests share."""
        names = {name.partition("(")[2].rstrip(")").partition(".")[2] for name, _, _ in self.failed}
        return sorted(name for name in names if name.rpartition(".")[0] not in names)

    def addError(self, test, err):
        super().addError(test, err)
        self.failed.append((str(test), self._since, unix_ms()))

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.failed.append((str(test), self._since, unix_ms()))


class NamesTest(unittest.TestCase):
    def test_failed_class_has_the_time_of_the_class(self):
        class Shared(unittest.TestCase):
            @classmethod
            def tearDownClass(cls):
                raise RuntimeError

            def test_a(self):
                self.fail()

        class Alone(unittest.TestCase):
            def test_b(self):
                self.fail()

            def test_c(self):
                pass

        with open(os.devnull, "w") as nowhere:
            result = unittest.TextTestRunner(nowhere, resultclass=SpannedResult).run(unittest.TestSuite(
                map(unittest.defaultTestLoader.loadTestsFromTestCase, (Shared, Alone))))
        local = "NamesTest.test_failed_class_has_the_time_of_the_class.<locals>."
        self.assertEqual(result.names_of_failed(), [local + "Alone.test_b", local + "Shared"])


class SteadyTest(unittest.TestCase):
    def test_waits_until_the_last_stall_is_long_over(self):
        lateness = TimerLateness(stall=1e9)
        lateness.stalls = [(unix_ms() + 300, 200.0)]
        lateness.wait_until_steady(quiet=0.2)
        self.assertGreaterEqual(unix_ms(), lateness.stalls[-1][0] + 200)

    def test_ends_at_the_limit(self):
        lateness = TimerLateness(stall=1e9)
        lateness.stalls = [(unix_ms() + 60_000, 200.0)]
        lateness.wait_until_steady(quiet=0.2, limit=0.3)
        self.assertLess(unix_ms(), lateness.stalls[-1][0])


class JudgementTest(unittest.TestCase):
    STALL = (5_000, 200.0, "a timer", "this machine")

    def test_stall_during_failure_is_unsteady(self):
        self.assertEqual(judge_failures([("one", 4_000, 6_000)], [self.STALL]), UNSTEADY)

    def test_stall_before_or_after_does_not_count(self):
        self.assertEqual(judge_failures([("one", 5_001, 9_000)], [self.STALL]), 1)
        self.assertEqual(judge_failures([("one", 1_000, 4_799 - REPORTED_WITHIN)], [self.STALL]), 1)

    def test_stall_does_not_count_for_other_tests(self):
        self.assertEqual(judge_failures([("one", 4_000, 6_000), ("other", 7_000, 8_000)], [self.STALL]), 1)

    def test_undisturbed_processes_count(self):
        heard = NodeLateness()
        heard.stalls = [(5_000, 200.0, "planner/a", "a-pc"), (5_000, 200.0, "planner/b", "b-pc"), (9_000, 200.0, "planner/a", "a-pc")]
        self.assertEqual(heard.meanwhile(4_000, 6_000, {"b-pc"}), heard.stalls[:1])
        self.assertEqual(heard.meanwhile(1_000, 4_799 - REPORTED_WITHIN, ()), [])

    def test_each_failure_has_the_time_of_its_own_test(self):
        spans = []

        class Failing(unittest.TestCase):
            def test_a(self):
                spans.append(unix_ms())
                self.fail()

            def test_b(self):
                time.sleep(0.01)

            def test_c(self):
                spans.append(unix_ms())
                raise RuntimeError

        with open(os.devnull, "w") as nowhere:
            result = unittest.TextTestRunner(nowhere, resultclass=SpannedResult).run(
                unittest.defaultTestLoader.loadTestsFromTestCase(Failing))
        self.assertEqual(len(result.failed), 2)
        for (_, since, until), at in zip(result.failed, spans):
            self.assertTrue(since <= at <= until)
        self.assertGreater(result.failed[1][1], result.failed[0][2])


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
