"""What of the injections of one episode the cell must tell, and what it may.

usage: verdicts.py --self-test"""
import sys
import unittest

from injections import FAILOVER, Absence, Cut, Deafen, FillDisk, Kill, KillAgent, Lose, Mute, OfNode, Pause, SlowDown, Split, \
    StepClock, Stop, is_supervisor, surely_told, together

# [s] for which a supervisor puts the silence of a host's processes down to its return: at most. One that was cut off itself sees
# every host return.
RETURN = 6.0
MOVED = 1.0  # [s] after a leader's last word until another leads, and that is seen


def supervisors_hit(injections, places):
    return set().union(*(injection.hits(places) for injection in injections))


def hidden(injection, injections, places, leader):
    """Whether others that happen beside it may keep it from being told, `leader` being the supervisor that led before.

    A standby hears and judges everything, too, and when it begins to lead tells the deaths that its predecessor did not. A silence
    that is over by then it does not tell, nor what it has not heard itself. A leader that is deaf leads on until the standby's
    matrix shows that, and hears of deaths from their agents when it hears again, as far as these still tell them."""
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
    return bool(hitting) and isinstance(injection, Stop) and injection.duration < surely_told(injection.limit()) + FAILOVER


def left(injections, places):
    """The places of hosts that none of them takes away."""
    gone = {injection.host for injection in injections if isinstance(injection, Absence)}
    return {node: host for node, host in places.items() if host not in gone}


def left_alone(injections, places):
    """The host, if it is only one, whose supervisor takes itself for lost rather than all others."""
    there = left(injections, places)
    hosts = set(there.values())
    watched = any(map(is_supervisor, there))
    return hosts if watched and len(hosts) == 1 < len(set(places.values())) - 1 else set()


def beside(injection, injections, places):
    """The places that are left to it by the others: who is alone with one host cannot know which of the two is lost."""
    return left([other for other in injections if other is not injection], places)


def may_be_told(injections, places):
    """(kind, subject) of all faults that are right."""
    blind = bool(supervisors_hit(injections, places))
    of_itself = {("host_lost", host) for host in left_alone(injections, places)}
    return of_itself.union(*(injection.may(beside(injection, injections, places), blind) for injection in injections))


def may_move_the_leadership(injection, places):
    """Whether another supervisor may lead after it. All hosts share the processors of this machine."""
    if isinstance(injection, OfNode):
        return is_supervisor(injection.node)
    return isinstance(injection, SlowDown) or any(map(is_supervisor, injection.nodes(places)))


def pardoned(moves, injected, lasted):
    """Whether one of these changes of the leadership [ms, wall clock] was when a fault that began at `injected` [ms] and lasted
    [s] happened. A new leader tells what is wrong when it begins to lead, and takes for a while what is silent for returning."""
    return any(injected - 1000 * RETURN <= move <= injected + 1000 * (lasted + MOVED) for move in moves)


# The cell of chaos, as far as it is asked for.
PLACES = {"supervisor": "supervisor-pc", "supervisor@world-pc": "world-pc", "world": "world-pc",
          "driver/north": "north-pc", "planner/north": "north-pc", "planner/north@west-pc": "west-pc"}


def lasting(injection, seconds=None):
    injection.lasted = injection.duration if seconds is None else seconds
    return injection


class MayTest(unittest.TestCase):
    def may(self, *injections):
        return may_be_told(injections, PLACES)

    def test_who_was_killed_has_died_and_nothing_else(self):
        self.assertEqual(self.may(Kill("driver/north", "north-pc")), {("process_died", "driver/north")})

    def test_who_was_stopped_is_silent_and_so_are_its_states(self):
        self.assertEqual(self.may(Stop("driver/north", "north-pc", 2.0)),
                         {("node_silent", "driver/north"), ("driver_silent", "north")})
        self.assertEqual(self.may(Stop("planner/north", "north-pc", 2.0)), {("node_silent", "planner/north")})

    def test_a_lost_host_is_lost_and_its_nodes_may_return_late(self):
        self.assertEqual(self.may(lasting(Cut("north-pc", 2.0))),
                         {("host_lost", "north-pc"), ("node_silent", "agent/north-pc"), ("node_silent", "driver/north"),
                          ("driver_silent", "north"),
                          ("node_silent", "planner/north")})

    def test_a_host_that_only_works_worse_is_blamed_for_nothing(self):
        self.assertEqual(self.may(Lose("world-pc", 2.0, 30), SlowDown("supervisor-pc", 2.0), FillDisk("world-pc", 2.0),
                                  StepClock("supervisor-pc", 2.0, -60)), set())

    def test_a_supervisor_that_was_cut_off_or_stood_still_or_died_accuses_no_other_host(self):
        for injection in (Cut("supervisor-pc", 2.0), Mute("world-pc", 2.0), Deafen("supervisor-pc", 2.0), Pause("supervisor-pc", 2.0),
                          KillAgent("supervisor-pc", 2.0), Kill("supervisor", "supervisor-pc"),
                          Stop("supervisor", "supervisor-pc", 2.0)):
            may = self.may(lasting(injection))
            self.assertNotIn(("host_lost", "north-pc"), may, injection)
            self.assertNotIn(("node_silent", "driver/north"), may, injection)

    def test_of_two_hosts_it_takes_the_other_for_lost_if_it_was_cut_off_for_long_enough_in_fact(self):
        places = {"supervisor": "here", "driver/north": "there"}
        for seconds, accused in (0.4, False), (1.1, True):
            may = may_be_told([lasting(Cut("here", 0.4), seconds)], places)
            self.assertEqual(("host_lost", "there") in may, accused, seconds)

    def test_so_it_does_where_another_takes_the_third_away(self):
        places = {"supervisor": "here", "driver/north": "there", "world": "elsewhere"}
        cut = lasting(Cut("here", 2.0))
        for other, accused in (KillAgent("elsewhere", 2.0), True), (Kill("world", "elsewhere"), False):
            self.assertEqual(("host_lost", "there") in may_be_told([cut, lasting(other)], places), accused, str(other))
        self.assertNotIn(("host_lost", "there"), may_be_told([cut], places))

    def test_a_death_is_told_as_a_silence_only_beside_a_supervisor_that_did_not_hear_of_it(self):
        death = Kill("planner/north", "north-pc")
        self.assertNotIn(("node_silent", "planner/north"), self.may(death, lasting(Cut("west-pc", 2.0))))
        self.assertIn(("node_silent", "planner/north"), self.may(death, lasting(Cut("supervisor-pc", 0.3))))


class HiddenTest(unittest.TestCase):
    DEATH = Kill("planner/north", "north-pc")

    def hidden(self, injection, *others, leader="supervisor"):
        return hidden(injection, [*others, injection], PLACES, leader)

    def test_alone_everything_is_told(self):
        self.assertFalse(self.hidden(Stop("supervisor", "supervisor-pc", 2.0)))

    def test_what_happens_to_others_hides_nothing(self):
        self.assertFalse(self.hidden(self.DEATH, Cut("west-pc", 2.0), SlowDown("supervisor-pc", 2.0)))

    def test_what_happens_to_the_standby_hides_nothing(self):
        for other in (Stop("supervisor@world-pc", "world-pc", 2.0), Kill("supervisor@world-pc", "world-pc"),
                      Cut("world-pc", 2.0)):
            self.assertFalse(self.hidden(self.DEATH, other), other)

    def test_a_leader_that_hangs_or_is_cut_off_hides_a_silence_but_no_death(self):
        silence = Stop("planner/north", "north-pc", 0.7)
        for other in Stop("supervisor@world-pc", "world-pc", 2.0), Cut("world-pc", 2.0), Pause("world-pc", 0.3):
            self.assertTrue(self.hidden(silence, other, leader="supervisor@world-pc"), other)
            self.assertFalse(self.hidden(self.DEATH, other, leader="supervisor@world-pc"), other)

    def test_a_deaf_leader_may_hide_a_death(self):
        self.assertTrue(self.hidden(self.DEATH, Deafen("supervisor-pc", 2.0)))

    def test_its_own_trouble_is_told(self):
        self.assertFalse(self.hidden(Cut("supervisor-pc", 2.5), self.DEATH))

    def test_a_killed_leader_hides_only_what_is_over_before_another_leads(self):
        other = Kill("supervisor", "supervisor-pc")
        self.assertFalse(self.hidden(self.DEATH, other))
        self.assertTrue(self.hidden(Stop("planner/north", "north-pc", 0.7), other))
        self.assertFalse(self.hidden(Stop("planner/north", "north-pc", 2.0), other))

    def test_without_a_supervisor_that_is_well_it_may_be_hidden(self):
        self.assertTrue(self.hidden(self.DEATH, Kill("supervisor", "supervisor-pc"),
                                    Stop("supervisor@world-pc", "world-pc", 2.0)))
        alone = {node: host for node, host in PLACES.items() if node != "supervisor@world-pc"}
        both = [self.DEATH, Kill("supervisor", "supervisor-pc")]
        self.assertTrue(hidden(self.DEATH, both, alone, "supervisor"))


    def test_who_is_left_alone_by_two_tells_neither(self):
        places = {"supervisor": "here", "driver/north": "there", "world": "elsewhere"}
        both = Cut("there", 2.0), Mute("elsewhere", 2.0)
        for cut in both:
            self.assertTrue(hidden(cut, [*map(lasting, both)], places, "supervisor"))
        self.assertIn(("host_lost", "here"), may_be_told(both, places))
        self.assertFalse(hidden(both[0], [both[0], Kill("world", "elsewhere")], places, "supervisor"))
        self.assertNotIn(("host_lost", "here"), may_be_told([both[0], Kill("world", "elsewhere")], places))
        self.assertEqual(left_alone(both, places), {"here"})
        unwatched = {"supervisor": "elsewhere", "driver/north": "there", "world": "here"}
        self.assertEqual(left_alone(both, unwatched), set(), "there is nobody who tells")


class LeadershipTest(unittest.TestCase):
    def test_what_happens_to_a_supervisor_or_its_host_or_takes_the_processors_may_move_it(self):
        for injection in (Kill("supervisor", "supervisor-pc"), Stop("supervisor@world-pc", "world-pc", 2.0), Cut("world-pc", 2.0),
                          Lose("supervisor-pc", 2.0, 30), FillDisk("world-pc", 2.0), SlowDown("north-pc", 2.0)):
            self.assertTrue(may_move_the_leadership(injection, PLACES), injection)

    def test_a_split_may_if_it_parts_the_supervisors(self):
        for side, others, may in ((("supervisor-pc", "north-pc"), ("world-pc", "west-pc"), True),
                                  (("supervisor-pc", "world-pc"), ("north-pc", "west-pc"), False)):
            split = Split(side, others, {"supervisor-pc", "world-pc"}, 2.0)
            self.assertEqual(may_move_the_leadership(split, PLACES), may)

    def test_what_happens_elsewhere_may_not(self):
        for injection in (Kill("planner/north", "north-pc"), Stop("world", "world-pc", 2.0), Cut("north-pc", 2.0),
                          Lose("west-pc", 2.0, 30), KillAgent("north-pc", 2.0)):
            self.assertFalse(may_move_the_leadership(injection, PLACES), injection)

    def test_a_change_pardons_what_happened_around_it(self):
        for move, injected, lasted in (10_000, 10_000, 0.0), (10_000, 8_500, 1.0), (10_000, 15_900, 2.0), (10_000, 9_100, 0.0):
            self.assertTrue(pardoned([0, move], injected, lasted), (move, injected, lasted))

    def test_it_pardons_nothing_else(self):
        for move, injected, lasted in (10_000, 16_100, 2.0), (10_000, 8_900, 0.0), (10_000, 7_000, 1.9):
            self.assertFalse(pardoned([move], injected, lasted), (move, injected, lasted))
        self.assertFalse(pardoned([], 0, 1.0))


class TogetherTest(unittest.TestCase):
    def test_two_processes_of_one_host_may_be_hit(self):
        self.assertTrue(together(Kill("driver/north", "north-pc"), Stop("planner/north", "north-pc", 2.0)))
        self.assertFalse(together(Kill("driver/north", "north-pc"), Stop("driver/north", "north-pc", 2.0)))

    def test_a_process_of_a_host_that_works_worse_may_be_hit(self):
        for host in (Lose("north-pc", 1.0, 30), SlowDown("north-pc", 1.0), FillDisk("north-pc", 1.0),
                     StepClock("north-pc", 1.0, 60)):
            self.assertTrue(together(host, Kill("driver/north", "north-pc")), host)
            self.assertTrue(together(Kill("driver/north", "north-pc"), host), host)
        self.assertTrue(together(FillDisk("world-pc", 1.0), Kill("world", "world-pc")))

    def test_what_is_lost_with_its_host_is_not_hit_beside(self):
        for host in Cut("north-pc", 1.0), Pause("north-pc", 1.0), KillAgent("north-pc", 1.0), Deafen("north-pc", 1.0):
            self.assertFalse(together(host, Kill("driver/north", "north-pc")), host)
            self.assertFalse(together(host, Lose("north-pc", 1.0, 30)), host)

    def test_nothing_else_happens_in_a_network_of_two_halves(self):
        self.assertFalse(together(Split(("north-pc", "west-pc"), ("world-pc",), set(), 1.0), Kill("world", "world-pc")))

    def test_two_hosts_may_be_hit(self):
        self.assertTrue(together(Cut("north-pc", 1.0), Pause("west-pc", 1.0)))


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
