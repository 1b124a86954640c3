# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lock-step time without ROS: one sample per command, and what happens when that breaks."""

import numpy as np
import pytest
from outgoing import Outgoing

from rodless_base.ros.publish import UNKNOWN
from rodless_sim import RigParameters, simulate
from rodless_sim.node.commanders import DRAINED
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import SECOND_ANSWER, Lockstep
from rodless_sim.physics.state import State

TIMEOUT = 1.0


class Bench:
    """A lock-step plant with its surroundings: who listens, who commands, what time it is."""

    def __init__(self, timeout: float = TIMEOUT, **values: object) -> None:
        self.samples: list[tuple[int, State]] = []
        self.listeners = True
        self.commanders = ["first"]
        self.names: dict[str, str] = {}  # of those that are not called after themselves
        self.unnamed = 0  # publishers that are connected, and not known by name yet
        self.outgoing = Outgoing()
        self.clock = 0.0
        parameters = RigParameters(
            {f"time.{name}": value for name, value in values.items()} | {"time.mode": "lockstep"}
        )
        self.engine = Engine(
            parameters, lambda seen, state: self.samples.append((seen.stamp, state))
        )
        self.plant = Lockstep(
            self.engine,
            timeout,
            lambda: self.listeners,
            lambda: {
                one.encode(): self.names.get(one, f"/{one.rstrip('+')}") for one in self.commanders
            },
            lambda: len(self.commanders) + self.unnamed,
            self.outgoing,
            lambda: self.clock,
        )

    @property
    def times(self) -> list[int]:
        """Plant times of the samples handed out, in periods."""
        return [time // 1_000_000 for time, _ in self.samples]


def test_nothing_moves_before_there_is_a_listener_and_one_commander() -> None:
    """Without a listener, with no commander or with two, not even sample 0 is offered."""
    bench = Bench()
    for listeners, commanders in ((False, ["a"]), (True, []), (True, ["a", "b"])):
        bench.listeners, bench.commanders = listeners, commanders
        bench.plant.poll()
        bench.plant.receive(6.0)
        assert bench.samples == []
        waits = "waiting for subscribers and for one publisher" in str(bench.plant.problem)
        assert waits is (len(commanders) < 2)
        assert bench.plant.problem is not None
    bench.commanders = ["last"]
    bench.plant.poll()
    bench.plant.poll()  # what the others sent is not on its way any more
    assert bench.times == [0]
    assert bench.plant.problem is None


def test_each_command_gives_the_next_sample_and_the_open_loop_trace() -> None:
    """N commands give samples 0 to N, bit for bit those of the open-loop simulation."""
    bench = Bench()
    voltages = 5.08 + np.sin(np.arange(200) / 20.0)
    bench.plant.poll()
    for voltage in voltages:
        bench.plant.receive(float(voltage))
    trace = simulate(RigParameters(), voltages, 1e-3)
    assert bench.times == list(range(201))
    assert [state.position for _, state in bench.samples] == trace.position.tolist()
    assert [state.pressure_b for _, state in bench.samples] == trace.pressure_b.tolist()


def test_pause_keeps_the_answer_back_until_it_ends() -> None:
    """While paused the answer waits; a step lets one take effect; the end of the pause too."""
    bench = Bench()
    bench.plant.poll()
    assert bench.plant.step() == "pause the plant first"
    bench.plant.pause(True)
    assert "no command" in str(bench.plant.step())
    bench.plant.receive(6.0)
    assert bench.times == [0]
    assert bench.plant.step() is None
    assert bench.times == [0, 1]
    bench.plant.receive(6.0)
    assert bench.times == [0, 1]
    bench.plant.pause(False)
    assert bench.times == [0, 1, 2]
    bench.plant.pause(False)
    assert bench.times == [0, 1, 2]


def test_reset_drops_the_answer_under_way() -> None:
    """The command that answers the last sample before a reset is not taken for sample 0's."""
    bench = Bench()
    bench.plant.poll()
    for _ in range(5):
        bench.plant.receive(9.0)
    assert bench.plant.reset() != "done"
    bench.plant.receive(9.0)
    assert bench.times == [0, 1, 2, 3, 4, 5, 0]
    bench.plant.receive(5.08)
    assert bench.times[-1] == 1
    assert bench.samples[-1][1].position == bench.samples[0][1].position


def test_reset_does_not_wait_for_ever() -> None:
    """With nobody answering, a reset happens once the timeout is over."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(9.0)
    bench.plant.reset()
    bench.plant.poll()
    assert bench.times == [0, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 0]


def test_reset_of_a_paused_plant_with_its_answer_at_hand_is_immediate() -> None:
    """A paused plant whose answer has come drops it and offers sample 0 at once."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(9.0)
    bench.plant.pause(True)
    bench.plant.receive(9.0)
    assert bench.plant.reset() == "done"
    assert bench.times == [0, 1, 0]
    bench.plant.receive(5.08)
    assert bench.times == [0, 1, 0]
    bench.plant.pause(False)
    assert bench.times == [0, 1, 0, 1]


def test_second_commander_is_refused_until_it_is_gone() -> None:
    """While two publish commands the plant holds and says so; then the last sample comes again."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0, 1)
    bench.commanders = ["first", "second"]
    bench.plant.poll()
    bench.plant.receive(6.0, 2)
    assert bench.times == [0, 1]
    said = "more than one publisher on valve/voltage (/first, /second): holding until one is left"
    assert bench.plant.problem == said
    bench.commanders = ["first"]
    bench.plant.poll()
    bench.plant.poll()  # what the other one sent is not on its way any more
    assert bench.plant.problem is None
    assert bench.times == [0, 1, 1]
    bench.plant.receive(6.0, 3)
    assert bench.times == [0, 1, 1, 2]


def test_controller_that_is_started_again_takes_up_the_run() -> None:
    """The sample that the old controller left unanswered is offered to the new one."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    bench.commanders = []
    bench.plant.poll()
    assert "waiting" in str(bench.plant.problem)
    bench.listeners, bench.commanders = False, ["second"]
    bench.plant.poll()
    assert bench.times == [0, 1]
    bench.listeners = True
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1, 2]


def test_reset_without_a_controller_is_immediate() -> None:
    """With nobody to answer, a reset happens at once, and the run starts from sample 0 later."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(9.0)
    bench.commanders = []
    bench.plant.poll()
    assert bench.plant.reset() == "done"
    bench.commanders = ["last"]
    bench.plant.poll()
    bench.plant.receive(5.08)
    assert bench.times == [0, 1, 0, 0, 1]


@pytest.mark.parametrize("others", [[], ["last"], ["first", "second"]])
def test_a_promised_reset_happens_when_the_commander_has_gone_or_is_not_alone(
    others: list[str],
) -> None:
    """It was to come with an answer: where that does not come, no sample of the old run follows."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(9.0)
    assert bench.plant.reset() == "with the answer to the last sample"
    bench.commanders = others
    bench.plant.poll()
    bench.commanders = ["last"]
    for _ in range(3):
        bench.clock += 2.0 * DRAINED
        bench.plant.poll()
    assert bench.times[:2] == [0, 1]
    assert set(bench.times[2:]) == {0}


def test_what_waits_goes_out_before_the_run_begins() -> None:
    """Ticks of a paused plant, and its faults for whoever comes later: nothing else sends them."""
    bench = Bench()
    bench.commanders = []
    tries: list[int] = []
    bench.outgoing.flush = lambda: bool(tries.append(1))  # type: ignore[method-assign]
    bench.plant.poll()
    assert tries == [1]
    bench.commanders = ["first"]
    bench.plant.poll()
    assert bench.times == [0], "the run begins all the same"


@pytest.mark.parametrize("early", [False, True])
@pytest.mark.parametrize("numbered", [False, True])
def test_reset_before_the_run_begins_costs_no_command_its_sample(
    early: bool, numbered: bool
) -> None:
    """The commander has sample 0 from the reset and from the start, and answers it twice.

    Before or after the recorder is there that the run waits for: each voltage says what sample it
    answers, and moves the carriage from there on.
    """
    bench = Bench()
    bench.listeners = False
    acted: list[float] = []
    receive = bench.engine.receive
    bench.engine.receive = lambda voltage: (acted.append(voltage), receive(voltage))[1]  # type: ignore[method-assign]
    bench.plant.poll()
    bench.plant.reset()
    answered = 0

    def answer() -> None:
        nonlocal answered
        for _ in range(len(bench.samples) - answered):
            answered += 1
            sample = bench.times[answered - 1]
            bench.plant.receive(5.0 + 1e-3 * sample, answered if numbered else None)

    if early:
        answer()
    bench.listeners = True
    bench.plant.poll()
    for _ in range(4):
        answer()
    assert bench.times == [0, 0, 1, 2, 3, 4][: len(bench.times)]
    assert len(acted) >= 3
    assert acted == pytest.approx([5.0 + 1e-3 * sample for sample in range(len(acted))])


def test_reset_beside_two_commanders_offers_nothing_to_either() -> None:
    """The one that is left gets sample 0 once the run begins, and owes one answer."""
    bench = Bench()
    bench.plant.poll()
    bench.commanders = ["first", "second"]
    bench.plant.poll()
    bench.plant.reset()
    assert bench.times == [0]
    bench.commanders = ["second"]
    bench.plant.poll()
    bench.clock += 2.0 * DRAINED
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 0, 1]


def test_silence_is_reported_and_the_run_goes_on_afterwards() -> None:
    """Without a command for the timeout the plant holds and says so, then takes up the run."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    bench.clock += 1.1 * TIMEOUT
    assert "no command" in str(bench.plant.problem)
    assert "/first" in str(bench.plant.problem)
    bench.plant.receive(6.0)
    assert bench.plant.problem is None
    assert bench.times == [0, 1, 2]


def test_a_sample_is_offered_again_until_it_is_answered() -> None:
    """Whichever sample it is; each time after twice the wait, and the bit-exact run goes on."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    bench.clock += 1.1 * TIMEOUT
    for _ in range(3):
        bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.clock += 2.0 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.clock += 0.3 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 1]
    for _ in range(3):
        bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1, 1, 2]
    trace = simulate(RigParameters(), [6.0, 6.0], 1e-3)
    assert bench.samples[-1][1].position == trace.position[-1]


def test_a_wait_for_further_answers_is_said() -> None:
    """A controller that was frozen answers once where its queue has kept one of several offers.

    Until the plant goes on with that, it says what it waits for, and for how long at most.
    """
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    for wait in (1.1, 2.3):
        bench.clock += wait * TIMEOUT
        bench.plant.poll()
    assert bench.times == [0, 1, 1, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.receive(6.0)
    assert bench.plant.problem is None
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.plant.problem is not None
    assert "has been answered, and " in bench.plant.problem
    assert "may answer it 2 times more: holding for 9 s at most" in bench.plant.problem
    bench.clock += 8.0 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 1, 2]
    assert bench.plant.problem is None


def test_a_slow_controller_is_not_answered_twice() -> None:
    """A sample that was offered twice has two answers: neither is taken for the next sample's."""
    bench = Bench()
    bench.plant.poll()
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 0]
    bench.plant.receive(6.0)
    assert bench.times == [0, 0]
    bench.clock += 1.5 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 0, 1]
    bench.clock += 1.5 * TIMEOUT
    bench.plant.receive(7.0)
    assert bench.times == [0, 0, 1, 2]


def test_an_answer_that_was_lost_is_not_waited_for_for_good() -> None:
    """Of two offers only one is answered: after as long as that took the run goes on with it."""
    bench = Bench()
    bench.plant.poll()
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 0]
    bench.clock += 2.3 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 0, 1]
    bench.plant.receive(6.0)
    assert bench.times == [0, 0, 1, 2]


def test_a_sample_that_a_reader_holds_back_is_not_offered_again() -> None:
    """However long it takes: the reader is named, and the answer is waited for afterwards."""
    bench = Bench()
    bench.plant.poll()
    bench.outgoing.obstacle = "a subscriber of /joint_states has stopped reading (/recorder)"
    for _ in range(20):
        bench.clock += TIMEOUT
        bench.plant.poll()
    assert bench.times == [0]
    assert "/recorder" in str(bench.plant.problem)
    bench.outgoing.obstacle = None
    bench.plant.poll()
    assert bench.plant.problem is None
    bench.plant.receive(6.0)
    assert bench.times == [0, 1]


def test_a_reset_takes_back_what_a_reader_holds_back() -> None:
    """Sample 0 then has one answer, not that of the sample before besides."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    bench.outgoing.obstacle = "a subscriber has stopped reading"
    bench.clock += 1.1 * TIMEOUT
    bench.plant.reset()
    assert bench.outgoing.obstacle is None
    assert bench.times == [0, 1, 0]
    bench.plant.receive(5.08)
    assert bench.times == [0, 1, 0, 1]


def test_of_two_offers_a_reset_takes_back_the_one_held_back() -> None:
    """The answer to the other is still under way, and is not taken for that to sample 0."""
    bench = Bench()
    bench.plant.poll()
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    bench.outgoing.obstacle = "a subscriber has stopped reading"
    bench.plant.reset()
    assert bench.times == [0, 0, 0]
    bench.plant.receive(9.0)
    assert bench.times == [0, 0, 0]
    bench.plant.receive(5.08)
    assert bench.times == [0, 0, 0, 1]
    assert bench.samples[-1][1].voltage == 5.08


def test_a_step_before_the_run_has_begun_is_refused() -> None:
    """Nobody has been asked for a command yet, so none has come."""
    bench = Bench()
    bench.plant.pause(True)
    assert "no command" in str(bench.plant.step())
    assert bench.samples == []


def under_way(number: int | None = 50, timeout: float = TIMEOUT) -> Bench:
    """Return a run whose sample 0 has its answer, of this ``number``."""
    bench = Bench(timeout)
    bench.plant.poll()
    bench.plant.receive(6.0, number)
    return bench


def killed_and_started_again(number: int | None = None) -> Bench:
    """Return a run whose controller was killed and started again, the dead one still listed.

    Its last answer had this ``number``.
    """
    bench = under_way(number)
    bench.commanders = ["first", "first+"]
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    return bench


def test_a_dead_controller_does_not_hold_the_one_started_after_it() -> None:
    """Two publishers of one name, one answer to a sample: the other is dead, and the run goes on.

    When the middleware has missed the dead one at last, nothing changes.
    """
    bench = killed_and_started_again()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 2]
    assert bench.plant.problem is None
    bench.commanders = ["first+"]
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1, 2, 3]


def test_a_controller_that_is_started_again_is_known_by_its_numbers() -> None:
    """It counts its commands from 1, beside a dead one that the middleware has not missed yet."""
    bench = Bench()
    bench.plant.poll()
    for number in range(50, 53):
        bench.plant.receive(6.0, number)
    bench.commanders = ["first", "first+"]
    bench.plant.poll()
    bench.plant.receive(6.0, 1)
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    for number in range(2, 6):
        bench.plant.receive(6.0, number)
    assert bench.times == [0, 1, 2, 3, 3, 4, 5, 6, 7, 8]


def test_a_controller_some_of_whose_commands_were_lost_is_followed() -> None:
    """Its numbers go on further up; a lower one is another's, who has gone already."""
    bench = Bench()
    bench.plant.poll()
    for number in (50, 51, 57, 58):
        bench.plant.receive(6.0, number)
    bench.plant.receive(6.0, 1)
    assert bench.times == [0, 1, 2, 3, 4]
    bench.plant.receive(6.0, 59)
    assert bench.times == [0, 1, 2, 3, 4, 5]


def test_what_another_sends_acts_on_nothing_before_its_name_is_known() -> None:
    """Its numbers lead through those of the commander, whose own ones are among them."""
    bench = under_way()
    bench.unnamed = 1
    for number in (49, 50, 51, 51, 52, 53):
        bench.plant.receive(9.0, number)
    assert bench.times == [0, 1]
    said = "more than one publisher on valve/voltage (/first and one that has gone, or is not"
    assert said in str(bench.plant.problem)
    bench.plant.poll()
    bench.unnamed = 0
    bench.plant.poll()
    bench.plant.receive(9.0, 54)
    bench.plant.poll()
    assert bench.times == [0, 1], "what it has sent may not be here yet"
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    assert bench.plant.problem is None
    # 51 was among what could be anybody's: 52 answers the second offer, and there is no third.
    bench.plant.receive(6.0, 52)
    bench.plant.receive(6.0, 53)
    assert bench.times == [0, 1, 1, 2, 3]


def test_another_that_has_come_and_gone_between_two_looks_is_noticed() -> None:
    """By how many have been connected in all: what it sent may still come."""
    bench = Bench()
    bench.plant.connect(1)
    for _ in range(3):
        bench.plant.poll()
    assert bench.times == [0]
    bench.plant.connect(1)
    bench.plant.receive(6.0, 50)
    assert bench.times == [0, 1]
    bench.plant.connect(2)
    for number in (50, 51, 52):
        bench.plant.receive(9.0, number)
    assert bench.times == [0, 1]
    for _ in range(3):
        bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.plant.receive(6.0, 51)
    bench.plant.receive(6.0, 52)
    assert bench.times == [0, 1, 1, 2]


def test_a_commander_whose_name_is_known_first_is_no_other() -> None:
    """That it is connected is told after its answers have begun: nothing is offered again."""
    bench = under_way()
    bench.plant.connect(1)
    bench.plant.receive(6.0, 51)
    bench.plant.poll()
    assert bench.times == [0, 1, 2]


def test_a_commander_that_answers_late_is_waited_for_after_another_has_gone() -> None:
    """It has not answered the first offer yet: one answer alone is not that to the second."""
    bench = under_way(timeout=1000.0)
    bench.unnamed = 1
    bench.plant.receive(9.0, 51)
    bench.unnamed = 0
    for _ in range(2):
        bench.plant.poll()
    bench.plant.receive(6.0, 51)
    assert bench.times == [0, 1, 1]
    bench.clock += 1.1 * SECOND_ANSWER
    said = "has been answered, and /first may answer it 1 times more: holding for 1000 s at most"
    assert said in str(bench.plant.problem)
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.plant.receive(6.0, 52)
    assert bench.times == [0, 1, 1, 2]


ANEW, ELSEWHERE = "of one start anew", "of the other"


def made_anew(publisher: str) -> Bench:
    """Return a run whose commander, of one start, has gone, and come as ``publisher``."""
    bench = Bench()
    first = "of one start"
    bench.names = dict.fromkeys((first, ANEW, ELSEWHERE), "/first")
    bench.commanders = [first]
    bench.plant.poll()
    bench.plant.receive(6.0, 50)
    assert bench.times == [0, 1]
    for there in ([], [publisher]):
        bench.commanders = there
        bench.plant.poll()
    assert bench.times == [0, 1, 1]
    return bench


def test_what_a_publisher_made_anew_has_lost_follows_from_its_numbers() -> None:
    """Its first answer was sent before it was connected: the second is to the second offer."""
    bench = made_anew(ANEW)
    bench.plant.receive(6.0, 2)
    assert bench.times == [0, 1, 1, 2]


@pytest.mark.parametrize("publisher", [ANEW, ELSEWHERE])
def test_a_commander_that_makes_its_publisher_anew_owes_what_it_was_offered(publisher: str) -> None:
    """The same node answers both offers; one of another process has had the second one only."""
    bench = made_anew(publisher)
    bench.plant.receive(6.0, 1)
    owes_two = publisher == ANEW
    assert bench.times == [0, 1, 1] + [2] * (not owes_two)
    bench.plant.receive(6.0, 2)
    assert bench.times == [0, 1, 1, 2] + [3] * (not owes_two)


def test_a_commander_that_never_pauses_is_followed_once_another_has_gone() -> None:
    """One that sends by its own clock: there is no moment without a command to wait for."""
    bench = Bench()
    bench.plant.poll()
    bench.clock = begin = 10.0
    bench.unnamed, number = 1, 50
    bench.plant.poll()
    bench.unnamed = 0
    while len(bench.times) < 5 and number < 200:
        bench.plant.receive(6.0, number)
        bench.plant.poll()
        number += 1
        bench.clock += 0.01
    assert bench.times[-1] > 1
    assert DRAINED < bench.clock - begin < 1.5 * DRAINED


def test_a_number_that_was_counted_is_no_further_answer() -> None:
    """Another one's, or the same message once more: the sample still has none."""
    bench = under_way()
    bench.plant.receive(9.0, 50)
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1]


def test_an_answer_that_was_lost_is_known_by_the_next_one() -> None:
    """The sample was offered again: the answer to that is the last one there can be."""
    bench = under_way()
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0, 52)
    assert bench.times == [0, 1, 1, 2]


def test_what_another_sends_without_a_number_is_not_counted() -> None:
    """It is known by name; the commander answers late, both offers."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
    bench.commanders = ["first", "second"]
    bench.plant.poll()
    bench.plant.receive(9.0)
    bench.commanders = ["first"]
    for _ in range(3):
        bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1]
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1, 2]


def test_numbers_that_begin_anew_do_not_hold_the_plant_for_good() -> None:
    """Offered the sample again, a commander of whatever numbers is followed."""
    bench = under_way()
    bench.plant.receive(6.0, 1)
    assert bench.times == [0, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0, 2)
    bench.clock += 10.0 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0, 3)
    assert bench.times == [0, 1, 1, 2, 3]


@pytest.mark.parametrize("numbers", [(None, None, None), (51, 52, 1), (1, 51, 52), (51, 1, 52)])
def test_two_controllers_of_one_name_that_both_answer_are_refused(
    numbers: tuple[int | None, ...],
) -> None:
    """Three answers to two offers to one of them, and one to the other: held until one is gone."""
    bench = killed_and_started_again(None if numbers[0] is None else 50)
    for number in numbers:
        bench.plant.receive(6.0, number)
    bench.clock += 10.0 * TIMEOUT
    bench.plant.poll()
    assert "more than one publisher" in str(bench.plant.problem)
    assert bench.times == [0, 1, 1]
    bench.commanders = ["first"]
    bench.plant.poll()
    bench.plant.poll()  # what the other one sent is not on its way any more
    bench.plant.receive(6.0, None if numbers[0] is None else 53)
    assert bench.times == [0, 1, 1, 1, 2]


@pytest.mark.parametrize("left", ["first", "first+"])
def test_of_two_of_one_name_the_one_that_is_left_is_followed(left: str) -> None:
    """At once, and by its own count: whether it is the one from before or the one that came."""
    bench = killed_and_started_again(50)
    bench.plant.receive(6.0, {"first": 51, "first+": 1}[left])
    assert "two publishers on valve/voltage of one name (/first): holding for" in str(
        bench.plant.problem
    )
    bench.commanders = [left]
    bench.plant.poll()
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 1]
    later = {"first": (52, 53), "first+": (2,)}[left]
    for number in later:
        assert bench.times[-1] == 1
        bench.plant.receive(6.0, number)
    assert bench.times == [0, 1, 1, 1, 2]


@pytest.mark.parametrize("first", [1, 2])
def test_of_one_that_was_started_again_a_number_counts_once(first: int) -> None:
    """What comes once more, or was sent before, does not act."""
    bench = killed_and_started_again(50)
    bench.plant.receive(6.0, first)
    bench.plant.receive(9.0, 1)
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 2]
    assert bench.samples[-1][1].voltage == 6.0


@pytest.mark.parametrize("number", [1, 51, 99])
def test_of_two_of_one_name_the_silent_one_that_speaks_at_last_is_noticed(number: int) -> None:
    """It was taken for dead; what it sends would lead through the numbers of the other one."""
    bench = killed_and_started_again(50)
    for own in (51, 52):
        bench.plant.receive(6.0, own)
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    bench.plant.receive(6.0, 53)
    assert bench.times == [0, 1, 1, 2, 3]
    bench.plant.receive(9.0, number)
    assert bench.times == [0, 1, 1, 2, 3]
    assert "more than one publisher" in str(bench.plant.problem)
    bench.commanders = ["first"]
    for _ in range(3):
        bench.plant.poll()
    assert bench.times == [0, 1, 1, 2, 3, 3]
    for own in (54, 55):
        bench.plant.receive(6.0, own)
    assert bench.times == [0, 1, 1, 2, 3, 3, 4]


def test_one_that_took_over_before_the_first_answer_owes_its_own() -> None:
    """The one before was killed without any: no number tells them apart."""
    bench = Bench()
    bench.plant.poll()
    bench.commanders = ["first", "first+"]
    bench.plant.poll()
    assert bench.times == [0, 0]
    bench.plant.receive(6.0, 1)
    bench.commanders = ["first+"]
    bench.plant.poll()
    bench.plant.poll()
    assert bench.times == [0, 0, 0]
    bench.plant.receive(6.0, 2)
    assert bench.times == [0, 0, 0, 1]


def test_two_of_one_name_that_both_answer_at_first_are_refused() -> None:
    """Before there was any answer numbers tell nothing: three to two offers are one too many."""
    bench = Bench()
    bench.plant.poll()
    bench.commanders = ["first", "first+"]
    bench.plant.poll()
    for number in (1, 1, 2):
        bench.plant.receive(6.0, number)
    bench.clock += 10.0 * TIMEOUT
    bench.plant.poll()
    assert "more than one publisher" in str(bench.plant.problem)
    assert bench.times == [0, 0]


def test_an_answer_of_a_killed_one_under_way_is_not_that_of_a_living() -> None:
    """Without numbers: two answers to the two offers that it had, or one to each."""
    bench = killed_and_started_again()
    for _ in range(2):
        bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 2]


def test_of_three_of_one_name_it_is_seen_who_answers() -> None:
    """One that the middleware has missed at last changes nothing for the other two."""
    bench = under_way()
    bench.commanders = ["first", "first+", "first++"]
    bench.plant.poll()
    bench.plant.receive(6.0, 1)
    bench.commanders = ["first+", "first++"]
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 2]


def test_one_answer_too_many_is_one_answer() -> None:
    """Of a commander that sends by its own clock, while the plant is paused: the last one acts."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.pause(True)
    for voltage in (6.0, 7.0):
        bench.plant.receive(voltage)
    bench.plant.pause(False)
    assert bench.times == [0, 1]
    assert bench.samples[-1][1].voltage == 7.0
    bench.plant.receive(8.0)
    assert bench.times == [0, 1, 2]


def test_a_second_one_of_the_same_name_that_is_silent_costs_two_seconds_at_most() -> None:
    """However long a command may take, as in a test that computes."""
    bench = under_way(timeout=1000.0)
    bench.commanders = ["first", "first+"]
    bench.plant.poll()
    for number in (51, 52):
        bench.plant.receive(6.0, number)
    bench.clock += 0.9 * SECOND_ANSWER
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    bench.clock += 0.2 * SECOND_ANSWER
    bench.plant.poll()
    assert bench.times == [0, 1, 1, 2]
    bench.plant.receive(6.0, 53)
    assert bench.times == [0, 1, 1, 2, 3]


def test_a_commander_whose_name_is_told_late_owes_what_it_was_offered() -> None:
    """It is the same publisher: both its answers to two offers are of one sample."""
    bench = Bench()
    bench.names["first"] = UNKNOWN
    bench.plant.poll()
    del bench.names["first"]
    bench.plant.poll()
    bench.plant.receive(6.0, 1)
    bench.clock += 2.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 1]
    for number in (2, 3, 4):
        bench.plant.receive(6.0 + number, number)
    assert bench.times == [0, 1, 1, 2, 3]
    assert [state.voltage for _, state in bench.samples][-2:] == [9.0, 10.0]


def test_an_answer_that_waits_for_a_pause_to_end_is_no_obstacle() -> None:
    """The sample has all its answers, however long the pause."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.pause(True)
    bench.plant.receive(6.0)
    bench.clock += 100.0 * TIMEOUT
    bench.plant.poll()
    assert bench.plant.problem is None
    assert bench.times == [0]


def test_a_step_waits_for_each_answer_to_a_sample_that_was_offered_again() -> None:
    """One of two is here: with it the second would be that to the next sample."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.pause(True)
    bench.clock += 1.1 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 0]
    bench.plant.receive(6.0)
    assert "no command" in str(bench.plant.step())
    bench.plant.receive(6.0)
    assert bench.plant.step() is None
    assert bench.times == [0, 0, 1]


def test_run_of_a_given_duration_ends_with_its_last_sample() -> None:
    """After time.duration the plant holds, content, whatever commands still come."""
    bench = Bench(duration=0.003)
    bench.plant.poll()
    for _ in range(10):
        bench.plant.receive(6.0)
    bench.clock += 10.0 * TIMEOUT
    bench.plant.poll()
    assert bench.times == [0, 1, 2, 3]
    assert bench.plant.problem is None


@pytest.mark.parametrize("voltage", [float("nan"), float("inf"), -float("inf")])
def test_command_that_is_not_finite_steps_with_a_closed_valve(voltage: float) -> None:
    """The loop goes on with the closed valve's voltage, and the fault is counted."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(voltage)
    assert bench.times == [0, 1]
    assert bench.samples[-1][1].voltage == 5.08
    assert bench.engine.command.not_finite == 1
