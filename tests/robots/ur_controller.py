#!/usr/bin/env python3
"""Simulates the controller of a Universal Robots arm on the network: RTDE, primary and secondary port, dashboard. It runs the
programs that it gets.

usage: ur_controller.py --address 127.0.0.11 [--start Q1,…,Q6] [--model e|cb3] [--robot UR5] [--size TYPE] [--calibration FACTOR]
                        [--off] [--boots-never] [--unlock-after SECONDS]

It is written from the description of the wire alone and shares no code with the driver. It is no PolyScope: dynamics are those of a
position servo, and of URScript it knows what tests/robots/urscript.py knows. Tests give orders on port 30999, a line each, and get a
line of JSON back. --help lists the orders.
"""
import argparse
import json
import math
import selectors
import socket
import struct
import sys
import time

import orders
from urscript import Program, ScriptError, Thread

RTDE, PRIMARY, SECONDARY, DASHBOARD, CONTROL = 30004, 30001, 30002, 29999, 30999
PERIODS = {"e": 0.002, "cb3": 0.008}
FASTEST = 3.3  # of a joint [rad/s]
STRONGEST = 40.0  # servo acceleration [rad/s²]
SAFETY_BRAKING = 30.0  # of a protective stop [rad/s²]
FASTEST_TARGET = 20.0  # servoj ignores targets that need more [rad/s]
MOST_UNREAD = 1 << 16  # bytes for a client that does not read
# Largest distance of a program's first set-point from the measured position (None: no set-point yet), largest step between set-points [rad]
JUMPS = {"first": None, "largest": 0.0, "ignored": 0}

POWER_OFF, BOOTING, IDLE, RUNNING = 3, 2, 5, 7
NORMAL, PROTECTIVE, SAFEGUARD, EMERGENCY = 1, 3, 5, 7
STOPPED, PLAYING, PAUSED = 1, 2, 4
ROBOT_MODES = {POWER_OFF: "POWER_OFF", BOOTING: "BOOTING", IDLE: "IDLE", RUNNING: "RUNNING"}
SAFETY_MODES = {NORMAL: "NORMAL", PROTECTIVE: "PROTECTIVE_STOP", SAFEGUARD: "SAFEGUARD_STOP", EMERGENCY: "ROBOT_EMERGENCY_STOP"}

# Published lengths by type [m]: a2, a3, d1, d4, d5, d6. The twists of all types are the same [rad].
LENGTHS = {"ur3": (-0.24365, -0.21325, 0.1519, 0.11235, 0.08535, 0.0819), "ur5": (-0.425, -0.39225, 0.089159, 0.10915, 0.09465, 0.0823),
           "ur10": (-0.612, -0.5723, 0.1273, 0.163941, 0.1157, 0.0922), "ur3e": (-0.24355, -0.2132, 0.15185, 0.13105, 0.08535, 0.0921),
           "ur5e": (-0.425, -0.3922, 0.1625, 0.1333, 0.0997, 0.0996), "ur10e": (-0.6127, -0.57155, 0.1807, 0.17415, 0.11985, 0.11655),
           "ur16e": (-0.4784, -0.36, 0.1807, 0.17415, 0.11985, 0.11655)}
TWISTS = (math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)
# What a calibration adds [rad, m]. The axes of shoulder and elbow are almost parallel, so that their common normal is far away.
CALIBRATION = {"theta": (3e-8, -2.1e-3, 1.6e-3, 4e-4, -3e-5, 0.0), "a": (2e-5, 1.1e-4, -1.5e-4, 3e-5, 2e-5, 0.0),
               "d": (1e-4, 5.0, -5.0, 2e-4, -5e-5, 8e-5), "alpha": (-4e-4, 2e-4, -2e-4, 3e-4, -4e-4, 0.0)}


class Joints:
    """Six joints behind a position servo with the lag of servoj's lookahead time."""

    def __init__(self, q, period):
        self.period = period
        self.q, self.qd = list(q), [0.0] * 6
        self.command = None  # (q, lookahead) of servoj
        self.braking = SAFETY_BRAKING
        self.fastest = self.strongest = 0.0  # seen [rad/s], [rad/s²]

    def step(self, speed):
        for j in range(6):
            before = self.qd[j]
            if self.command:
                wanted = speed * (self.command[0][j] - self.q[j]) / self.command[1]
                most = FASTEST * speed
                change = STRONGEST * self.period
                wanted = max(-most, min(most, wanted))
                self.qd[j] = before + max(-change, min(change, wanted - before))
            else:
                change = self.braking * self.period
                self.qd[j] = before - max(-change, min(change, before))
            self.q[j] += 0.5 * (before + self.qd[j]) * self.period
            self.fastest = max(self.fastest, abs(self.qd[j]))
            self.strongest = max(self.strongest, abs(self.qd[j] - before) / self.period)

    def stop(self, braking):
        self.command = None
        self.braking = braking

    def moves(self):
        return any(abs(v) > 1e-6 for v in self.qd)


class Connection:
    """A non-blocking connection with what waits to be sent."""

    def __init__(self, owner, own_socket, handler, name):
        self.owner, self.socket, self.handler, self.name = owner, own_socket, handler, name
        self.received, self.waiting, self.closed, self.lingering = b"", b"", False, False
        own_socket.setblocking(False)
        own_socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        owner.selector.register(own_socket, selectors.EVENT_READ, self)

    def send(self, data):
        self.waiting += data
        self.flush()

    def flush(self):
        while self.waiting and not self.closed and not self.owner.cut:
            part = self.waiting
            if self.owner.halves and len(part) > 1:
                part = part[:len(part) // 2]
            try:
                self.waiting = self.waiting[self.socket.send(part):]
            except BlockingIOError:
                break
            except OSError:
                self.close()
                return
            if self.owner.halves:
                return  # the other half in the next cycle
        if len(self.waiting) > MOST_UNREAD:
            self.close()

    def ready(self):
        if self.owner.cut:
            return
        try:
            data = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.close()
        self.received += data
        if not self.closed or self.received:
            self.handler(self)

    def linger(self):
        """The other side is gone; this one does not notice, and keeps what belongs to the connection."""
        self.lingering = True
        self.owner.selector.unregister(self.socket)

    def close(self):
        if self.closed:
            return
        self.closed = True
        if not self.lingering:
            self.owner.selector.unregister(self.socket)
        if self.owner.cut:
            self.owner.unseen_ends.append(self.socket)
        else:
            self.socket.close()


class Controller:
    def __init__(self, options):
        self.options = options
        self.period = PERIODS[options.model]
        self.selector = selectors.DefaultSelector()
        self.joints = Joints(options.start, self.period)
        self.cycles = 0
        self.robot_mode, self.safety_mode = (POWER_OFF if options.off else RUNNING), NORMAL
        self.due = []  # (cycle, action)
        self.slider, self.slowdown = 1.0, 1.0
        self.remote = True
        self.stopped_at = -math.inf  # of the protective stop [s]
        self.program, self.paused = None, False
        self.digital_inputs = self.digital_outputs = 0  # bits: 8 standard, 8 configurable, 2 at the tool
        self.analog_inputs, self.analog_outputs = [0.0] * 4, [0.0] * 2  # 2 standard ones, 2 at the tool [V | A]
        self.not_found, self.in_use = set(), set()
        self.kinematics = "sent"  # or missing, truncated, endless, nan
        self.cut = self.halves = self.dashboard_silent = False
        self.delayed_until = 0
        self.linger = 0.0  # [s] from the end of a cut
        self.reverse_lingers = False
        self.unseen_ends = []  # sockets that were closed while the cable is out: the other side learns of it afterwards
        self.rtde, self.primaries = [], []
        self.jumps = dict(JUMPS)
        self.programs, self.dashboards, self.messages = 0, 0, []  # so far
        self.brake_releases = 0  # orders for it so far
        self.listeners = []
        self.listen(((CONTROL, ControlClient),))
        self.serve_robot()

    def listen(self, ports):
        for port, accept in ports:
            listener = socket.create_server((self.options.address, port))
            listener.setblocking(False)
            self.listeners.append(listener)
            self.selector.register(listener, selectors.EVENT_READ, (listener, accept))

    def serve_robot(self):
        self.listen(((RTDE, RtdeClient), (PRIMARY, PrimaryClient), (SECONDARY, PrimaryClient), (DASHBOARD, DashboardClient)))

    def drop_connections(self, name=""):
        for key in list(self.selector.get_map().values()):
            if isinstance(key.data, Connection) and not isinstance(key.data, ControlClient) and name in ("", key.data.name):
                key.data.close()

    def restart(self, seconds):
        self.end_program()
        self.drop_connections()
        self.end_lingering()
        for listener in self.listeners[1:]:  # the first is that of tests
            self.selector.unregister(listener)
            listener.close()
        del self.listeners[1:]
        self.robot_mode, self.safety_mode = POWER_OFF, NORMAL
        self.slider, self.slowdown, self.remote, self.cut = 1.0, 1.0, True, False
        self.show_ends()
        self.due.clear()
        self.after(seconds, self.serve_robot)

    def cut_cable(self):
        self.cut = True
        if not self.linger:
            return
        self.reverse_lingers = self.program is not None and bool(self.program.sockets)
        for client in self.rtde:
            if not client.lingering:
                client.linger()

    def show_ends(self):
        for ended in self.unseen_ends:
            ended.close()
        self.unseen_ends.clear()

    def plug_cable(self):
        self.cut = False
        self.show_ends()
        if self.linger:
            self.after(self.linger, self.end_lingering)

    def end_lingering(self):
        self.reverse_lingers = False
        for client in [client for client in self.rtde if client.lingering]:
            client.close()

    # --- time

    @property
    def now(self):
        return self.cycles * self.period

    def after(self, seconds, action):
        self.due.append((self.cycles + round(seconds / self.period), action))

    def run(self):
        begin = time.monotonic()
        while True:
            wait = begin + (self.cycles + 1) * self.period - time.monotonic()
            for key, _ in self.selector.select(max(0.0, wait)):
                self.serve(key.data)
            if time.monotonic() < begin + (self.cycles + 1) * self.period:
                continue
            if time.monotonic() > begin + (self.cycles + 10) * self.period:  # this process was stopped: time stood still
                begin = time.monotonic() - self.cycles * self.period
            self.cycle()

    def serve(self, data):
        if not isinstance(data, tuple):
            data.ready()
            return
        listener, accept = data
        if self.cut and accept is not ControlClient:
            return
        own, _ = listener.accept()
        accept(self, own)

    def cycle(self):
        self.cycles += 1
        for due in [due for due in self.due if due[0] <= self.cycles]:
            self.due.remove(due)
            due[1]()
        if self.program and not self.paused:
            try:
                self.program.cycle()
            except ScriptError as error:
                self.say(f"runtime error: {error}")
                self.end_program()
        self.joints.step(self.speed())
        for client in list(self.rtde):
            client.cycle()
        if self.cycles % round(0.1 / self.period) == 0:
            for client in list(self.primaries):
                client.cycle()

    def speed(self):
        return self.slider * self.slowdown

    # --- robot

    def dh(self):
        """Denavit-Hartenberg parameters of this robot, with its calibration."""
        a2, a3, d1, d4, d5, d6 = LENGTHS[self.options.size]
        nominal = {"theta": (0.0,) * 6, "a": (0.0, a2, a3, 0.0, 0.0, 0.0), "d": (d1, 0.0, 0.0, d4, d5, d6), "alpha": TWISTS}
        return {name: [value + self.options.calibration * change for value, change in zip(values, CALIBRATION[name])]
                for name, values in nominal.items()}

    def may_move(self):
        return self.robot_mode == RUNNING and self.safety_mode == NORMAL

    def runtime_state(self):
        return STOPPED if not self.program else PAUSED if self.paused else PLAYING

    def start(self, text):
        if self.options.model == "e" and not self.remote:
            return self.say("a program was refused: local control")
        if not self.may_move():
            return self.say("a program was refused: the robot is not ready")
        try:
            program = Program(text)
        except ScriptError as error:
            return self.say(f"compile error: {error}")
        self.end_program()
        self.programs += 1
        self.program, self.paused = Run(self, program), False

    def end_program(self, braking=SAFETY_BRAKING):
        if self.program:
            self.program.end()
        self.program = None
        self.joints.stop(braking)

    def pause(self):
        self.paused = self.program is not None
        self.joints.stop(8.0)

    def say(self, message):
        self.messages.append(message)
        print(message, file=sys.stderr, flush=True)
        for client in self.rtde:
            if not client.lingering:
                client.text(message)


class Run:
    """A running program: its threads and its sockets."""

    def __init__(self, controller, program):
        self.controller, self.program = controller, program
        self.sockets = {}
        self.first = True
        self.commanded = None
        self.waits = {}  # of requests with a time: thread → cycle
        self.threads = []
        self.main = self.begin("main")

    def begin(self, name):
        thread = Thread(self.program, name)
        self.threads.append(thread)
        return thread

    def end(self):
        for connection in self.sockets.values():
            connection.close()

    def cycle(self):
        for thread in list(self.threads):
            while thread.request:
                done, result = self.answer(thread, *thread.request)
                if not done:
                    break
                self.waits.pop(thread, None)
                thread.go_on(result)
            if not thread.request:
                self.threads.remove(thread)
        if self.main not in self.threads:
            self.controller.end_program(8.0)

    def answer(self, thread, kind, arguments):
        """Whether the request is done, and its result."""
        return getattr(self, kind)(thread, **arguments)

    def until(self, thread, seconds):
        """True once `seconds` have passed since the request."""
        due = self.waits.setdefault(thread, self.controller.cycles + max(1, round(seconds / self.controller.period)))
        return self.controller.cycles >= due

    def run(self, _thread, thread):
        return True, self.begin(thread)

    def join(self, _thread, thread):
        return thread not in self.threads, None

    def sync(self, thread):
        return self.until(thread, self.controller.period), None

    def sleep(self, thread, t):
        return self.until(thread, t), None

    def get_steptime(self, _thread):
        return True, self.controller.period

    def get_actual_joint_positions(self, _thread):
        return True, list(self.controller.joints.q)

    def textmsg(self, _thread, message, value=""):
        self.controller.say(f"{message}{value}")
        return True, None

    def servoj(self, thread, q, t, a=0, v=0, lookahead_time=0.1, gain=300):
        controller = self.controller
        if thread not in self.waits:
            if not (0.03 <= lookahead_time <= 0.2 and 100 <= gain <= 2000 and len(q) == 6):
                raise ScriptError("servoj: a parameter is out of range")
            before = self.commanded or controller.joints.q
            jump = max(abs(new - old) for new, old in zip(q, before))
            if jump / t > FASTEST_TARGET:
                controller.jumps["ignored"] += 1
            else:
                if self.commanded:
                    controller.jumps["largest"] = max(controller.jumps["largest"], jump)
                if not self.commanded or controller.jumps["first"] is None:
                    distance = max(abs(new - old) for new, old in zip(q, controller.joints.q))
                    controller.jumps["first"] = max(controller.jumps["first"] or 0.0, distance)
                controller.joints.command = (list(q), lookahead_time)
                self.commanded = list(q)
        return self.until(thread, t), None

    def stopj(self, _thread, a):
        self.controller.joints.stop(a)
        self.commanded = None
        return not self.controller.joints.moves(), None

    def socket_open(self, thread, address, port, name="socket_0"):
        if self.controller.reverse_lingers:
            if not self.until(thread, 0.2):
                return False, None
            self.controller.say("socket_open: the last connection has not ended")
            return True, False
        own = socket.socket()
        own.settimeout(1.0)
        try:
            own.bind((self.controller.options.address, 0))
            own.connect((address, port))
        except OSError as error:
            self.controller.say(f"socket_open: {error}")
            return True, False
        self.sockets[name] = Connection(self.controller, own, lambda connection: None, name)
        return True, True

    def socket_close(self, _thread, name="socket_0"):
        if name in self.sockets:
            self.sockets.pop(name).close()
        return True, None

    def socket_read_binary_integer(self, thread, number, name="socket_0", timeout=2.0):
        connection = self.sockets.get(name)
        size = 4 * number
        if connection and len(connection.received) >= size:
            data, connection.received = connection.received[:size], connection.received[size:]
            return True, [number, *struct.unpack(f">{number}i", data)]
        if not connection or connection.closed:
            return True, [0] + [-1] * number
        late = timeout > 0 and self.until(thread, timeout)
        return late, [0] + [-1] * number


class RtdeClient(Connection):
    OUTPUTS = {
        "timestamp": ("DOUBLE", lambda c: struct.pack(">d", c.now)),
        "actual_q": ("VECTOR6D", lambda c: struct.pack(">6d", *c.joints.q)),
        "actual_qd": ("VECTOR6D", lambda c: struct.pack(">6d", *c.joints.qd)),
        "target_q": ("VECTOR6D", lambda c: struct.pack(">6d", *(c.joints.command or [c.joints.q])[0])),
        "speed_scaling": ("DOUBLE", lambda c: struct.pack(">d", c.slowdown)),
        "target_speed_fraction": ("DOUBLE", lambda c: struct.pack(">d", c.slider)),
        "runtime_state": ("UINT32", lambda c: struct.pack(">I", c.runtime_state())),
        "robot_mode": ("INT32", lambda c: struct.pack(">i", c.robot_mode)),
        "safety_mode": ("INT32", lambda c: struct.pack(">i", c.safety_mode)),
        "actual_digital_input_bits": ("UINT64", lambda c: struct.pack(">Q", c.digital_inputs)),
        "actual_digital_output_bits": ("UINT64", lambda c: struct.pack(">Q", c.digital_outputs)),
        "standard_analog_input0": ("DOUBLE", lambda c: struct.pack(">d", c.analog_inputs[0])),
        "standard_analog_input1": ("DOUBLE", lambda c: struct.pack(">d", c.analog_inputs[1])),
        "tool_analog_input0": ("DOUBLE", lambda c: struct.pack(">d", c.analog_inputs[2])),
        "tool_analog_input1": ("DOUBLE", lambda c: struct.pack(">d", c.analog_inputs[3])),
        "standard_analog_output0": ("DOUBLE", lambda c: struct.pack(">d", c.analog_outputs[0])),
        "standard_analog_output1": ("DOUBLE", lambda c: struct.pack(">d", c.analog_outputs[1])),
    }
    INPUTS = {"speed_slider_mask": ("UINT32", "I"), "speed_slider_fraction": ("DOUBLE", "d"),
              **{f"{bank}_digital_output{end}": ("UINT8", "B") for bank in ("standard", "configurable", "tool")
                 for end in ("_mask", "")},
              "standard_analog_output_mask": ("UINT8", "B"), "standard_analog_output_type": ("UINT8", "B"),
              "standard_analog_output_0": ("DOUBLE", "d"), "standard_analog_output_1": ("DOUBLE", "d")}
    FIRST_BIT = {"standard": 0, "configurable": 8, "tool": 16}  # in the bits of all digital outputs

    def __init__(self, owner, own_socket):
        super().__init__(owner, own_socket, RtdeClient.handle, "rtde")
        self.version, self.recipe, self.inputs, self.started, self.every, self.held = 1, [], [], False, 1, []
        owner.rtde.append(self)

    def close(self):
        super().close()
        if self in self.owner.rtde:
            self.owner.rtde.remove(self)

    def package(self, kind, payload=b""):
        self.send(struct.pack(">HB", 3 + len(payload), ord(kind)) + payload)

    def text(self, message):
        data = message.encode()[:200]
        if self.version > 1:
            self.package("M", bytes([len(data)]) + data + bytes([4]) + b"RTDE" + bytes([2]))
        else:
            self.package("M", bytes([2]) + data)

    def handle(self):
        while len(self.received) >= 3:
            size, kind = struct.unpack(">HB", self.received[:3])
            if size < 3:
                return self.close()
            if len(self.received) < size:
                return None
            payload, self.received = self.received[3:size], self.received[size:]
            handler = getattr(self, "handle_" + {"V": "version", "v": "controller", "O": "outputs", "I": "inputs", "S": "start",
                                                 "P": "pause", "U": "data"}.get(chr(kind), "unknown"))
            handler(payload)
        return None

    def handle_unknown(self, _payload):
        self.close()

    def handle_version(self, payload):
        wanted = struct.unpack(">H", payload)[0]
        accepted = wanted in (1, 2) and not (wanted == 2 and "version_2" in self.owner.not_found)
        self.text("welcome")  # a message may come at any time
        self.package("V", bytes([accepted]))
        if accepted:
            self.version = wanted

    def handle_controller(self, _payload):
        self.package("v", struct.pack(">4I", *((5, 12, 0, 1) if self.owner.options.model == "e" else (3, 15, 8, 1))))

    def handle_outputs(self, payload):
        if self.version > 1:
            frequency = struct.unpack(">d", payload[:8])[0]
            if not 1 <= frequency <= round(1 / self.owner.period):
                self.text("output frequency out of range")
                return self.package("O", bytes([0]))
            self.every, payload = max(1, round(1 / (frequency * self.owner.period))), payload[8:]
        names = payload.decode().split(",")
        found = [name in self.OUTPUTS and name not in self.owner.not_found for name in names]
        types = ",".join(self.OUTPUTS[name][0] if there else "NOT_FOUND" for name, there in zip(names, found))
        self.recipe = [self.OUTPUTS[name][1] for name in names] if all(found) else []
        return self.package("O", (bytes([1]) if self.version > 1 else b"") + types.encode())

    def handle_inputs(self, payload):
        names = payload.decode().split(",")
        taken = {name for client in self.owner.rtde for name in client.inputs} | self.owner.in_use
        types = ["NOT_FOUND" if name not in self.INPUTS or name in self.owner.not_found else "IN_USE" if name in taken
                 else self.INPUTS[name][0] for name in names]
        self.inputs = names if not {"NOT_FOUND", "IN_USE"} & set(types) else []
        self.package("I", (bytes([1]) if self.version > 1 else b"") + ",".join(types).encode())

    def handle_start(self, _payload):
        self.started = bool(self.recipe)
        self.package("S", bytes([self.started]))

    def handle_pause(self, _payload):
        self.started = False
        self.package("P", bytes([1]))

    def handle_data(self, payload):
        form = ">" + "".join(self.INPUTS[name][1] for name in self.inputs)
        values = dict(zip(self.inputs, struct.unpack(form, payload[1 if self.version > 1 else 0:])))
        if values.get("speed_slider_mask"):
            self.owner.slider = max(0.0, min(1.0, values["speed_slider_fraction"]))
        for bank, first in self.FIRST_BIT.items():
            mask = values.get(f"{bank}_digital_output_mask", 0) << first
            bits = values.get(f"{bank}_digital_output", 0) << first
            self.owner.digital_outputs = self.owner.digital_outputs & ~mask | bits & mask
        for pin in range(2):
            if values.get("standard_analog_output_mask", 0) >> pin & 1:
                volts = values["standard_analog_output_type"] >> pin & 1  # else a current: 4 to 20 mA
                share = max(0.0, min(1.0, values[f"standard_analog_output_{pin}"]))
                self.owner.analog_outputs[pin] = 10.0 * share if volts else 0.004 + 0.016 * share

    def cycle(self):
        if self.lingering:
            return
        self.flush()
        if not self.started or self.owner.cycles % self.every:
            return
        data = b"".join(field(self.owner) for field in self.recipe)
        self.held.append((bytes([1]) if self.version > 1 else b"") + data)
        if self.owner.cycles < self.owner.delayed_until:
            return
        for payload in self.held:
            self.package("U", payload)
        self.held = []


class PrimaryClient(Connection):
    """Takes programs, and sends the robot's state: first its version, then its kinematics once, and modes and joints at 10 Hz."""

    def __init__(self, owner, own_socket):
        super().__init__(owner, own_socket, PrimaryClient.handle, "primary")
        owner.primaries.append(self)
        self.first = True
        name, date = b"URControl", b"01-01-2026, 00:00:00"
        major, minor = (5, 12) if owner.options.model == "e" else (3, 15)
        version = struct.pack(">QbbB", 0, -2, 3, len(name)) + name + struct.pack(">BBii", major, minor, 0, 1) + date
        self.send(struct.pack(">iB", 5 + len(version), 20) + version)

    def close(self):
        super().close()
        if self in self.owner.primaries:
            self.owner.primaries.remove(self)

    def handle(self):
        end = self.received.find(b"\nend\n")
        if end >= 0:
            text, self.received = self.received[:end + 5], self.received[end + 5:]
            self.owner.after(0.02, lambda: self.owner.start(text.decode()))

    @staticmethod
    def part(kind, payload):
        return struct.pack(">IB", 5 + len(payload), kind) + payload

    def modes(self):
        c = self.owner
        flags = (True, True, c.robot_mode == RUNNING, c.safety_mode == EMERGENCY, c.safety_mode == PROTECTIVE, c.program is not None, c.paused)
        return self.part(0, struct.pack(">Q7?BBdddB", int(c.now * 1e6), *flags, c.robot_mode, 0, c.slider, c.slowdown, 1.0, 0))

    def joints(self):
        servo = self.owner.joints
        return self.part(1, b"".join(struct.pack(">dddffffB", q, q, qd, 0.0, 48.0, 30.0, 0.0, 253) for q, qd in zip(servo.q, servo.qd)))

    def kinematics(self):
        """Checksums, four sets of parameters, and the status of the calibration."""
        dh = self.owner.dh()
        if self.owner.kinematics == "nan":
            dh["d"][3] = math.nan
        values = b"".join(struct.pack(">6d", *dh[name]) for name in ("theta", "a", "d", "alpha"))
        payload = struct.pack(">6I", *range(1, 7)) + values + struct.pack(">I", 1)
        if self.owner.kinematics == "truncated":
            payload = payload[:-12]
        part = self.part(5, payload)
        return struct.pack(">I", 9000) + part[4:] if self.owner.kinematics == "endless" else part

    def cycle(self):
        parts = self.modes() + self.joints()
        if self.first and self.owner.kinematics != "missing":
            parts += self.kinematics()
        self.first = False
        self.send(struct.pack(">iB", 5 + len(parts), 16) + parts)


class DashboardClient(Connection):
    def __init__(self, owner, own_socket):
        super().__init__(owner, own_socket, DashboardClient.handle, "dashboard")
        owner.dashboards += 1
        self.send(b"Connected: Universal Robots Dashboard Server\n")

    def handle(self):
        while b"\n" in self.received:
            line, self.received = self.received.split(b"\n", 1)
            command = line.decode().strip()
            if self.owner.dashboard_silent:
                continue
            known = getattr(self, "do_" + command.replace(" ", "_"), None)
            self.send((known() if known else f"could not understand: '{command}'").encode() + b"\n")

    def do_is_in_remote_control(self):
        if self.owner.options.model != "e":
            return "could not understand: 'is in remote control'"
        return "true" if self.owner.remote else "false"

    def do_get_robot_model(self):
        """A controller of the e-Series answers without the letter e."""
        return self.owner.options.robot or "could not understand: 'get robot model'"

    def do_robotmode(self):
        return "Robotmode: " + ROBOT_MODES[self.owner.robot_mode]

    def do_safetymode(self):
        return "Safetymode: " + SAFETY_MODES[self.owner.safety_mode]

    def do_power_on(self):
        owner = self.owner
        if owner.safety_mode != NORMAL:
            return "Failed to power on"
        if owner.robot_mode == POWER_OFF:
            owner.robot_mode = BOOTING
            if not owner.options.boots_never:
                owner.after(0.2, lambda: setattr(owner, "robot_mode", IDLE))
        return "Powering on"

    def do_brake_release(self):
        owner = self.owner
        owner.brake_releases += 1
        if owner.robot_mode != IDLE:
            return "Failed to release the brakes"
        owner.after(0.2, lambda: setattr(owner, "robot_mode", RUNNING))
        return "Brake releasing"

    def do_power_off(self):
        self.owner.end_program()
        self.owner.robot_mode = POWER_OFF
        return "Powering off"

    def do_unlock_protective_stop(self):
        owner = self.owner
        if owner.now - owner.stopped_at < owner.options.unlock_after:
            return f"Cannot unlock protective stop until {owner.options.unlock_after:g}s after occurrence."
        owner.safety_mode = NORMAL
        return "Protective stop releasing"

    def do_stop(self):
        self.owner.end_program()
        return "Stopped"


class ControlClient(Connection):
    """A test. Its lines are the names of Orders' methods and words."""

    def __init__(self, owner, own_socket):
        super().__init__(owner, own_socket, ControlClient.handle, "control")

    def flush(self):
        if self.waiting and not self.closed:
            self.socket.setblocking(True)
            self.socket.sendall(self.waiting)
            self.socket.setblocking(False)
            self.waiting = b""

    def ready(self):
        data = self.socket.recv(65536)
        if not data:
            return self.close()
        self.received += data
        return self.handle()

    def handle(self):
        while b"\n" in self.received:
            line, self.received = self.received.split(b"\n", 1)
            result = orders.obey(Orders, self.owner, line)
            self.send((json.dumps(result) + "\n").encode())


class Orders:
    """What a test can do to the controller."""

    @staticmethod
    def state(c):
        return {"q": c.joints.q, "qd": c.joints.qd, "robot_mode": c.robot_mode, "safety_mode": c.safety_mode,
                "runtime_state": c.runtime_state(), "slider": c.slider, "programs": c.programs, "dashboards": c.dashboards, "messages": c.messages[-5:],
                "fastest": c.joints.fastest, "strongest": c.joints.strongest, "rtde_clients": len(c.rtde), "now": c.now, "brake_releases": c.brake_releases, **c.jumps}

    @staticmethod
    def forget(c):
        """`first` is that of the next set-point."""
        c.jumps = dict(JUMPS)
        c.joints.fastest = c.joints.strongest = 0.0

    @staticmethod
    def protective_stop(c):
        c.safety_mode, c.stopped_at = PROTECTIVE, c.now
        c.end_program()

    @staticmethod
    def emergency_stop(c):
        c.safety_mode, c.robot_mode = EMERGENCY, POWER_OFF
        c.end_program()

    @staticmethod
    def booted(c):
        """The robot is on, and its brakes, too."""
        c.robot_mode = IDLE

    @staticmethod
    def release_emergency_stop(c):
        c.safety_mode = NORMAL

    @staticmethod
    def safeguard(c, closed):
        """An open safeguard pauses the program; it goes on when the safeguard is closed."""
        c.safety_mode = NORMAL if closed == "closed" else SAFEGUARD
        if closed == "closed":
            c.paused = False
        else:
            c.pause()

    @staticmethod
    def stop_program(c):
        c.end_program()

    @staticmethod
    def pause_program(c):
        c.pause()

    @staticmethod
    def play_program(c):
        c.paused = False

    @staticmethod
    def foreign_program(c):
        c.start("def other():\n  while True:\n    sync()\n  end\nend\n")

    @staticmethod
    def jog(c, *q):
        """A person moves the robot at the teach pendant; a program that runs ends."""
        c.end_program()
        c.joints.command = ([float(value) for value in q], 0.5)

    @staticmethod
    def slider(c, fraction):
        c.slider = float(fraction)

    @staticmethod
    def digital_input(c, bit, value):
        c.digital_inputs = c.digital_inputs & ~(1 << int(bit)) | int(value) << int(bit)

    @staticmethod
    def analog_input(c, index, value):
        c.analog_inputs[int(index)] = float(value)

    @staticmethod
    def outputs(c):
        return {"digital": c.digital_outputs, "analog": c.analog_outputs}

    @staticmethod
    def remote_control(c, on):
        c.remote = on == "on"

    @staticmethod
    def not_found(c, *names):
        c.not_found = set(names)

    @staticmethod
    def kinematics(c, form):
        """On the next connections: sent, missing, truncated, endless (longer than its package) or nan."""
        c.kinematics = form

    @staticmethod
    def in_use(c, *names):
        c.in_use = set(names)

    @staticmethod
    def halves(c, on):
        """Sends each package in two parts, a cycle apart."""
        c.halves = on == "on"

    @staticmethod
    def cable(c, state):
        """Pulled: nothing arrives and nothing leaves; connections stay open."""
        if state == "pulled":
            c.cut_cable()
        else:
            c.plug_cable()

    @staticmethod
    def linger(c, seconds):
        """After a cut the controller keeps connections for this time: their RTDE inputs are in use, and no program can connect."""
        c.linger = float(seconds)

    @staticmethod
    def delay(c, seconds):
        """RTDE data of this time arrive all at its end."""
        c.delayed_until = c.cycles + round(float(seconds) / c.period)

    @staticmethod
    def restart(c, seconds=2.0):
        """Connections close, nothing listens for this time, then the robot is off."""
        c.restart(float(seconds))

    @staticmethod
    def drop_connections(c, name=""):
        """Of that name, such as dashboard, or all but those of tests."""
        c.drop_connections(name)

    @staticmethod
    def dashboard(c, answers):
        """Silent: it takes commands, and answers none."""
        c.dashboard_silent = answers == "silent"


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=orders.listed(Orders), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", default="127.0.0.11", help="on which it listens")
    parser.add_argument("--start", type=lambda text: [float(q) for q in text.split(",")], default=[0.0, -1.57, 1.57, -1.57, -1.57, 0.0],
                        help="joint positions [rad], between commas")
    parser.add_argument("--model", choices=PERIODS, default="e")
    parser.add_argument("--robot", default="UR5", help="answer of the dashboard to `get robot model`; empty: it does not know the command")
    parser.add_argument("--size", choices=LENGTHS, help="type whose lengths it has (default: ur5e, or ur5 of a CB3)")
    parser.add_argument("--calibration", type=float, default=0.0, help="0: the published lengths; 1: the flange is 2 mm from there")
    parser.add_argument("--off", action="store_true", help="begins without power")
    parser.add_argument("--boots-never", action="store_true", help="is on only after the order booted")
    parser.add_argument("--unlock-after", type=float, default=5.0, help="earliest time after a protective stop [s]")
    options = parser.parse_args()
    options.size = options.size or ("ur5e" if options.model == "e" else "ur5")
    controller = Controller(options)
    print(f"controller on {options.address}", flush=True)
    controller.run()


if __name__ == "__main__":
    main()
