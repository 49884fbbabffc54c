#!/usr/bin/env python3
"""Simulates the controller of an ABB robot on the network: EGM position guidance of its joints over UDP.

usage: abb_controller.py --to 127.0.0.1:6510 [--address 127.0.0.12] [--robot irb120|yumi] [--start DEG1,…,DEG6] [--external DEG] [--max-speed-deviation DEG/S]
                         [--comm-timeout S] [--cond-time S] [--sample-rate MS] [--lp-filter HZ] [--stop hold|ramp_down] [--off]

It is written from the description of the wire alone and shares no code with the driver. It is no RobotWare: dynamics are those of a
position servo, and its RAPID program is the loop of docs/how-to/abb-egm.md (`program` below). Tests give orders on port 30999, a
line each, and get a line of JSON back. --help lists the orders. Two arms of one robot are two processes, with one address in --from.
"""
import argparse
import collections
import json
import math
import random
import selectors
import socket
import struct
import sys
import time

import orders

CONTROL = 30999
PERIOD = 0.004  # of the motion control [s]
LAG = 0.03  # time constant of the servo [s]
STRONGEST = 2300.0  # servo acceleration [deg/s²]
BRAKING = 1700.0  # without guidance [deg/s²]
# Of the joints, and of an external axis [deg].
RANGES = {"irb120": ([(-165, 165), (-110, 110), (-110, 70), (-160, 160), (-120, 120), (-400, 400)], (-170, 170)),
          "yumi": ([(-168.5, 168.5), (-143.5, 43.5), (-123.5, 80), (-290, 290), (-88, 138), (-229, 229)], (-168.5, 168.5))}
WINDOW = 0.1  # egm_minmax of the program [deg]
MOST_QUEUED = 16  # datagrams
# Largest distance of a first set-point from the measured position (None: no set-point yet), largest step between set-points [deg]
JUMPS = {"first": None, "largest": 0.0}

DATA, CORRECTION = 2, 3  # message types
MOTORS_ON, MOTORS_OFF = 1, 2
MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 1, 2, 3
RAPID_UNDEFINED, RAPID_STOPPED, RAPID_RUNNING = 0, 1, 2


# --- the wire format of protocol buffers

class WireError(ValueError):
    pass


def varint(value):
    data = bytearray()
    while value > 0x7F:
        data.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes(data + bytes([value]))


def number(field, value):
    return varint(field << 3) + varint(value)


def double(field, value):
    return varint(field << 3 | 1) + struct.pack("<d", value)


def block(field, content):
    return varint(field << 3 | 2) + varint(len(content)) + content


def doubles(field, values):
    return b"".join(double(field, value) for value in values)


def read_varint(data, at):
    value = shift = 0
    while True:
        if at >= len(data) or shift > 63:
            raise WireError("a number does not end")
        value |= (data[at] & 0x7F) << shift
        at += 1
        if data[at - 1] < 0x80:
            return value, at
        shift += 7


def fields(data):
    """The fields of a message: field number → list of values (int, float or bytes)."""
    found, at = collections.defaultdict(list), 0
    while at < len(data):
        tag, at = read_varint(data, at)
        kind = tag & 7
        if tag >> 3 == 0:
            raise WireError("field 0")
        if kind == 0:
            value, at = read_varint(data, at)
        elif kind in (1, 5):
            size, form = (8, "<d") if kind == 1 else (4, "<f")
            if at + size > len(data):
                raise WireError("a value does not end")
            value, at = struct.unpack(form, data[at:at + size])[0], at + size
        elif kind == 2:
            size, at = read_varint(data, at)
            if at + size > len(data):
                raise WireError("a block does not end")
            value, at = data[at:at + size], at + size
        else:
            raise WireError(f"wire type {kind}")
        found[tag >> 3].append(value)
    return found


def read_correction(data):
    """An EgmSensor message: sequence number, joints, external joints."""
    message = fields(data)
    if len(message[1]) != 1 or len(message[2]) != 1 or message[3]:
        raise WireError("header and planned are needed, speedRef is not supported")
    header, planned = fields(message[1][0]), fields(message[2][0])
    if header[3] != [CORRECTION] or len(header[1]) != 1:
        raise WireError("no correction with a sequence number")
    joints, external = ([value for part in planned[field] for value in fields(part)[1]] for field in (1, 3))
    if not all(isinstance(value, float) and math.isfinite(value) for value in joints + external):
        raise WireError("a joint value is not a finite double")
    return header[1][0], joints, external


# --- the arm

class Joints:
    """A position servo for each joint, in degrees: the reference is filtered, then followed within speed and acceleration."""

    def __init__(self, options):
        self.options = options
        self.q = list(options.start) + ([] if options.external is None else [options.external])
        self.qd = [0.0] * len(self.q)
        joints, external = RANGES[options.robot]
        self.ranges = [*joints, external][:len(self.q)]
        self.filtered = list(self.q)
        self.fastest = self.strongest = 0.0  # seen [deg/s], [deg/s²]

    def begin(self):
        self.filtered = list(self.q)

    def follow(self, reference, gain):
        share = 1.0
        if self.options.lp_filter > 0:
            share = 1.0 - math.exp(-2.0 * math.pi * self.options.lp_filter * PERIOD)
        most = self.options.max_speed_deviation
        for j, target in enumerate(reference):
            self.filtered[j] += share * (target - self.filtered[j])
            wanted = gain * (self.filtered[j] - self.q[j]) / LAG
            self.move(j, max(-most, min(most, wanted)), STRONGEST)

    def brake(self):
        for j in range(len(self.q)):
            self.move(j, 0.0, BRAKING)

    def move(self, j, wanted, strongest):
        before, change = self.qd[j], strongest * PERIOD
        self.qd[j] = before + max(-change, min(change, wanted - before))
        self.q[j] += 0.5 * (before + self.qd[j]) * PERIOD
        self.fastest = max(self.fastest, abs(self.qd[j]))
        self.strongest = max(self.strongest, abs(self.qd[j] - before) / PERIOD)


# --- EGM

class Egm:
    """What EGMSetupUC, EGMActJoint and EGMRunJoint do."""

    def __init__(self, controller, options):
        self.controller, self.options = controller, options
        self.socket = None
        self.connected = False  # between EGMActJoint and EGMReset: the controller sends
        self.state = MCI_STOPPED
        self.queue = collections.deque(maxlen=MOST_QUEUED)
        self.sent = 0
        self.last_number = -1  # of the sensor's messages
        self.reference, self.start = None, None
        self.since = self.heard_at = self.converged_since = 0.0
        self.returning = None  # positions from which a ramp down began
        self.counts = {"malformed": 0, "old": 0, "unknown_senders": 0, "accepted": 0, "timeouts": 0, "runs": 0, "most_queued": 0}
        self.jumps = dict(JUMPS)
        self.open()

    def open(self):
        """A new socket, which sends from another port."""
        if self.socket:
            self.controller.selector.unregister(self.socket)
            self.socket.close()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((self.options.source or self.options.address, 0))
        self.socket.setblocking(False)
        self.controller.selector.register(self.socket, selectors.EVENT_READ, self)

    def ready(self):
        while True:
            try:
                data, sender = self.socket.recvfrom(4096)
            except (BlockingIOError, ConnectionError):
                return
            if self.controller.cut:
                continue
            if sender != self.options.to:
                self.counts["unknown_senders"] += 1
                continue
            self.queue.append(data)
            if self.connected and self.state == MCI_RUNNING:
                self.counts["most_queued"] = max(self.counts["most_queued"], len(self.queue))

    def act(self):
        self.connected, self.state = True, MCI_STOPPED
        self.sent, self.last_number, self.reference = 0, -1, None
        self.queue.clear()

    def run(self):
        joints, now = self.controller.joints, self.controller.now
        joints.begin()
        self.state, self.reference, self.start = MCI_RUNNING, None, list(joints.q)
        self.since = self.heard_at = now
        self.converged_since = math.inf
        self.returning = None
        self.counts["runs"] += 1

    def stop(self, state=MCI_STOPPED):
        if self.state == MCI_RUNNING and self.options.stop == "ramp_down" and state == MCI_STOPPED and self.controller.motors:
            self.returning = (self.controller.now, list(self.controller.joints.q))
        if self.state == MCI_RUNNING or state == MCI_ERROR:
            self.state = state
        self.reference = None

    def reset(self):
        self.stop()
        self.connected, self.state = False, MCI_STOPPED

    def runs(self):
        return self.state == MCI_RUNNING

    def converged(self):
        return self.runs() and self.converged_since <= self.controller.now

    def cycle(self):
        """A period of the motion control: takes one message at most, moves, and sends."""
        now, joints = self.controller.now, self.controller.joints
        if self.queue and self.connected:
            self.take(self.queue.popleft())
        if self.runs() and now - self.heard_at > self.options.comm_timeout:
            self.counts["timeouts"] += 1
            self.stop()
        if self.runs() and self.reference:
            ramp = min(1.0, (now - self.since) / self.options.ramp_in_time) if self.options.ramp_in_time > 0 else 1.0
            joints.follow(self.reference, ramp)
            inside = all(abs(target - q) <= WINDOW for target, q in zip(self.reference, joints.q))
            self.converged_since = min(self.converged_since, now) if inside else math.inf
            if inside and now - self.converged_since > self.options.cond_time:
                self.stop()
        elif self.returning:
            self.ramp_down()
        else:
            joints.brake()
        if self.connected and self.controller.cycles % max(1, round(self.options.sample_rate / 4)) == 0:
            self.send()

    def take(self, data):
        try:
            seqno, joints, external = read_correction(data)
            values = joints + external
            if len(joints) != 6 or len(values) != len(self.controller.joints.q):
                raise WireError(f"{len(joints)} joints and {len(external)} external ones")
        except WireError as error:
            self.counts["malformed"] += 1
            self.controller.say(f"a message was refused: {error}")
            return
        if seqno <= self.last_number:
            self.counts["old"] += 1
            return
        self.last_number = seqno
        self.counts["accepted"] += 1
        self.heard_at = self.controller.now
        if not self.runs():
            return
        if any(not low <= value <= high for value, (low, high) in zip(values, self.controller.joints.ranges)):
            self.controller.say("joint out of range")
            self.controller.end_program()
            self.stop(MCI_ERROR)
            return
        most = self.options.max_pos_deviation
        values = [max(start - most, min(start + most, value)) for value, start in zip(values, self.start)]
        distance = lambda before: max(abs(new - old) for new, old in zip(values, before))
        if self.reference:
            self.jumps["largest"] = max(self.jumps["largest"], distance(self.reference))
        if not self.reference or self.jumps["first"] is None:
            self.jumps["first"] = max(self.jumps["first"] or 0.0, distance(self.controller.joints.q))
        self.reference = values

    def ramp_down(self):
        """EGM_STOP_RAMP_DOWN moves the arm back to where EGMRunJoint began."""
        since, begin = self.returning
        share = min(1.0, (self.controller.now - since) / self.options.ramp_out_time)
        for j, (old, start) in enumerate(zip(begin, self.start)):
            q = old + share * (start - old)
            self.controller.joints.qd[j] = (q - self.controller.joints.q[j]) / PERIOD
            self.controller.joints.q[j] = q
        if share >= 1.0:
            self.returning = None

    def message(self):
        c = self.controller
        shown = [math.nan] * 6 if c.not_finite else c.joints.q
        count = c.shown_joints
        clock = b"" if c.old_software else block(4, number(1, int(c.clock)) + number(2, int(c.clock % 1 * 1e6)))
        pose = block(1, double(1, 374.0) + double(2, 0.0) + double(3, 630.0)) + block(2, double(1, 1.0) + b"".join(double(field, 0.0) for field in (2, 3, 4)))

        def positions(values):
            return block(1, doubles(1, values[:count])) + block(2, pose) + block(3, doubles(1, values[6:])) + clock

        return b"".join([
            block(1, number(1, self.sent) + number(2, round(c.now * 1000) & 0xFFFFFFFF) + number(3, DATA)),
            block(2, positions(shown)),
            block(3, positions(self.reference or c.joints.q)),
            block(4, number(1, MOTORS_ON if c.motors else MOTORS_OFF)),
            block(5, number(1, self.state)),
            number(6, self.converged()),
            block(7, b""),
            block(8, number(1, RAPID_UNDEFINED if c.undefined else RAPID_RUNNING if c.program else RAPID_STOPPED)),
            b"" if c.old_software else double(10, 42.0),
        ])

    def send(self):
        c = self.controller
        data = self.message()
        self.sent += 1
        if c.cut or random.random() < c.loss:
            return
        try:
            if c.reordered and self.sent % 5 == 0:
                c.kept = data  # arrives after the next one
                return
            for part in [data, c.kept, *([data] if c.twice else [])]:
                if part:
                    self.socket.sendto(part, self.options.to)
            c.kept = None
        except OSError:
            pass  # the other machine does not listen


# --- the controller

def program(controller):
    """The RAPID program: each `yield` lasts for a period."""
    egm = controller.egm
    while True:
        egm.reset()
        yield from wait(controller, 0.1)  # MoveAbsJ CJointT(), EGMGetId, EGMSetupUC
        egm.act()
        yield from wait(controller, 0.1)
        egm.run()
        while egm.runs():
            yield
        yield from wait(controller, 0.1)


def wait(controller, seconds):
    end = controller.now + seconds
    while controller.now < end:
        yield


class Controller:
    def __init__(self, options):
        self.options = options
        self.selector = selectors.DefaultSelector()
        self.cycles, self.began = 0, time.time()
        self.joints = Joints(options)
        self.motors, self.program = True, None
        self.cut = self.twice = self.reordered = self.old_software = self.undefined = self.not_finite = False
        self.kept, self.loss, self.shown_joints = None, 0.0, 6
        self.messages = []
        self.egm = Egm(self, options)
        listener = socket.create_server((options.address, CONTROL))
        self.selector.register(listener, selectors.EVENT_READ, listener)
        if options.off:
            self.motors = False
            self.egm.act()
        else:
            self.start_program()

    @property
    def now(self):
        return self.cycles * PERIOD

    @property
    def clock(self):
        return self.began + self.now

    def run(self):
        begin = time.monotonic()
        while True:
            due = begin + (self.cycles + 1) * PERIOD
            for key, _ in self.selector.select(max(0.0, due - time.monotonic())):
                if isinstance(key.data, socket.socket):
                    ControlClient(self, key.data.accept()[0])
                else:
                    key.data.ready()
            if time.monotonic() < due:
                continue
            if time.monotonic() > due + 10 * PERIOD:  # this process was stopped: time stood still
                begin = time.monotonic() - self.cycles * PERIOD
            self.cycle()

    def cycle(self):
        self.cycles += 1
        if self.program:
            next(self.program)
        self.egm.cycle()

    def start_program(self):
        if not self.motors:
            return self.say("the motors are off")
        self.program = program(self)
        return None

    def end_program(self):
        self.program = None
        self.egm.stop()

    def say(self, message):
        if message not in self.messages[-1:]:
            self.messages.append(message)
            print(message, file=sys.stderr, flush=True)


class ControlClient:
    """A test. Its lines are the names of Orders' methods and words."""

    def __init__(self, owner, own_socket):
        self.owner, self.socket, self.received = owner, own_socket, b""
        owner.selector.register(own_socket, selectors.EVENT_READ, self)

    def ready(self):
        data = self.socket.recv(65536)
        if not data:
            self.owner.selector.unregister(self.socket)
            self.socket.close()
            return
        self.received += data
        while b"\n" in self.received:
            line, self.received = self.received.split(b"\n", 1)
            result = orders.obey(Orders, self.owner, line)
            self.socket.sendall((json.dumps(result) + "\n").encode())


class Orders:
    """What a test, or a person without a robot, can do to the controller."""

    @staticmethod
    def state(c):
        return {"q": c.joints.q, "qd": c.joints.qd, "motors": c.motors, "program": c.program is not None, "egm": c.egm.state,
                "converged": c.egm.converged(), "fastest": c.joints.fastest, "strongest": c.joints.strongest, "now": c.now,
                "sent": c.egm.sent, "messages": c.messages[-5:], **c.egm.counts, **c.egm.jumps}

    @staticmethod
    def forget(c):
        """`first` is that of the next set-point."""
        c.egm.jumps = dict(JUMPS)
        c.egm.counts = dict.fromkeys(c.egm.counts, 0)
        c.joints.fastest = c.joints.strongest = 0.0

    @staticmethod
    def motors(c, state):
        """Off also ends the program, as an emergency stop does."""
        c.motors = state == "on"
        if not c.motors:
            c.end_program()

    @staticmethod
    def program(c, state):
        if state == "start":
            c.start_program()
        else:
            c.end_program()

    @staticmethod
    def egm_stop(c):
        """EGMStop from a trap routine: EGMRunJoint ends, and the program goes on."""
        c.egm.stop()

    @staticmethod
    def egm_error(c):
        c.end_program()
        c.egm.stop(MCI_ERROR)

    @staticmethod
    def cond_time(c, seconds):
        c.options.cond_time = float(seconds)

    @staticmethod
    def restart(c):
        """The controller restarts: motors off, no program, and then another port of its own."""
        c.end_program()
        c.egm.reset()
        c.egm.open()
        c.motors = False

    @staticmethod
    def cable(c, state):
        """Pulled: nothing arrives and nothing leaves."""
        c.cut = state == "pulled"

    @staticmethod
    def loss(c, share):
        c.loss = float(share)

    @staticmethod
    def twice(c, on):
        c.twice = on == "on"

    @staticmethod
    def reordered(c, on):
        """Each fifth message arrives after the next one."""
        c.reordered = on == "on"

    @staticmethod
    def undefined(c, on):
        """Reports the RAPID state as undefined, as controllers do after a restart."""
        c.undefined = on == "on"

    @staticmethod
    def old_software(c, on):
        """Before RobotWare 6.07: no time in the messages."""
        c.old_software = on == "on"

    @staticmethod
    def not_finite(c, on):
        c.not_finite = on == "on"

    @staticmethod
    def shown_joints(c, count):
        c.shown_joints = int(count)

    @staticmethod
    def noise(c, count):
        """Sends truncated and random messages beside the true ones."""
        for _ in range(int(count)):
            data = c.egm.message()[:-20]  # the states are at the end
            data = data[:random.randrange(len(data))] if random.random() < 0.5 else random.randbytes(random.randrange(300))
            c.egm.socket.sendto(data, c.options.to)

    @staticmethod
    def impostor(c, address):
        """Sends a plausible message from another address."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind((address, 0))
            before, c.joints.q = c.joints.q, [q + 20.0 for q in c.joints.q]
            c.egm.sent += 1000
            other.sendto(c.egm.message(), c.options.to)
            c.egm.sent -= 1000
            c.joints.q = before


def address_and_port(text):
    address, _, port = text.partition(":")
    return address, int(port)


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=orders.listed(Orders), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--to", type=address_and_port, default=("127.0.0.1", 6510), help="address and port of the driver: UDPUC")
    parser.add_argument("--address", default="127.0.0.12", help="on which it takes orders of tests")
    parser.add_argument("--from", dest="source", help="address from which it sends, if not the same")
    parser.add_argument("--robot", choices=RANGES, default="irb120", help="ranges of its joints")
    parser.add_argument("--start", type=lambda text: [float(q) for q in text.split(",")], default=[0.0, 0.0, 0.0, 0.0, 90.0, 0.0],
                        help="joint positions [deg], between commas")
    parser.add_argument("--external", type=float, help="position of an external axis, such as the seventh joint [deg]")
    parser.add_argument("--sample-rate", type=int, default=4, help="of EGMActJoint [ms]")
    parser.add_argument("--lp-filter", type=float, default=20.0, help="of EGMActJoint [Hz]; 0: none")
    parser.add_argument("--max-pos-deviation", type=float, default=1000.0, help="of EGMActJoint [deg]")
    parser.add_argument("--max-speed-deviation", type=float, default=100.0, help="of EGMActJoint [deg/s]")
    parser.add_argument("--comm-timeout", type=float, default=1.0, help="of EGMSetupUC [s]")
    parser.add_argument("--cond-time", type=float, default=86400.0, help="of EGMRunJoint [s]")
    parser.add_argument("--ramp-in-time", type=float, default=0.05, help="of EGMRunJoint [s]")
    parser.add_argument("--ramp-out-time", type=float, default=1.0, help="of EGMRunJoint [s]")
    parser.add_argument("--stop", choices=("hold", "ramp_down"), default="hold", help="of EGMRunJoint")
    parser.add_argument("--off", action="store_true", help="begins with motors off")
    options = parser.parse_args()
    if len(options.start) != 6:
        parser.error("--start: six positions are needed")
    controller = Controller(options)
    print(f"controller on {options.address}", flush=True)
    controller.run()


if __name__ == "__main__":
    main()
