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

from rodless_sim import RigParameters, simulate
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.physics.state import State

TIMEOUT = 1.0


class Bench:
    """A lock-step plant with its surroundings: who listens, who commands, what time it is."""

    def __init__(self, **values: object) -> None:
        self.samples: list[tuple[int, State]] = []
        self.listeners = True
        self.commanders = ["first"]
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
            TIMEOUT,
            lambda: self.listeners,
            lambda: {name.encode(): f"/{name.removesuffix('+')}" for name in self.commanders},
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
        assert bench.plant.problem is not None
    bench.commanders = ["last"]
    bench.plant.poll()
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
    bench.plant.receive(6.0)
    bench.commanders = ["first", "second"]
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1]
    assert "more than one publisher" in str(bench.plant.problem)
    assert "/first, /second" in str(bench.plant.problem)
    bench.commanders = ["first"]
    bench.plant.poll()
    assert bench.plant.problem is None
    assert bench.times == [0, 1, 1]
    bench.plant.receive(6.0)
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


def killed_and_started_again() -> Bench:
    """Return a run whose controller was killed and started again, the dead one still listed."""
    bench = Bench()
    bench.plant.poll()
    bench.plant.receive(6.0)
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


def test_two_controllers_of_one_name_that_both_answer_are_refused() -> None:
    """Two answers to one sample: held until one is gone, then the run goes on with the other."""
    bench = killed_and_started_again()
    for _ in range(2):
        bench.plant.receive(6.0)
    bench.clock += 10.0 * TIMEOUT
    bench.plant.poll()
    assert "more than one publisher" in str(bench.plant.problem)
    assert bench.times == [0, 1, 1]
    bench.commanders = ["first"]
    bench.plant.poll()
    bench.plant.receive(6.0)
    assert bench.times == [0, 1, 1, 1, 2]


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
