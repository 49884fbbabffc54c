#!/usr/bin/env python3
"""What a driver costs, and how late its set-points are, for each device: one arm moves back and forth, moved by a simulated controller.

usage: device_cost.py BIN [--devices simulated,universal_robots,…] [--seconds 20] [--period 2ms] [--load N]

BIN is the folder of Hecaton's programs. In each period of its loop (--period) a driver sends one set-point, or as many as the interface of
its device wants. Columns:
  planner → driver   from the end of a planner's tick (the command is written) until the driver sends a set-point of it to the device;
                     from a recording
  between set-points on the socket, by the kernel's time-stamps; of UDP and TCP devices, as root. A device of DDS has `–`
  processor          of the driver, in per cent of a core, while the arm moves
--load N: so many processes compute meanwhile."""
import argparse
import csv
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

import yaml

TESTS = pathlib.Path(__file__).resolve().parents[1]
DOMAIN, ROS_DOMAIN = 49, 50
PATIENCE = 60.0  # [s]
ORDERS = 30999  # TCP port of a controller
SO_TIMESTAMPNS = 35
SET_POINT_OF_UR = 60  # bytes: 15 int32 (services/arm_driver/devices/universal_robots/program.hpp)


class Device:
    """A device with its simulated controller."""

    robot, address, begin = "ur5e", None, []
    device = {"type": "simulated"}

    def __init__(self, programs):
        self.programs = programs

    def command(self, home, names):
        """Of the controller; None: there is none."""

    def is_set_point(self, packet):
        """An IPv4 packet on the loopback interface."""
        return False


class UniversalRobots(Device):
    address = "127.0.0.21"
    device = {"type": "universal_robots", "robot_ip": address}
    begin = ["hecaton device arm on"]

    def command(self, home, names):
        return [sys.executable, TESTS / "robots" / "ur_controller.py", "--address", self.address, "--start=" + ",".join(f"{q:.6f}" for q in home)]

    def is_set_point(self, packet):
        header = 4 * (packet[0] & 15)
        size = struct.unpack_from("!H", packet, 2)[0] - header - 4 * (packet[header + 12] >> 4)
        return packet[9] == socket.IPPROTO_TCP and packet[16:20] == socket.inet_aton(self.address) and size == SET_POINT_OF_UR


class AbbEgm(Device):
    robot, address = "irb120", "127.0.0.22"
    device = {"type": "abb_egm", "port": 6590, "robot_ip": address}

    def command(self, home, names):
        degrees = ",".join(f"{q * 57.29577951308232:.4f}" for q in home)
        return [sys.executable, TESTS / "robots" / "abb_controller.py", "--to", "127.0.0.1:6590", "--address", self.address, "--start=" + degrees]

    def is_set_point(self, packet):
        return packet[9] == socket.IPPROTO_UDP and packet[16:20] == socket.inet_aton(self.address)


class Ros2Control(Device):
    robot, address, interface = "panda", "127.0.0.23", "trajectory"

    def __init__(self, programs):
        super().__init__(programs)
        self.device = {"type": "ros2_control", "domain": ROS_DOMAIN, "interface": self.interface, "controller": "a_controller"}

    def command(self, home, names):
        return [self.programs / "ros2_controller", "--domain", str(ROS_DOMAIN), "--controller", "a_controller", "--kind", self.interface,
                "--address", self.address, "--from-desired", "--joints", ",".join(names), "--start", ",".join(f"{q:.6f}" for q in home)]


class Ros2Action(Ros2Control):
    interface = "action"


class Ros2Position(Ros2Control):
    interface = "position"


class Program(Device):
    robot = "irb120"
    device = {"type": "program"}

    def command(self, home, names):
        return [self.programs / "simulated_joints", str(DOMAIN), "device_cost", "arm", *[f"{q:.6f}" for q in home]]


DEVICES = {"simulated": Device, "universal_robots": UniversalRobots, "abb_egm": AbbEgm,
           "ros2_control trajectory": Ros2Control, "ros2_control action": Ros2Action, "ros2_control position": Ros2Position,
           "program": Program}


class Capture(threading.Thread):
    """Kernel time-stamps of the packets that a device sends."""

    def __init__(self, device):
        super().__init__(daemon=True)
        self._device, self.times, self._done = device, [], False
        self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
        self._socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
        self._socket.bind(("lo", 0x0800))
        self._socket.settimeout(0.1)
        self.start()

    def run(self):
        while not self._done:
            try:
                packet, extra, _, sender = self._socket.recvmsg(2048, 256)
            except TimeoutError:
                continue
            if sender[2] != socket.PACKET_HOST or len(packet) < 40 or not self._device.is_set_point(packet):
                continue  # the kernel shows what goes out to taps of all protocols only
            for _, kind, data in extra:
                if kind == SO_TIMESTAMPNS:
                    seconds, nanoseconds = struct.unpack("qq", data[:16])
                    self.times.append(seconds + 1e-9 * nanoseconds)

    def stop(self):
        self._done = True
        self.join()
        self._socket.close()


def quantiles(values, unit=1e3):
    if not values:
        return "–"
    values = sorted(unit * value for value in values)
    at = lambda share: values[min(len(values) - 1, int(share * len(values)))]
    return f"{at(0.5):.2f}, {at(0.99):.2f}, {values[-1]:.2f}"


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def rows(folder, topic):
    with open(folder / f"{topic}.csv", newline="") as text:
        yield from csv.DictReader(text)


def latencies(folder):
    """From each written command until the driver applies it [s]."""
    written = {int(row["sequence_number"]): int(row["publish_time_ns"]) for row in rows(folder, "ArmCommand")}
    found, seen = [], set()
    for row in rows(folder, "ArmState"):
        number = int(row["command_sequence_number"])
        if number in written and number not in seen:
            seen.add(number)
            found.append(1e-9 * (int(row["publish_time_ns"]) - written[number]) - float(row["command_age"]))
    return found


class Cell:
    def __init__(self, device, options, folder):
        self.device, self.options, self.folder = device, options, folder
        self.programs, self.processes = options.programs, []
        self.file = folder / "cell.yaml"
        document = {"name": "device_cost", "network": {"domain": DOMAIN, "interface": "127.0.0.1"},
                    "timing": {"driver_period": options.period, "command_timeout": "500ms"},
                    "supervision": {"heartbeat_deadline": "250ms", "host_lease": "1s"},
                    "arms": [{"name": "arm", "robot": device.robot, "device": device.device}]}
        self.file.write_text(yaml.safe_dump(document))
        arm = json.loads(self.hecaton("check", self.file, "-o", "json"))["arms"][0]
        home, joints = arm["named"]["home"], arm["model"]["joints"]
        document["arms"][0]["poses"] = {"home": home, "far": [home[0] + 0.8, *home[1:]]}
        self.file.write_text(yaml.safe_dump(document))
        command = device.command(home, [joint["name"] for joint in joints])
        if command:
            self.start(command, stdin=subprocess.PIPE)
        self.start([self.programs / "hecaton", "up", self.file, "--headless"])
        self.wait("a driver measures the arm", lambda status: status["arms"] and status["arms"][0]["state"]["q"])
        for order in device.begin:
            self.insist(*order.split()[1:])
        self.wait("the arm may move", self.may_move)

    def start(self, command, **streams):
        log = open(self.folder / "log", "a")
        self.processes.append(subprocess.Popen(command, stdout=log, stderr=log, **streams))
        return self.processes[-1]

    def hecaton(self, *words):
        done = subprocess.run([self.programs / "hecaton", *words], capture_output=True, text=True)
        if done.returncode not in (0, 1):
            raise RuntimeError(f"hecaton {' '.join(map(str, words))}: {done.stdout}{done.stderr}")
        return done.stdout

    def insist(self, *words):
        until = time.monotonic() + PATIENCE
        while True:
            try:
                return self.hecaton(*words, "--cell", self.file)
            except RuntimeError:
                if time.monotonic() > until:
                    raise

    def may_move(self, status):
        if status["arms"][0]["mode"] == "run":
            return True
        subprocess.run([self.programs / "hecaton", "resume", "arm", "--cell", self.file], capture_output=True)
        return False

    def wait(self, what, condition):
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            try:
                status = json.loads(self.hecaton("status", "-o", "json", "--cell", self.file))
            except RuntimeError:
                continue
            if condition(status):
                return status
        raise RuntimeError(f"{what}: not within {PATIENCE:g} s; see {self.folder / 'log'}")

    def measure(self):
        status = self.wait("the driver is heard", lambda status: any(node["kind"] == "driver" for node in status["nodes"]))
        pid = next(node["pid"] for node in status["nodes"] if node["kind"] == "driver")
        capture = Capture(self.device) if self.device.address and os.geteuid() == 0 else None
        recording = self.folder / "cost.mcap"
        recorder = self.start([self.programs / "hecaton", "record", "-o", recording, "--duration", f"{self.options.seconds}s", self.file])
        load = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(self.options.load)]
        spent, began, goals = processor_seconds(pid), time.monotonic(), 0
        try:
            while recorder.poll() is None:
                self.hecaton("goal", "arm", "--named", "far" if goals % 2 == 0 else "home", "--wait", "--time-limit", "20s", "--cell", self.file)
                goals += 1
            spent, passed = processor_seconds(pid) - spent, time.monotonic() - began
        finally:
            for process in load:
                process.kill()
                process.wait()
        times = []
        if capture:
            capture.stop()
            times = [b - a for a, b in zip(capture.times, capture.times[1:])]
        self.hecaton("bag", "export", recording, "--csv", "-o", self.folder / "csv")
        return latencies(self.folder / "csv"), times, 100.0 * spent / passed, goals

    def stop(self):
        for process in reversed(self.processes):
            process.send_signal(signal.SIGINT)
        for process in self.processes:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--devices", default=",".join(DEVICES))
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--period", default="2ms")
    parser.add_argument("--load", type=int, default=0)
    options = parser.parse_args()
    options.programs = options.programs.resolve()
    print(f"{'device':24} {'planner → driver [ms]':>24} {'between set-points [ms]':>26} {'processor':>10} {'goals':>6}   (p50, p99, max)")
    for name in options.devices.split(","):
        with tempfile.TemporaryDirectory(prefix="hecaton_device_cost_") as folder:
            cell = None
            try:
                cell = Cell(DEVICES[name](options.programs), options, pathlib.Path(folder))
                taken, times, processor, goals = cell.measure()
                print(f"{name:24} {quantiles(taken):>24} {quantiles(times):>26} {processor:8.1f} % {goals:6}", flush=True)
            finally:
                if cell:
                    cell.stop()


if __name__ == "__main__":
    main()
