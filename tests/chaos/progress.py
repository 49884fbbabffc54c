"""Progress of long work on a terminal: one line on stderr, rewritten in place; nothing on any other stream. As
services/command_line/long_work.hpp, which the C++ programs use.

usage: progress.py --self-test"""
import io
import os
import shutil
import sys
import time
import unittest

WIDTH = 30  # characters of the bar
QUIET_AT_FIRST = 0.5  # [s]


def duration_text(seconds):
    seconds = round(seconds)
    if seconds < 120:
        return f"{seconds} s"
    if seconds < 7200:
        return f"{seconds // 60} min {seconds % 60} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60} min"


class Progress:
    def __init__(self, stream=None, clock=time.monotonic):
        self._stream = stream or sys.stderr
        self._terminal = self._stream.isatty() and os.environ.get("TERM") != "dumb"
        self._clock = clock
        self._began = clock()
        self._visible = False

    def restart(self):
        """The work begins now."""
        self._began = self._clock()

    def show(self, what, done, whole, unit):
        """`done` of `whole` `unit` of the work `what`. The time left follows from the speed since the beginning."""
        spent = self._clock() - self._began
        if not self._terminal or spent < QUIET_AT_FIRST:
            return
        filled = int(WIDTH * min(1.0, done / whole))
        text = f"{what} [{'#' * filled:{WIDTH}}] {done:g} of {whole:g} {unit}"
        if done > 0:
            text += f", {duration_text(spent / done * max(0, whole - done))} left"
        columns = shutil.get_terminal_size().columns
        self._stream.write("\r" + text[:columns - 1] + "\x1b[K")
        self._stream.flush()
        self._visible = True

    def clear(self):
        """Before other output to the stream."""
        if self._visible:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
            self._visible = False


class Terminal(io.StringIO):
    def isatty(self):
        return True


class ProgressTest(unittest.TestCase):
    def setUp(self):
        self.now = 0.0

    def show(self, stream):
        progress = Progress(stream, lambda: self.now)
        progress.show("soak", 0, 60, "s")
        self.now = 10.0
        progress.show("soak", 10, 60, "s")
        return progress

    def test_terminal_gets_one_line_with_the_time_left(self):
        terminal = Terminal()
        self.show(terminal).clear()
        self.assertEqual(terminal.getvalue(), f"\rsoak [#####{' ' * 25}] 10 of 60 s, 50 s left\x1b[K\r\x1b[K")

    def test_other_streams_get_nothing(self):
        pipe = io.StringIO()
        self.show(pipe).clear()
        self.assertEqual(pipe.getvalue(), "")

    def test_duration_has_two_units(self):
        self.assertEqual([duration_text(s) for s in (4.4, 119, 125, 7260)], ["4 s", "119 s", "2 min 5 s", "2 h 1 min"])


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
