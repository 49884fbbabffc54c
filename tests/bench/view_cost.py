#!/usr/bin/env python3
"""The cost of hecaton-view: processor time and memory for N arms and M pages, and what it does to the ticks of planners.

usage: view_cost.py BIN [--arms 3,30] [--clients 1,10] [--seconds 20] [--rounds 10] [--real-time]

BIN is the folder of Hecaton's programs. hecaton-view is the real one. One process publishes the states of all arms every 2 ms.
Each page is a WebSocket that reads all messages; the last of several reads 20 kB/s only. One process reads for all pages.

Then the cell three_puma runs with random goals. A round has three turns in a random order: without a view, and with a view of ten
pages, twice. In one of these turns their reader takes idle time only (SCHED_IDLE), as if the browsers were elsewhere. In the other it has
the priority of all other programs. The ticks' p99 is the median of what the three planners report in a turn. With --real-time
the loops of the cell have real-time priority (`timing: {real_time: true}`; root).
"""
import argparse
import base64
import contextlib
import json
import os
import pathlib
import random
import re
import selectors
import socket
import statistics
import subprocess
import sys
import tempfile
import time

from cell_cost import ROOT, Cost, grid_cell, resident_megabytes, running

DOMAIN, PORT = 41, 8941
SLOW = 20e3  # [byte/s]
WINDOW = 6.0  # after a change, before ticks count: planners report their last 512 [s]


class Page:
    """A WebSocket whose messages are read without a look at them."""

    def __init__(self, port, slow):
        self.slow, self.bytes, self.next = slow, 0, 0.0
        self.socket = socket.socket()
        if slow:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.connect(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        answer = self.socket.recv(15)
        if not answer.startswith(b"HTTP/1.1 101"):
            raise SystemExit(f"view_cost: the view answers {answer!r}")

    def read(self, now):
        if self.slow and now < self.next:
            return
        try:
            read = len(self.socket.recv(2048 if self.slow else 1 << 16, socket.MSG_DONTWAIT))
        except BlockingIOError:
            return
        self.bytes += read
        self.next = now + read / SLOW


def read_pages(port, count, idle):
    """The whole of the reading process, until its input ends. Prints what the first page got [byte], and for how long [s]."""
    if idle:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    pages = [Page(port, slow=count > 1 and i == count - 1) for i in range(count)]
    selector = selectors.DefaultSelector()
    selector.register(sys.stdin, selectors.EVENT_READ)
    for page in pages:
        if not page.slow:
            selector.register(page.socket, selectors.EVENT_READ, page)
    print("reads", flush=True)
    began = time.monotonic()
    while True:
        ready = selector.select(timeout=0.1)
        now = time.monotonic()
        if any(key.data is None for key, _ in ready):
            break
        for key, _ in ready:
            key.data.read(now)
        if pages[-1].slow:
            pages[-1].read(now)
    print(pages[0].bytes, time.monotonic() - began, flush=True)


@contextlib.contextmanager
def reading(count, idle=False):
    """A process that reads `count` pages within the block. `rate`, then: of the first page [byte/s]."""
    words = [sys.executable, __file__, "--read", str(PORT), str(count), *(["idle"] if idle else [])]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        try:
            yield process
        finally:
            process.stdin.close()
            size, seconds = process.stdout.read().split()
            process.rate = int(size) / float(seconds)


def await_line(path, pattern, process):
    until = time.monotonic() + 60.0
    while time.monotonic() < until and process.poll() is None:
        found = re.search(pattern, path.read_text())
        if found:
            return found
        time.sleep(0.05)
    raise SystemExit(f"view_cost: '{pattern}' did not come: {path.read_text()[-2000:]}")


def measure(programs, arms, clients, seconds, folder):
    cell = grid_cell(folder, arms, f"network: {{domain: {DOMAIN}, interface: 127.0.0.1}}\n")
    path = folder / f"{arms}-{clients}.log"
    with open(path, "w") as log, running(log, programs / "supervision-crowd", cell, stdout=log), running(
            log, programs / "hecaton", "view", cell, "--port", PORT, stdout=log) as view:
        await_line(path, "http://", view)
        with reading(clients) as pages:
            time.sleep(3.0)
            memory = resident_megabytes(view.pid)
            with Cost(view.pid) as cost:
                time.sleep(seconds)
            memory_after = resident_megabytes(view.pid)
        print(f"{arms:5} {clients:7} {100 * cost.share:8.1f} % {memory:7.1f} {memory_after:7.1f} MB {pages.rate / 1e3:8.0f} kB/s",
              flush=True)


class Ticks:
    """The p99 of the ticks that the planners report, from one program that asks the cell all the time."""

    def __init__(self, programs, cell, folder):
        self._output = open(folder / "status.json", "w+", encoding="utf-8")
        self._process = subprocess.Popen([programs / "hecaton", "--cell", cell, "--domain", str(DOMAIN), "-o", "json", "status",
                                          "--watch", "--interval", "500ms"], stdout=self._output)
        self._read = open(self._output.name, encoding="utf-8")

    def close(self):
        self._process.terminate()
        self._process.wait()

    def median(self, seconds):
        """Of all planners and statuses of that time [µs]."""
        time.sleep(WINDOW)
        self._read.seek(0, os.SEEK_END)
        time.sleep(seconds)
        text = self._read.read()
        statuses = text[text.find("\n") + 1:text.rfind("\n") + 1].splitlines()
        ticks = [node["tick_us"]["p99"] for status in map(json.loads, statuses) for node in status["nodes"]
                 if node["kind"] == "planner"]
        return statistics.median(ticks)


@contextlib.contextmanager
def viewed(programs, cell, folder):
    path = folder / "view.log"
    with open(path, "w") as log, running(log, programs / "hecaton", "view", cell, "--domain", DOMAIN, "--port", PORT,
                                         stdout=log) as view:
        await_line(path, "http://", view)
        yield


def real_time_cell(cell, folder):
    """A copy of the cell whose loops have real-time priority."""
    text = cell.read_text()
    copy = folder / cell.name
    copy.write_text(text.replace("urdf: ", f"urdf: {cell.parent}/").replace("timing:\n", "timing:\n  real_time: true\n"))
    return copy


def compare_ticks(programs, rounds, seconds, real_time, folder):
    cell = ROOT / "deploy/cells/three_puma.yaml"
    if real_time:
        cell = real_time_cell(cell, folder)
    path = folder / "up.log"
    taken = {"none": [], "idle": [], "normal": []}
    with open(path, "w") as log, running(log, programs / "hecaton", "up", cell, "--headless", "--tasks", 1000000,
                                         "--domain", DOMAIN, stdout=log) as up:
        await_line(path, "the cell is up", up)
        ticks = Ticks(programs, cell, folder)
        rng = random.Random(1)
        for _ in range(rounds):
            for turn in rng.sample(list(taken), len(taken)):
                with contextlib.ExitStack() as stack:
                    if turn != "none":
                        stack.enter_context(viewed(programs, cell, folder))
                        stack.enter_context(reading(10, idle=turn == "idle"))
                    taken[turn].append(ticks.median(seconds))
            print("tick p99 [µs] without a view {:.0f}, with ten pages that read in idle time {:.0f}, at all times {:.0f}".format(
                *(values[-1] for values in taken.values())), flush=True)
        ticks.close()
    for turn in ("idle", "normal"):
        differences = [b - a for a, b in zip(taken["none"], taken[turn])]
        spread = statistics.stdev(differences) / len(differences) ** 0.5 if len(differences) > 1 else float("nan")
        print(f"pages that read {'in idle time' if turn == 'idle' else 'at all times'}: median {statistics.median(taken['none']):.0f} "
              f"and {statistics.median(taken[turn]):.0f} µs; difference {statistics.mean(differences):.0f} ± {spread:.0f} µs "
              f"(standard error of {rounds} rounds)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default="3,30")
    parser.add_argument("--clients", default="1,10")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--real-time", action="store_true")
    options = parser.parse_args()
    programs = options.programs.resolve()
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as name:
        folder = pathlib.Path(name)
        print(f"{'arms':>5} {'pages':>7} {'processor':>10} {'memory at begin, end':>21} {'to a page':>10}")
        for arms in options.arms.split(","):
            for clients in options.clients.split(","):
                measure(programs, int(arms), int(clients), options.seconds, folder)
        if options.rounds > 0:
            compare_ticks(programs, options.rounds, min(options.seconds, 6.0), options.real_time, folder)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--read"]:
        read_pages(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:] == ["idle"])
    else:
        main()
