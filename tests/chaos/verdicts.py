"""Which faults the cell must and may report for the injections of an episode.

usage: verdicts.py --self-test"""
import sys
import unittest

from injections import FAILOVER, Absence, Cut, Deafen, FillDisk, Kill, KillAgent, Lose, Mute, OfNode, Pause, SlowDown, Split, \
    StepClock, Stop, is_supervisor, surely_reported, together

# [s] longest time for which a supervisor explains silent processes by the return of their host. For a supervisor that was cut off
# itself, all hosts return.
RETURN = 6.0
MOVED = 1.0  # [s] from a leader's last message until another leads and this is observed


def supervisors_hit(injections, places):
    return set().union(*(injection.hits(places) for injection in injections))


def hidden(injection, injections, places, leader):
    """True if other injections may prevent the report. `leader`: the supervisor that led before.

    A standby evaluates all messages as well, and when it begins to lead, it reports the deaths that its predecessor did not. It does
    not report a silence that has ended, nor what it has not received. A leader that receives nothing stays leader until the
    standby's matrix shows this; later it gets deaths from the agents, as far as these still send them."""
    others = [other for other in injections if other is not injection]
    if not others:
        return False
    if isinstance(injection, Absence) and left_alone(injections, places):
        return True
    if supervisors_hit(injections, places) >= set(filter(is_supervisor, places)):
        return True
    hitting = [other for other in others if leader in other.hits(places)]
    if isinstance(injection, Kill):
        return any(isinstance(other, Deafen) for other in hitting)
    if any(not isinstance(other, Kill) for other in hitting):
        return True
    return bool(hitting) and isinstance(injection, Stop) and injection.duration < surely_reported(injection.limit()) + FAILOVER


def left(injections, places):
    """The places on hosts that none of the injections removes."""
    gone = {injection.host for injection in injections if isinstance(injection, Absence)}
    return {node: host for node, host in places.items() if host not in gone}


def left_alone(injections, places):
    """The single remaining host, if any, whose supervisor regards itself as lost instead of all others."""
    there = left(injections, places)
    hosts = set(there.values())
    watched = any(map(is_supervisor, there))
    return hosts if watched and len(hosts) == 1 < len(set(places.values())) - 1 else set()


def remaining_places(injection, injections, places):
    """The places that the other injections leave. With one other host, a supervisor cannot know which of the two is lost."""
    return left([other for other in injections if other is not injection], places)


def may_be_reported(injections, places):
    """(kind, subject) of all faults that are correct."""
    blind = bool(supervisors_hit(injections, places))
    of_itself = {("host_lost", host) for host in left_alone(injections, places)}
    return of_itself.union(*(injection.may(remaining_places(injection, injections, places), blind) for injection in injections))


def may_change_leader(injection, places):
    """True if the leader may change because of it. All hosts share the processors of this machine."""
    if isinstance(injection, OfNode):
        return is_supervisor(injection.node)
    return isinstance(injection, SlowDown) or any(map(is_supervisor, injection.nodes(places)))


def pardoned(moves, injected, lasted):
    """True if one of these changes of leader [ms, wall clock] coincides with a fault that began at `injected` [ms] and lasted
    `lasted` [s]. A new leader reports what is wrong when it begins to lead, and takes silent nodes for returning ones at first."""
    return any(injected - 1000 * RETURN <= move <= injected + 1000 * (lasted + MOVED) for move in moves)


# The cell of these tests.
PLACES = {"supervisor": "supervisor-pc", "supervisor@world-pc": "world-pc", "world": "world-pc",
          "driver/north": "north-pc", "planner/north": "north-pc", "planner/north@west-pc": "west-pc"}


def lasting(injection, seconds=None):
    injection.lasted = injection.duration if seconds is None else seconds
    return injection


class MayTest(unittest.TestCase):
    def may(self, *injections):
        return may_be_reported(injections, PLACES)

    def test_kill_may_be_reported_as_death_only(self):
        self.assertEqual(self.may(Kill("driver/north", "north-pc")), {("process_died", "driver/north")})

    def test_stop_may_be_reported_as_silence_of_node_and_stream(self):
        self.assertEqual(self.may(Stop("driver/north", "north-pc", 2.0)),
                         {("node_silent", "driver/north"), ("driver_silent", "north")})
        self.assertEqual(self.may(Stop("planner/north", "north-pc", 2.0)), {("node_silent", "planner/north")})

    def test_cut_host_is_lost_and_its_nodes_may_return_late(self):
        self.assertEqual(self.may(lasting(Cut("north-pc", 2.0))),
                         {("host_lost", "north-pc"), ("node_silent", "agent/north-pc"), ("node_silent", "driver/north"),
                          ("driver_silent", "north"),
                          ("node_silent", "planner/north")})

    def test_degraded_host_has_no_fault(self):
        self.assertEqual(self.may(Lose("world-pc", 2.0, 30), SlowDown("supervisor-pc", 2.0), FillDisk("world-pc", 2.0),
                                  StepClock("supervisor-pc", 2.0, -60)), set())

    def test_hit_supervisor_reports_no_other_host(self):
        for injection in (Cut("supervisor-pc", 2.0), Mute("world-pc", 2.0), Deafen("supervisor-pc", 2.0), Pause("supervisor-pc", 2.0),
                          KillAgent("supervisor-pc", 2.0), Kill("supervisor", "supervisor-pc"),
                          Stop("supervisor", "supervisor-pc", 2.0)):
            may = self.may(lasting(injection))
            self.assertNotIn(("host_lost", "north-pc"), may, injection)
            self.assertNotIn(("node_silent", "driver/north"), may, injection)

    def test_with_two_hosts_the_other_is_lost_after_a_long_cut(self):
        places = {"supervisor": "here", "driver/north": "there"}
        for seconds, accused in (0.4, False), (1.1, True):
            may = may_be_reported([lasting(Cut("here", 0.4), seconds)], places)
            self.assertEqual(("host_lost", "there") in may, accused, seconds)

    def test_with_a_third_host_gone_the_other_is_lost(self):
        places = {"supervisor": "here", "driver/north": "there", "world": "elsewhere"}
        cut = lasting(Cut("here", 2.0))
        for other, accused in (KillAgent("elsewhere", 2.0), True), (Kill("world", "elsewhere"), False):
            self.assertEqual(("host_lost", "there") in may_be_reported([cut, lasting(other)], places), accused, str(other))
        self.assertNotIn(("host_lost", "there"), may_be_reported([cut], places))

    def test_death_may_be_silence_only_if_a_supervisor_missed_it(self):
        death = Kill("planner/north", "north-pc")
        self.assertNotIn(("node_silent", "planner/north"), self.may(death, lasting(Cut("west-pc", 2.0))))
        self.assertIn(("node_silent", "planner/north"), self.may(death, lasting(Cut("supervisor-pc", 0.3))))


class HiddenTest(unittest.TestCase):
    DEATH = Kill("planner/north", "north-pc")

    def hidden(self, injection, *others, leader="supervisor"):
        return hidden(injection, [*others, injection], PLACES, leader)

    def test_single_fault_is_not_hidden(self):
        self.assertFalse(self.hidden(Stop("supervisor", "supervisor-pc", 2.0)))

    def test_faults_of_other_hosts_hide_nothing(self):
        self.assertFalse(self.hidden(self.DEATH, Cut("west-pc", 2.0), SlowDown("supervisor-pc", 2.0)))

    def test_faults_of_the_standby_hide_nothing(self):
        for other in (Stop("supervisor@world-pc", "world-pc", 2.0), Kill("supervisor@world-pc", "world-pc"),
                      Cut("world-pc", 2.0)):
            self.assertFalse(self.hidden(self.DEATH, other), other)

    def test_hung_leader_hides_silence_but_no_death(self):
        silence = Stop("planner/north", "north-pc", 0.7)
        for other in Stop("supervisor@world-pc", "world-pc", 2.0), Cut("world-pc", 2.0), Pause("world-pc", 0.3):
            self.assertTrue(self.hidden(silence, other, leader="supervisor@world-pc"), other)
            self.assertFalse(self.hidden(self.DEATH, other, leader="supervisor@world-pc"), other)

    def test_deaf_leader_may_hide_a_death(self):
        self.assertTrue(self.hidden(self.DEATH, Deafen("supervisor-pc", 2.0)))

    def test_faults_of_the_leader_are_reported(self):
        self.assertFalse(self.hidden(Cut("supervisor-pc", 2.5), self.DEATH))

    def test_killed_leader_hides_only_faults_that_end_before_failover(self):
        other = Kill("supervisor", "supervisor-pc")
        self.assertFalse(self.hidden(self.DEATH, other))
        self.assertTrue(self.hidden(Stop("planner/north", "north-pc", 0.7), other))
        self.assertFalse(self.hidden(Stop("planner/north", "north-pc", 2.0), other))

    def test_without_healthy_supervisor_all_may_be_hidden(self):
        self.assertTrue(self.hidden(self.DEATH, Kill("supervisor", "supervisor-pc"),
                                    Stop("supervisor@world-pc", "world-pc", 2.0)))
        alone = {node: host for node, host in PLACES.items() if node != "supervisor@world-pc"}
        both = [self.DEATH, Kill("supervisor", "supervisor-pc")]
        self.assertTrue(hidden(self.DEATH, both, alone, "supervisor"))


    def test_supervisor_left_alone_reports_neither_host(self):
        places = {"supervisor": "here", "driver/north": "there", "world": "elsewhere"}
        both = Cut("there", 2.0), Mute("elsewhere", 2.0)
        for cut in both:
            self.assertTrue(hidden(cut, [*map(lasting, both)], places, "supervisor"))
        self.assertIn(("host_lost", "here"), may_be_reported(both, places))
        self.assertFalse(hidden(both[0], [both[0], Kill("world", "elsewhere")], places, "supervisor"))
        self.assertNotIn(("host_lost", "here"), may_be_reported([both[0], Kill("world", "elsewhere")], places))
        self.assertEqual(left_alone(both, places), {"here"})
        unwatched = {"supervisor": "elsewhere", "driver/north": "there", "world": "here"}
        self.assertEqual(left_alone(both, unwatched), set(), "there is no supervisor")


class LeadershipTest(unittest.TestCase):
    def test_faults_of_supervisors_hosts_and_processors_may_change_leader(self):
        for injection in (Kill("supervisor", "supervisor-pc"), Stop("supervisor@world-pc", "world-pc", 2.0), Cut("world-pc", 2.0),
                          Lose("supervisor-pc", 2.0, 30), FillDisk("world-pc", 2.0), SlowDown("north-pc", 2.0)):
            self.assertTrue(may_change_leader(injection, PLACES), injection)

    def test_split_may_if_it_separates_the_supervisors(self):
        for side, others, may in ((("supervisor-pc", "north-pc"), ("world-pc", "west-pc"), True),
                                  (("supervisor-pc", "world-pc"), ("north-pc", "west-pc"), False)):
            split = Split(side, others, {"supervisor-pc", "world-pc"}, 2.0)
            self.assertEqual(may_change_leader(split, PLACES), may)

    def test_faults_elsewhere_may_not(self):
        for injection in (Kill("planner/north", "north-pc"), Stop("world", "world-pc", 2.0), Cut("north-pc", 2.0),
                          Lose("west-pc", 2.0, 30), KillAgent("north-pc", 2.0)):
            self.assertFalse(may_change_leader(injection, PLACES), injection)

    def test_leader_change_pardons_faults_at_that_time(self):
        for move, injected, lasted in (10_000, 10_000, 0.0), (10_000, 8_500, 1.0), (10_000, 15_900, 2.0), (10_000, 9_100, 0.0):
            self.assertTrue(pardoned([0, move], injected, lasted), (move, injected, lasted))

    def test_leader_change_pardons_nothing_else(self):
        for move, injected, lasted in (10_000, 16_100, 2.0), (10_000, 8_900, 0.0), (10_000, 7_000, 1.9):
            self.assertFalse(pardoned([move], injected, lasted), (move, injected, lasted))
        self.assertFalse(pardoned([], 0, 1.0))


class TogetherTest(unittest.TestCase):
    def test_two_processes_of_one_host(self):
        self.assertTrue(together(Kill("driver/north", "north-pc"), Stop("planner/north", "north-pc", 2.0)))
        self.assertFalse(together(Kill("driver/north", "north-pc"), Stop("driver/north", "north-pc", 2.0)))

    def test_process_of_a_degraded_host(self):
        for host in (Lose("north-pc", 1.0, 30), SlowDown("north-pc", 1.0), FillDisk("north-pc", 1.0),
                     StepClock("north-pc", 1.0, 60)):
            self.assertTrue(together(host, Kill("driver/north", "north-pc")), host)
            self.assertTrue(together(Kill("driver/north", "north-pc"), host), host)
        self.assertTrue(together(FillDisk("world-pc", 1.0), Kill("world", "world-pc")))

    def test_no_process_of_a_lost_host(self):
        for host in Cut("north-pc", 1.0), Pause("north-pc", 1.0), KillAgent("north-pc", 1.0), Deafen("north-pc", 1.0):
            self.assertFalse(together(host, Kill("driver/north", "north-pc")), host)
            self.assertFalse(together(host, Lose("north-pc", 1.0, 30)), host)

    def test_nothing_else_with_a_split(self):
        self.assertFalse(together(Split(("north-pc", "west-pc"), ("world-pc",), set(), 1.0), Kill("world", "world-pc")))

    def test_two_hosts(self):
        self.assertTrue(together(Cut("north-pc", 1.0), Pause("west-pc", 1.0)))


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
