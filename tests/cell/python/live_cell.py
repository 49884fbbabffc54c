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
signal.signal(signal.SIGINT, signal.default_int_handler)  # else programs of a shell's background job ignore it, too


def still_cell(folder):
    """A copy of three_puma in `folder` without its moving obstacles: on a machine that stands still, they touch the arms."""
    text = THREE_PUMA.read_text()
    before, obstacles = text.split("\nobstacles:\n")
    post = obstacles[obstacles.index("  - name: post"):]
    file = pathlib.Path(folder) / "three_puma.yaml"
    file.write_text(before.replace("urdf: urdf/", f"urdf: {CELLS}/urdf/") + "\nobstacles:\n" + post)
    return file


SLIDES = """<robot name="slides">
<link name="base"><collision><origin xyz="0 0 1.5"/><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link>
<link name="across"><collision><origin xyz="0 0 1.4"/><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link>
<link name="along"><collision><origin xyz="0 0 1.3"/><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link>
<link name="hand"><collision><geometry><box size="0.06 0.24 0.04"/></geometry></collision></link>
<link name="left"><collision><origin xyz="0 0.005 -0.06"/><geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
<link name="right"><collision><origin xyz="0 -0.005 -0.06"/><geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="across"/><axis xyz="1 0 0"/>
<limit effort="1" velocity="0.5" lower="-0.5" upper="0.5"/></joint>
<joint name="y" type="prismatic"><parent link="across"/><child link="along"/><axis xyz="0 1 0"/>
<limit effort="1" velocity="0.5" lower="-0.5" upper="0.5"/></joint>
<joint name="z" type="prismatic"><parent link="along"/><child link="hand"/><axis xyz="0 0 1"/>
<limit effort="1" velocity="0.5" lower="0.2" upper="0.9"/></joint>
<joint name="grip" type="prismatic"><parent link="hand"/><child link="left"/><axis xyz="0 1 0"/>
<limit effort="1" velocity="0.5" lower="0" upper="0.05"/></joint>
<joint name="other" type="prismatic"><parent link="hand"/><child link="right"/><axis xyz="0 -1 0"/>
<limit effort="1" velocity="0.5" lower="0" upper="0.05"/><mimic joint="grip"/></joint></robot>
"""
GRIPPER_CELL = """name: grippers
defaults:
  urdf: slides.urdf
  tool_link: hand
  tool: {xyz: [0, 0, -0.08]}
  joints: {grip: [0, 0.05]}
  limits: {velocity: 0.4, acceleration: 4}
  damper: {security_distance: 0.004, influence_distance: 0.02}
  poses: {home: [0, 0, 0.7], crate: [0.3, 0, 0.38]}
arms:
  - name: north
    gripper: {joint: grip, closed: 0, opened: 0.05, width: 0.1, speed: 0.1}
    signals: {part: digital_input, lamp: digital_output, pressure: analog_input 1}
  - {name: south, base: {xyz: [0, -1.2, 0]}}
obstacles:
  - name: crate
    shapes: [{type: box, size: [0.04, 0.04, 0.04]}]
    pose: {xyz: [0.3, 0, 0.3]}
"""


def gripper_cell(folder):
    """The cell of tests/support/gripper_cell.hpp: two arms on slides, one with a gripper."""
    (pathlib.Path(folder) / "slides.urdf").write_text(SLIDES)
    file = pathlib.Path(folder) / "gripper.yaml"
    file.write_text(GRIPPER_CELL)
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
    def cell_file(cls, folder):
        return still_cell(folder)

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.file = cls.cell_file(folder.name)
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
