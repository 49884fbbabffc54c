#!/usr/bin/env python3
"""The cost of hecaton-view: processor time and memory for N arms and M pages, and what it does to the ticks of planners.

usage: view_cost.py BIN [--arms 3,30] [--clients 1,10] [--seconds 20] [--pairs 10]

BIN is the folder of Hecaton's programs. hecaton-view is the real one. One process publishes the states of all arms every 2 ms.
Each page is a WebSocket that reads all messages; the last of several reads 20 kB/s only. Then the cell three_puma runs with
random goals, by turns without and with a view of ten such pages: the ticks' p99 is the median of what the three planners report.
"""
import argparse
import base64
import json
import os
import pathlib
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from cell_cost import ROOT, Cost, grid_cell, resident_megabytes, running

DOMAIN, PORT = 41, 8941
SLOW = 20e3  # [byte/s]
WINDOW = 6.0  # after a change, before ticks count: planners report their last 512 [s]


class Page(threading.Thread):
    """Reads what the server sends, without a look at it."""

    def __init__(self, slow):
        super().__init__(daemon=True)
        self.slow, self.bytes, self.left = slow, 0, False
        self.socket = socket.socket()
        if slow:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.connect(("127.0.0.1", PORT))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{PORT}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        answer = self.socket.recv(15)
        if not answer.startswith(b"HTTP/1.1 101"):
            raise SystemExit(f"view_cost: the view answers {answer!r}")

    def run(self):
        size = 2048 if self.slow else 1 << 16
        while not self.left:
            read = len(self.socket.recv(size))
            self.bytes += read
            if read == 0:
                return
            if self.slow:
                time.sleep(read / SLOW)

    def leave(self):
        self.left = True
        self.socket.shutdown(socket.SHUT_RDWR)
        self.join()
        self.socket.close()


def open_pages(count):
    pages = [Page(slow=count > 1 and i == count - 1) for i in range(count)]
    for page in pages:
        page.start()
    return pages


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
        pages = open_pages(clients)
        try:
            time.sleep(3.0)
            memory, read = resident_megabytes(view.pid), pages[0].bytes
            with Cost(view.pid) as cost:
                time.sleep(seconds)
            read = pages[0].bytes - read
            print(f"{arms:5} {clients:7} {100 * cost.share:8.1f} % {memory:7.1f} {resident_megabytes(view.pid):7.1f} MB "
                  f"{read / cost.seconds / 1e3:8.0f} kB/s", flush=True)
        finally:
            for page in pages:
                page.leave()


def tick_p99(programs, cell, seconds):
    """Of all planners, the median of what they report meanwhile [µs]."""
    time.sleep(WINDOW)
    ticks = []
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        answer = subprocess.run([programs / "hecaton", "--cell", cell, "--domain", str(DOMAIN), "-o", "json", "status"],
                                capture_output=True, text=True, check=True)
        nodes = [node for node in json.loads(answer.stdout)["nodes"] if node["kind"] == "planner"]
        ticks += [node["tick_us"]["p99"] for node in nodes]
        time.sleep(0.5)
    return statistics.median(ticks)


def compare_ticks(programs, pairs, seconds, folder):
    cell = ROOT / "deploy/cells/three_puma.yaml"
    path = folder / "up.log"
    without, with_view = [], []
    with open(path, "w") as log, running(log, programs / "hecaton", "up", cell, "--headless", "--tasks", 1000000,
                                         "--domain", DOMAIN, stdout=log) as up:
        await_line(path, "the cell is up", up)
        for _ in range(pairs):
            without.append(tick_p99(programs, cell, seconds))
            viewed = folder / "view.log"
            with open(viewed, "w") as view_log, running(view_log, programs / "hecaton", "view", cell, "--domain", DOMAIN,
                                                        "--port", PORT, stdout=view_log) as view:
                await_line(viewed, "http://", view)
                pages = open_pages(10)
                with_view.append(tick_p99(programs, cell, seconds))
                for page in pages:
                    page.leave()
            print(f"tick p99 without {without[-1]:6.0f} µs, with a view {with_view[-1]:6.0f} µs", flush=True)
    differences = [b - a for a, b in zip(without, with_view)]
    spread = statistics.stdev(differences) / len(differences) ** 0.5 if len(differences) > 1 else float("nan")
    print(f"median {statistics.median(without):.0f} and {statistics.median(with_view):.0f} µs; "
          f"difference {statistics.mean(differences):.1f} ± {spread:.1f} µs (standard error of {pairs} pairs)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default="3,30")
    parser.add_argument("--clients", default="1,10")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--pairs", type=int, default=10)
    options = parser.parse_args()
    programs = options.programs.resolve()
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as name:
        folder = pathlib.Path(name)
        print(f"{'arms':>5} {'pages':>7} {'processor':>10} {'memory at begin, end':>21} {'to a page':>10}")
        for arms in options.arms.split(","):
            for clients in options.clients.split(","):
                measure(programs, int(arms), int(clients), options.seconds, folder)
        if options.pairs > 0:
            compare_ticks(programs, options.pairs, min(options.seconds, 6.0), folder)


if __name__ == "__main__":
    main()
