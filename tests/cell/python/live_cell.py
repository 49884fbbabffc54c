"""A cell that runs under `hecaton up` during a test, in a DDS domain that no other test uses."""

import atexit
import fcntl
import os
import pathlib
import random
import signal
import subprocess
import tempfile
import threading
import unittest

import hecaton

BIN = pathlib.Path(os.environ["HECATON_BIN"])
SOURCE = pathlib.Path(os.environ["HECATON_SOURCE"])
CELLS = pathlib.Path(os.environ["HECATON_CELLS"])
THREE_PUMA = CELLS / "three_puma.yaml"
FIRST, COUNT = 44, 57  # as tests/support/free_domain.cpp


def still_cell(folder):
    """A copy of three_puma in `folder` without its moving obstacles: on a machine that stands still, they touch the arms."""
    text = THREE_PUMA.read_text()
    before, obstacles = text.split("\nobstacles:\n")
    post = obstacles[obstacles.index("  - name: post"):]
    file = pathlib.Path(folder) / "three_puma.yaml"
    file.write_text(before.replace("urdf: urdf/", f"urdf: {CELLS}/urdf/") + "\nobstacles:\n" + post)
    return file


class Domain:
    """Locks a DDS domain until close()."""

    def __init__(self):
        begin = random.randrange(COUNT)
        for i in range(COUNT):
            self.number = FIRST + (begin + i) % COUNT
            path = pathlib.Path(tempfile.gettempdir()) / f"hecaton-domain-{self.number}.lock"
            self._lock = os.open(path, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o666)
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except BlockingIOError:
                os.close(self._lock)
        raise RuntimeError("no DDS domain from 44 to 100 is free")

    def close(self):
        os.close(self._lock)


class Up:
    """`hecaton up` of a cell file, from its start until close()."""

    def __init__(self, cell_file, domain):
        self.domain = domain
        self._process = subprocess.Popen(
            [BIN / "hecaton", "up", cell_file, "--headless", "--domain", str(domain), "--start-timeout", "100s"],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        atexit.register(self.close)  # also when Ctrl-C ends the tests
        self.log = []
        self._up = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._up.wait()
        if self._process.poll() is not None:
            raise RuntimeError("the cell did not start:\n" + "".join(self.log))

    def _read(self):
        for line in self._process.stderr:
            self.log.append(line)
            if "the cell is up" in line:
                self._up.set()
        self._process.wait()
        self._up.set()

    def close(self):
        """Ends the cell and returns its exit code."""
        atexit.unregister(self.close)
        self._process.send_signal(signal.SIGINT)
        code = self._process.wait(60)
        self._reader.join()
        self._process.stderr.close()
        return code


class LiveCell(unittest.TestCase):
    """One running cell and one connection for all tests of a class."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.file = still_cell(folder.name)
        cls.domain = Domain()
        cls.addClassCleanup(cls.domain.close)
        cls.up = Up(cls.file, cls.domain.number)
        cls.addClassCleanup(cls.up.close)
        cls.cell = hecaton.connect(cls.file, domain=cls.domain.number, timeout=60)
        cls.addClassCleanup(cls.cell.close)

    def move(self, poses, timeout=120):
        """Moves arms to named poses and waits for them."""
        goals = [self.cell.arm(arm).go_to(pose) for arm, pose in poses.items()]
        self.cell.wait_all(goals, timeout)

    def home(self):
        self.move({"north": "home", "west": "home", "east": "home"})
