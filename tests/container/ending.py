"""Signals that end a test program: the first SIGTERM or SIGINT ends it after cleaning up, the second at once.

usage: ending.py --self-test"""
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest

NUMBERS = (signal.SIGTERM, signal.SIGINT)
# [s] a second signal within this time counts as the first: `timeout` signals the program and then its group.
ECHO = 1.0


def exit_code(number):
    """Exit code for a program that a signal ended, as in shells."""
    return 128 + number


def hear(handler):
    """Installs a handler unless the signal is ignored, as shells ignore SIGINT for background programs."""
    for number in NUMBERS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, handler)


class Ending:
    """Handles the signals from now on. `at_first` is called with the first one, and may raise."""

    def __init__(self, at_first=lambda number: None):
        self.received = None  # the signal
        self._at_first = at_first
        self._told_at = 0.0
        hear(self._hear)

    def _hear(self, number, _frame):
        if self.received is None:
            self.received = number
            self._told_at = time.monotonic()
            self._at_first(number)
        elif time.monotonic() - self._told_at > ECHO:
            os._exit(exit_code(number))  # as the first process of its namespace it ends all others


class Messenger:
    """Forwards the signals of this program to one that it starts, through a pipe, in which early signals wait. The other program has
    its own session, so that a signal to this program's group does not reach its processes."""

    def __init__(self):
        self.ear, self._mouth = os.pipe()  # the other program inherits `ear`
        os.set_blocking(self._mouth, False)
        hear(self._pass_on)

    def _pass_on(self, number, _frame):
        try:
            os.write(self._mouth, bytes([number]))
        except OSError:
            pass  # it has ended, or many signals are waiting already

    def start(self, words, environment):
        return subprocess.Popen(words, env=environment, pass_fds=(self.ear,), start_new_session=True)


def hear_messenger(ear):
    """In the other program: handles the signals of the first program from now on."""
    def listen():
        while number := os.read(ear, 1):
            signal.pthread_kill(threading.main_thread().ident, number[0])
    threading.Thread(target=listen, daemon=True).start()


class EndingTest(unittest.TestCase):
    OTHER = """
        import ending, sys, time
        ends = ending.Ending()
        print("hears", flush=True)
        while not ends.received:
            time.sleep(0.01)
        print("received", int(ends.received), flush=True)
        time.sleep(30 if "--slow" in sys.argv else 0)
    """
    FIRST = """
        import ending, os, signal, sys, time
        messenger = ending.Messenger()
        os.kill(os.getpid(), signal.SIGTERM)  # before the other program exists
        other = messenger.start([sys.executable, "-c", sys.argv[1], str(messenger.ear)], dict(os.environ))
        sys.exit(other.wait())
    """
    SECOND = """
        import ending, os, sys, time
        time.sleep(0.2)
        ends = ending.Ending()
        ending.hear_messenger(int(sys.argv[1]))
        while not ends.received:
            time.sleep(0.01)
        print("received", int(ends.received), os.getsid(0) == os.getpid(), flush=True)
    """

    def start(self, text, *words, **keywords):
        return subprocess.Popen([sys.executable, "-c", textwrap.dedent(text), *words], stdout=subprocess.PIPE, text=True,
                                cwd=os.path.dirname(os.path.abspath(__file__)), **keywords)

    def test_first_signal_does_not_end_the_program(self):
        for number in NUMBERS:
            with self.start(self.OTHER) as other:
                other.stdout.readline()
                other.send_signal(number)
                self.assertEqual(other.communicate()[0], f"received {int(number)}\n")
                self.assertEqual(other.returncode, 0)

    def test_repeated_signal_counts_once_and_second_one_ends(self):
        with self.start(self.OTHER, "--slow") as other:
            other.stdout.readline()
            other.send_signal(signal.SIGTERM)
            other.stdout.readline()
            other.send_signal(signal.SIGTERM)
            time.sleep(ECHO + 0.1)
            self.assertIsNone(other.poll())
            other.send_signal(signal.SIGINT)
            self.assertEqual(other.wait(timeout=10), exit_code(signal.SIGINT))

    def test_ignored_signal_stays_ignored(self):
        with self.start("import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n" + textwrap.dedent(self.OTHER)) as other:
            other.stdout.readline()
            other.send_signal(signal.SIGINT)
            other.send_signal(signal.SIGTERM)
            self.assertEqual(other.communicate()[0], f"received {int(signal.SIGTERM)}\n")

    def test_early_signal_waits_for_the_other_program(self):
        with self.start(self.FIRST, textwrap.dedent(self.SECOND)) as first:
            self.assertEqual(first.communicate(timeout=20)[0], f"received {int(signal.SIGTERM)} True\n")
            self.assertEqual(first.returncode, 0)


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
