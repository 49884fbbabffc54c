"""Runs a live cell in which simulated controllers on the network move the arms: a UR5e, an IRB 120 by EGM, a Panda by ros2_control.

usage: device_cell.py --programs DIR [--cell FILE] [--tasks 30] [--seed 7] [--events 0] [--timeout-scale 1] [--report FILE] [--view]

All arms move at once between random goals that conflict. With --events N, things happen to the controllers meanwhile, which the seed draws:
protective stops, ended programs, another speed, pulled cables, restarts. The arm must be held, with a fault of the kind that
the pages of its device name, within the limit of this event times --timeout-scale. It must stay held until it is resumed, and begin where it
stands. Goals then go on until N events have happened. A contact, a jump of the set-points and a fault beyond its limit fail the run. Faults of arms that nothing has caused are printed: a late machine causes some.

Exit codes: 0 done; 1 something failed, which is printed; 70 something unsafe happened; 77 the simulator of ros2_control was not built."""
import argparse
import json
import math
import pathlib
import random
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

import yaml

ROBOTS = pathlib.Path(__file__).resolve().parent
CELL = ROBOTS.parent.parent / "deploy" / "cells" / "three_makers.yaml"
UNSAFE = 70
SKIPPED = 77
PATIENCE = 120.0  # [s] far longer than anything takes; ends a run that hangs
ORDERS = 30999  # TCP port of a controller
STANDS = 0.02  # [rad/s] of the fastest joint, with the noise of a servo
FIRST = 0.01  # [rad] largest distance of a first set-point from the measured position
# Largest times from an event until the cell names it [s]: of a stop that the controller reports, and of silence, which counts late.
STOP, SILENCE = 2.0, 3.0
# Set-points move at most twice as fast as the velocity limits. After a longer pause the driver allows no larger step [s]: kLongestPause of
# services/arm_driver/devices/largest_step.hpp.
LONGEST_PAUSE = 0.1


class Failed(Exception):
    code = 1


class Unsafe(Failed):
    code = UNSAFE


class Controller:
    """A simulated controller of the arm of this name."""

    address = ""
    unit = 1.0  # of its angles [rad]
    pause = LONGEST_PAUSE  # [s] of set-points, as the controller sees them
    begin = []  # orders after which it is ready again

    def __init__(self, arm, programs, joints, home, logs):
        self.arm, self.home = arm, home
        with open(logs / f"controller-{arm}.log", "w") as log:
            self._process = subprocess.Popen(self.command(programs, joints, home), stdin=subprocess.PIPE, stdout=log, stderr=log)
        self.wait_for("its controller answers", self._connects)

    def command(self, programs, joints, home):
        raise NotImplementedError

    def events(self):
        """By name: the kind of the fault, None where the arm goes on at another speed; the limit for the time until the cell names it; what
        causes it; and what a person does, in orders. An order that begins with `hecaton` is one to the cell."""
        raise NotImplementedError

    def order(self, line):
        """Returns the answer."""
        with socket.create_connection((self.address, ORDERS), PATIENCE) as connection:
            connection.sendall(line.encode() + b"\n")
            answer = json.loads(connection.makefile().readline())
        if isinstance(answer, dict) and "error" in answer:
            raise Failed(f"controller of {self.arm}: {line}: {answer['error']}")
        return answer

    def wait_for(self, what, condition):
        until = time.monotonic() + PATIENCE
        while not condition():
            if self._process.poll() is not None:
                raise Failed(f"the controller of {self.arm} has ended with {self._process.returncode}")
            if time.monotonic() > until:
                raise Failed(f"{self.arm}: {what}: not within {PATIENCE:g} s")
            time.sleep(0.02)  # a controller answers, but announces nothing

    def _connects(self):
        try:
            return self.order("state") is not None
        except OSError:
            return False

    def stop(self):
        self._process.terminate()
        self._process.wait()


class UniversalRobots(Controller):
    address = "127.0.0.11"
    pause = 0.002  # the program gives one in each cycle, and limits their steps, also when packets are late

    def command(self, programs, joints, home):
        return [sys.executable, ROBOTS / "ur_controller.py", "--address", self.address, "--unlock-after", "0.5",
                "--start=" + ",".join(f"{q:.6f}" for q in home)]

    def events(self):
        return {"protective stop": ("protective_stop", STOP, ["protective_stop"], ["hecaton device ur unlock"]),
                "emergency stop": ("emergency_stop", STOP, ["emergency_stop"], ["release_emergency_stop", "hecaton device ur on"]),
                "program stopped": ("program_stopped", STOP, ["stop_program"], []),
                "cable pulled": ("arm_failed", SILENCE, ["cable pulled"], ["cable plugged"]),
                "controller restarts": ("arm_failed", SILENCE, ["restart 3"], ["hecaton device ur on"]),
                "speed slider": (None, STOP, ["slider 0.4"], ["slider 1"])}


class Abb(Controller):
    address = "127.0.0.12"
    unit = math.radians(1.0)
    begin = ["motors on", "program start"]

    def command(self, programs, joints, home):
        return [sys.executable, ROBOTS / "abb_controller.py", "--to", "127.0.0.1:6510", "--address", self.address, "--comm-timeout", "5",
                "--start=" + ",".join(f"{math.degrees(q):.4f}" for q in home)]

    def events(self):
        # EGM reports no speed: docs/how-to/abb-egm.md.
        return {"motors off": ("device_not_ready", STOP, ["motors off"], self.begin),
                "EGM stopped": ("program_stopped", STOP, ["egm_stop"], []),
                "program stopped": ("program_stopped", STOP, ["program stop"], ["program start"]),
                "cable pulled": ("arm_failed", SILENCE, ["cable pulled"], ["cable plugged", *self.begin]),
                "controller restarts": ("arm_failed", SILENCE, ["restart"], self.begin)}


class Ros2Control(Controller):
    address = "127.0.0.13"

    def command(self, programs, joints, home):
        return [programs / "ros2_controller", "--domain", "46", "--controller", "panda_arm_controller", "--address", self.address,
                "--from-desired", "--joints", ",".join(joints), "--start", ",".join(f"{q:.6f}" for q in home)]

    def events(self):
        # An inactive controller is silent.
        return {"controller inactive": ("program_stopped", SILENCE, ["deactivate"], ["activate"]),
                "no joint states": ("arm_failed", SILENCE, ["silence on"], ["silence off"]),
                "controller restarts": ("arm_failed", SILENCE, ["restart 4"], []),
                "speed scaling": (None, STOP, ["slow 0.4"], ["slow 1"])}


class Cell:
    """The cell, through `hecaton`."""

    def __init__(self, options, logs):
        self._hecaton, self._file, self._logs = options.programs / "hecaton", options.cell, logs
        self._status, self._changed = None, threading.Condition()
        self._faults = {}
        self.doing = "the start"  # the event that happens now
        self.closest = {}  # by kind of pair: the smallest separation, and what the arms did then
        self._log = open(logs / "up.log", "w")
        # With a view, its address is for a person.
        self._up = self._start("up", self._file, "--headless", "--log-dir", logs / "cell", *(["--view"] if options.view else []),
                               stdout=None if options.view else self._log)
        self._watch = self._start("status", "--watch", "--interval", "100ms", "-o", "json", "--connect-timeout", f"{PATIENCE}s",
                                  "--cell", self._file, stdout=subprocess.PIPE, text=True)
        threading.Thread(target=self._read, daemon=True).start()

    def _start(self, *words, **streams):
        return subprocess.Popen([self._hecaton, *words], stderr=self._log, **streams)

    def _read(self):
        for line in self._watch.stdout:
            with self._changed:
                self._status = json.loads(line)
                self._faults.update({fault["id"]: fault for fault in self._status["faults"]})
                self._note_closest()
                self._changed.notify_all()

    def _note_closest(self):
        for kind in (self._status["contact_report"] or {}).get("kinds", []):
            pair, known = kind["closest_pair"], self.closest.get(kind["kind"])
            if pair and (known is None or pair["distance_m"] < known["distance_m"]):
                self.closest[kind["kind"]] = {**pair, "during": self.doing, "arms": {
                    arm["name"]: [arm["mode"], arm["state"]["mode"], max(map(abs, arm["state"]["qd"]), default=None)]
                    for arm in self._status["arms"] if arm["state"]}}

    def stop(self):
        self._watch.terminate()
        self._up.send_signal(signal.SIGINT)
        self._up.wait()
        self._log.close()

    def status(self):
        with self._changed:
            return self._status

    def faults(self):
        """All so far, by id."""
        with self._changed:
            return dict(self._faults)

    def arm(self, name):
        return arm_in(self.status(), name)

    def wait_for(self, what, condition, patience=PATIENCE):
        """Waits until condition(status) is true; returns its value. Without patience it returns None at the end."""
        until = time.monotonic() + patience
        with self._changed:
            while True:
                found = condition(self._status) if self._status else None
                if found:
                    return found
                if self._up.poll() is not None:
                    raise Failed(f"hecaton up has ended with {self._up.returncode}")
                if self._changed.wait(until - time.monotonic()):
                    continue
                if patience < PATIENCE:
                    return None
                raise Failed(f"{what}: not within {patience:g} s; {self.ask('status')[1]}")

    def ask(self, *words):
        """Returns the exit code and what was said."""
        done = subprocess.run([self._hecaton, *words, "--cell", self._file, "--connect-timeout", "10s"], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def insist(self, *words):
        """Repeats an order until it is obeyed."""
        until = time.monotonic() + PATIENCE
        while (answer := self.ask(*words))[0] != 0:
            if time.monotonic() > until:
                raise Failed(f"hecaton {' '.join(words)}: {answer[1]}")


def arm_in(status, name):
    return next(arm for arm in status["arms"] if arm["name"] == name)


def open_faults(status, arm):
    return [fault for fault in status["faults"] if fault["subject"] == arm and not fault["cleared"]]


class Goals(threading.Thread):
    """Gives one arm goals, one after the other, until `done` is set."""

    def __init__(self, cell, arm, area, seed, done, enough):
        super().__init__(daemon=True)
        self._cell, self._arm, self._area, self._done, self._enough = cell, arm, area, done, enough
        self._rng = random.Random(seed)
        self.reached, self.ended, self.seconds = 0, 0, []

    def run(self):
        while not self._done.is_set():
            if self._cell.arm(self._arm)["mode"] != "run":
                self._cell.wait_for("a status", lambda status: arm_in(status, self._arm)["mode"] == "run", 5.0)
                continue
            began = time.monotonic()
            code, _ = self._cell.ask("goal", self._arm, "--position", *self._draw(), "--time-limit", "30s", "--wait")
            if code == 0:
                self.reached += 1
                self.seconds.append(time.monotonic() - began)
            elif code == 4:
                self.ended += 1  # too late
            self._enough()

    def _draw(self):
        radius, angle = self._area["radius"] * self._rng.random() ** 0.5, self._rng.uniform(0, 6.2832)
        offset = (radius * math.cos(angle), radius * math.sin(angle), self._area["half_height"] * self._rng.uniform(-1, 1))
        return [f"{centre + by:.4f}" for centre, by in zip(self._area["centre"], offset)]


class Run:
    def __init__(self, options, logs):
        self.options = options
        programs, document = options.programs, yaml.safe_load(options.cell.read_text())
        described = json.loads(subprocess.run([programs / "hecaton", "check", options.cell, "-o", "json"], check=True,
                                              capture_output=True, text=True).stdout)
        self.controllers, self.limits = {}, {}
        self.cell = None
        self.area = document["tasks"]
        self.done = threading.Event()
        self.rows = {}  # by arm and event: seconds until the cell named it
        self.late = []  # events that the cell named beyond their limit
        self.caused = set()  # ids of faults
        self.uncaused = []  # faults of arms
        self.largest_first = 0.0  # [rad] distance of a first set-point from the measured position
        self.firsts = 0  # first set-points that were looked at
        self.fastest, self.largest = {}, {}  # by arm: of a joint [rad/s], of a step between set-points [rad]
        try:
            for arm, kind in zip(described["arms"], (UniversalRobots, Abb, Ros2Control)):
                joints = arm["model"]["joints"]
                self.limits[arm["name"]] = max(joint["velocity"] for joint in joints)
                self.controllers[arm["name"]] = kind(arm["name"], programs, [joint["name"] for joint in joints], arm["named"]["home"], logs)
            self.cell = Cell(options, logs)
        except BaseException:
            self.stop()
            raise

    def stop(self):
        self.done.set()
        if self.cell:
            self.cell.stop()
        for controller in self.controllers.values():
            controller.stop()

    def resume(self, arm):
        """What a person does once the robot is ready."""
        self.cell.wait_for(f"{arm} has no fault", lambda status: arm_in(status, arm)["state"]["q"] and not open_faults(status, arm))
        if wrong := self.judge(arm):
            raise Unsafe(wrong)
        self.controllers[arm].order("forget")
        self.cell.insist("resume", arm)
        self.cell.wait_for(f"{arm} may move", lambda status: arm_in(status, arm)["mode"] == "run")

    def resume_held(self, arm):
        """Of an arm that is held. The first set-point must be where it stands."""
        controller = self.controllers[arm]
        self.resume(arm)
        # A late machine may stop it before.
        controller.wait_for("a first set-point", lambda: controller.order("state")["first"] is not None or
                            self.cell.arm(arm)["mode"] != "run")
        first = controller.order("state")["first"]
        if first is None:
            return
        self.firsts += 1
        first *= controller.unit
        self.largest_first = max(self.largest_first, first)
        if first > FIRST:
            raise Unsafe(f"{arm}: its first set-point after a resume is {first:.4f} rad from where it stands")

    def judge(self, arm):
        """What was wrong since the last order to forget, as the controller has seen it; empty: nothing."""
        controller, limit = self.controllers[arm], self.limits[arm]
        state = controller.order("state")
        fastest, largest = state["fastest"] * controller.unit, state["largest"] * controller.unit
        self.fastest[arm], self.largest[arm] = max(self.fastest.get(arm, 0.0), fastest), max(self.largest.get(arm, 0.0), largest)
        if fastest > 1.1 * limit:
            return f"{arm} moved at {fastest:.2f} rad/s (limit {limit:.2f})"
        return f"{arm}: its set-points jumped by {largest:.4f} rad" if largest > 2.0 * limit * controller.pause + 1e-6 else ""

    def speed(self, arm):
        """Of the fastest joint, from the controller [rad/s]."""
        controller = self.controllers[arm]
        return max(map(abs, controller.order("state")["qd"])) * controller.unit

    def moving_arm(self, rng):
        """One that moves: of an arm that was resumed and not commanded since, nothing can stop."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            arm = rng.choice(list(self.controllers))
            patience = time.monotonic() + 5.0
            while time.monotonic() < patience:
                if self.speed(arm) > 10 * STANDS:
                    return arm
                time.sleep(0.02)  # a controller announces nothing
            self.look_after()
        raise Failed(f"no arm moves within {PATIENCE:g} s")

    def happen(self, number, rng):
        arm = self.moving_arm(rng)
        controller = self.controllers[arm]
        name, (kind, limit, causes, remedies) = rng.choice(list(controller.events().items()))
        self.cell.doing = f"{name}, {arm}"
        known = set(self.cell.faults())
        began = time.monotonic()
        for cause in causes:
            controller.order(cause)
        if kind is None:
            self.cell.wait_for(f"{arm} is slower", lambda status: arm_in(status, arm)["state"]["speed_scaling"] < 0.5)
            self.named(arm, name, time.monotonic() - began, limit)
            before = self.cell.status()
            self.cell.wait_for("some seconds", lambda status: status["uptime_s"] > before["uptime_s"] + 2.0)
        else:
            self.cell.wait_for(f"{name} of {arm} is a fault {kind}", lambda status: any(
                fault["kind"] == kind and fault["subject"] == arm and fault["id"] not in known for fault in status["faults"]))
            self.named(arm, name, time.monotonic() - began, limit)
            self.cell.wait_for(f"{arm} is held", lambda status: arm_in(status, arm)["mode"] == "hold")
            if name != "cable pulled":
                controller.wait_for("it stands", lambda: self.speed(arm) < STANDS)
        for remedy in remedies:
            if remedy.startswith("hecaton "):
                self.cell.insist(*remedy.split()[1:])
            else:
                controller.order(remedy)
        if kind is None:
            self.cell.wait_for(f"{arm} is as fast as before", lambda status: arm_in(status, arm)["state"]["speed_scaling"] > 0.99)
        else:
            self.cell.wait_for(f"{arm} is ready", lambda status: not open_faults(status, arm))
            if self.cell.arm(arm)["mode"] != "hold":
                raise Unsafe(f"{arm} may move after {name} without a person")
            self.resume_held(arm)
        self.caused |= {id for id, fault in self.cell.faults().items() if id not in known and fault["subject"] == arm}
        self.cell.doing = f"after {name}, {arm}"
        print(f"{number} of {self.options.events}: {name}, {arm}", file=sys.stderr, flush=True)

    def named(self, arm, name, seconds, limit):
        self.rows.setdefault((arm, name), []).append(seconds)
        limit *= self.options.timeout_scale
        if seconds > limit:
            self.late.append(f"{name} of {arm} was named after {seconds:.2f} s (limit {limit:g} s)")

    def look_after(self):
        """Resumes arms that stopped without an event."""
        held = [arm for arm in self.controllers if self.cell.arm(arm)["mode"] == "hold"]
        for arm in held:
            for order in self.controllers[arm].begin:
                self.controllers[arm].order(order)
            self.resume_held(arm)
        wrong = {id: fault for id, fault in self.cell.faults().items() if id not in self.caused and fault["subject"] in self.controllers}
        self.uncaused += wrong.values()
        self.caused |= set(wrong)

    def run(self):
        self.cell.wait_for("a state of each arm", lambda status: all(arm["state"] and arm["state"]["q"] for arm in status["arms"]))
        for arm in self.controllers:
            self.resume(arm)  # it may move already, to give way
        self.caused = set(self.cell.faults())  # of the start
        began = time.monotonic()
        wanted = threading.Event()

        def enough():
            if sum(goals.reached + goals.ended for goals in givers) >= self.options.tasks:
                wanted.set()

        givers = [Goals(self.cell, arm, self.area, f"{self.options.seed} {arm}", self.done, enough) for arm in self.controllers]
        for giver in givers:
            giver.start()
        rng = random.Random(self.options.seed)
        for number in range(1, self.options.events + 1):
            self.happen(number, rng)
            self.look_after()
        while not wanted.wait(1.0):
            self.look_after()
        status = self.cell.status()
        self.done.set()
        return self.report(givers, status, time.monotonic() - began)

    def report(self, givers, status, seconds):
        contact = status["contact_report"] or {}
        times = sorted(second for giver in givers for second in giver.seconds)
        failed = [wrong for arm in self.controllers if (wrong := self.judge(arm))]
        result = {"goals_reached": sum(giver.reached for giver in givers), "goals_late": sum(giver.ended for giver in givers),
                  "contacts": contact.get("contacts"), "min_separation_m": contact.get("min_separation_m"), "closest": self.cell.closest,
                  "p50_s": times[len(times) // 2] if times else None, "p95_s": times[int(0.95 * len(times))] if times else None,
                  "duration_s": seconds, "first_set_points": self.firsts, "largest_first_rad": self.largest_first,
                  "largest_step_rad": self.largest, "fastest_rad_s": self.fastest,
                  "faults_without_event": len(self.uncaused),
                  "events": [{"arm": arm, "event": name, "n": len(rows), "named_p50_s": statistics.median(rows), "named_max_s": max(rows),
                              "limit_s": self.controllers[arm].events()[name][1] * self.options.timeout_scale}
                             for (arm, name), rows in sorted(self.rows.items())],
                  "events_beyond_limit": self.late}
        print(f"{result['goals_reached']} goals reached, {result['goals_late']} too late; {result['contacts']} contacts; smallest separation "
              f"{1000 * (result['min_separation_m'] or 0):.0f} mm; p50 {result['p50_s'] or 0:.2f} s, p95 {result['p95_s'] or 0:.2f} s, of which "
              "the start of each client is a part")
        for kind, pair in result["closest"].items():
            print(f"nearest, {kind}: {1000 * pair['distance_m']:.0f} mm, {pair['a']} – {pair['b']}, during {pair['during']}")
        for row in result["events"]:
            print(f"{row['arm']:6} {row['event']:22} {row['n']:4}  named after {row['named_p50_s']:.2f} s, at most {row['named_max_s']:.2f} s "
                  f"(limit {row['limit_s']:g} s)")
        print(f"{self.firsts} first set-points after a resume: at most {self.largest_first:.4f} rad from where the arm stood")
        for arm, limit in self.limits.items():
            print(f"{arm:6} moved at {self.fastest[arm]:.2f} rad/s at most (limit {limit:.2f}); largest step of its set-points {self.largest[arm]:.4f} rad")
        for fault in self.uncaused:
            print(f"without an event: {fault['kind']}: {fault['description']}")
        if self.options.report:
            self.options.report.write_text(json.dumps(result, indent=2) + "\n")
        failed += [f"{result['contacts']} contacts"] if result["contacts"] != 0 else []
        if failed:
            raise Unsafe("; ".join(failed))
        if self.late:
            raise Failed("; ".join(self.late))


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--cell", type=pathlib.Path, default=CELL)
    parser.add_argument("--tasks", type=int, default=30)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--events", type=int, default=0)
    parser.add_argument("--timeout-scale", type=float, default=1.0)
    parser.add_argument("--report", type=pathlib.Path)
    parser.add_argument("--view", action="store_true")
    return parser.parse_args()


def main():
    options = parse()
    if not (options.programs / "ros2_controller").exists():
        print(f"{options.programs / 'ros2_controller'} was not built: it needs Cyclone DDS, which ./run test installs", file=sys.stderr)
        return SKIPPED
    logs = pathlib.Path(tempfile.mkdtemp(prefix="hecaton-devices-"))
    run = None
    try:
        run = Run(options, logs)
        run.run()
    except Failed as error:
        print(f"{error}\nlogs are in {logs}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130
    finally:
        if run:
            run.stop()
    shutil.rmtree(logs, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
