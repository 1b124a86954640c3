# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig under test: the nodes in a domain of their own, and everything a test does with them."""

import errno
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import get_args

from std_msgs.msg import Float64

from rodless_base.atomic_write import cannot_be_written
from rodless_base.file_path import file_path
from rodless_base.one_line import shown
from rodless_base.real_number import is_number
from rodless_base.topics import SETPOINT, VALVE_VOLTAGE
from rodless_control.controller_parameters import DEFAULT_LAW
from rodless_control.laws import LAWS, law_class
from rodless_lab.bags.ros.record import check_topic_name
from rodless_lab.results_folder import results_folder
from rodless_lab.session.bag import SessionBag
from rodless_lab.session.commands import OwnCommands, RelayedCommands
from rodless_lab.session.controls import Controls
from rodless_lab.session.deprecated import timeout_was_patience
from rodless_lab.session.domain import own_domain
from rodless_lab.session.errors import HarnessError, LawFailedError, WaitTimeoutError
from rodless_lab.session.faults import Faults
from rodless_lab.session.law_watch import WAY_OUT, LawWatch
from rodless_lab.session.live_session import Mode
from rodless_lab.session.observer import Observer
from rodless_lab.session.opening_process import OpeningProcess
from rodless_lab.session.plant_hears import PlantHears
from rodless_lab.session.plant_time import PlantTime
from rodless_lab.session.processes import WANTED_VOLTAGE, ProcessPlan, SessionProcesses
from rodless_lab.session.receiver import Receiver
from rodless_lab.session.temporary_folder import temporary_folder
from rodless_sim.scenario import scenario_parameter

# For whatever must come, in wall-clock s: the first start compiles, and machines are crowded.
TIMEOUT = 120.0

# Before a lock-step sample is offered again, in wall-clock s: to a controller, which answers by
# itself, and to a test, which takes its time and must not find two answers to one sample.
COMMAND_TIMEOUT = 3.0
COMMAND_TIMEOUT_OF_A_TEST = 1000.0

IN_USE = "another session or process writes there; wait for its end, or give another folder"


def _follow(scenario: str | Path | None) -> dict[str, str]:
    return {} if scenario is None else scenario_parameter(scenario)


def _refuse_unless(good: bool, name: str, given: object, wanted: str) -> None:
    if not good:
        raise ValueError(f"{name} {shown(given)} refused, {wanted}")


def _is_command_line(given: object) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, str | bytes) and bool(given)


def _is_list_of_texts(given: object) -> bool:
    return (
        isinstance(given, Collection)
        and not isinstance(given, str | bytes)
        and all(isinstance(text, str) for text in given)
    )


def _are_texts(given: object) -> bool:
    return (
        isinstance(given, Mapping)
        and all(
            isinstance(text, str) and "\0" not in text for pair in given.items() for text in pair
        )
        and not any("=" in name for name in given)
    )


class RigSession(PlantTime, Controls, Faults):
    """A plant, and a controller or the test in its place, between ``__enter__`` and ``__exit__``.

    On entry both run in a DDS domain that nobody else on this machine has, matched with each
    other and with the test, and sample 0 has come. Whatever happens, all that was started ends
    with the block. The nodes run by themselves; the test hears of them, and its own commands go
    out, while it waits in one of these methods.

    All waits are bounded by ``timeout`` and raise :class:`WaitTimeoutError`; a node that ends by
    itself raises :class:`NodeDiedError`. Both texts show what the nodes have printed.
    """

    @timeout_was_patience
    def __init__(
        self,
        mode: Mode = "realtime",
        *,
        preset: str = "paper",
        plant: Mapping[str, object] | None = None,
        controller: Mapping[str, object] | Sequence[str] | None = {},
        duration: float = 0.0,
        one_process: bool = False,
        telemetry: bool = False,
        relay_commands: bool = False,
        paused: bool = False,
        scenario: str | Path | None = None,
        law_may_fail: bool = False,
        timeout: float = TIMEOUT,
        check: Callable[[], object] = lambda: None,
        environment: Mapping[str, str] | None = None,
        output: str | Path | None = None,
        bag: str | Path | None = None,
        bag_topics: Sequence[str] = (),
    ) -> None:
        """Prepare a session; nothing starts yet.

        ``plant`` are parameters on top of ``preset``. ``controller`` are those of the PID node, or
        the command line of a controller of your own, or None: the test itself sends the voltages.
        The run ends with the first sample from ``duration`` on (plant time, s; 0: never). With
        ``one_process`` plant and PID share a process; with ``telemetry`` the terms of its law are
        received; with ``relay_commands`` commands pass through the test, which can lose or change
        them; with ``paused`` the plant holds at sample 0. The plant follows ``scenario``, a file or
        the name of one of the package. Where the controller's law fails, the valve closes, and the
        wait that hears of it or the end of the block raises :class:`LawFailedError`, unless
        ``law_may_fail``. ``check`` is called over and over in every wait, and ends it by an
        exception. ``environment`` is added for the nodes, and what they print goes to files in
        ``output`` (default: a temporary folder). All that the plant publishes, commands, set-points
        and ``bag_topics`` are recorded into a new rosbag2 bag at ``bag``.

        Raises ValueError for options that contradict each other, TypeError where ``output``,
        ``bag`` or ``scenario`` is no path and for what no parameter can be, ScenarioError (a
        ValueError) for a scenario that is none, and FileNotFoundError for a preset that does not
        exist.
        """
        super().__init__()
        kinds = get_args(Mode)
        by_name = "must be parameters by name: {name: value}"
        _refuse_unless(mode in kinds, "mode", mode, f"must be one of {kinds}")
        lasts = is_number(duration) and 0.0 <= duration < math.inf
        _refuse_unless(lasts, "duration", duration, "must be a number of s, or 0")
        waits = is_number(timeout) and 0.0 < timeout < math.inf
        _refuse_unless(waits, "timeout", timeout, "must be a positive number of s")
        _refuse_unless(plant is None or isinstance(plant, Mapping), "plant", plant, by_name)
        _refuse_unless(
            controller is None or isinstance(controller, Mapping) or _is_command_line(controller),
            "controller",
            controller,
            'must be parameters by name, or a command line as a list: ["ros2", "run", ...]',
        )
        _refuse_unless(
            environment is None or _are_texts(environment),
            "environment",
            environment,
            'must be texts by name: {"ROS_DOMAIN_ID": "7"}',
        )
        for name, own in (("time.mode", mode), ("time.duration", duration)):
            given = (plant or {}).get(name, own)
            option = f"{name.removeprefix('time.')}={own!r}"
            _refuse_unless(given == own, name, given, f"the session has {option}: give it there")
        switches = {
            "one_process": one_process,
            "telemetry": telemetry,
            "relay_commands": relay_commands,
            "paused": paused,
            "law_may_fail": law_may_fail,
        }
        for name, switch in switches.items():
            _refuse_unless(switch in (True, False), name, switch, "must be True or False")
        _refuse_unless(
            _is_list_of_texts(bag_topics),
            "bag_topics",
            bag_topics,
            'must be a list of names: ["controller/reference"]',
        )
        for topic in bag_topics:
            check_topic_name(topic)
        _refuse_unless(callable(check), "check", check, "must be a function without arguments")
        self._mode = mode
        self._duration = duration
        self._telemetry = telemetry
        self._relay = relay_commands
        self._starts_paused = paused
        self._law_may_fail = law_may_fail
        self._timeout = timeout
        self._user_check = check
        self._extra_environment = dict(environment or {})
        self._output = None if output is None else file_path(output)
        self._bag_path = None if bag is None else file_path(bag)
        self._bag_topics = tuple(bag_topics)
        self._has_controller = controller is not None
        self._plan = ProcessPlan(
            preset,
            self._plant_parameters({**_follow(scenario), **(plant or {})}),
            self._controller_parameters(controller)
            if isinstance(controller, Mapping)
            else controller,
            one_process=one_process,
            relay_commands=relay_commands,
        )
        if telemetry and controller is None:
            raise ValueError("telemetry: there is no controller whose terms to receive")
        if bag_topics and bag is None:
            raise ValueError("bag_topics: there is no bag to record them into; give bag too")

    @property
    def _recorders(self) -> int:
        """Subscribers that every message must reach: the session and its bag."""
        return 1 if self._bag_path is None else 2

    def _plant_parameters(self, given: Mapping[str, object]) -> dict[str, object]:
        by_test = self._relay or not self._has_controller
        return {
            "time.mode": self._mode,
            "time.duration": self._duration,
            "time.recorders": self._recorders,
            "time.command_timeout": COMMAND_TIMEOUT_OF_A_TEST if by_test else COMMAND_TIMEOUT,
            **given,
        }

    def _controller_parameters(self, given: Mapping[str, object]) -> dict[str, object]:
        return {"controller.recorders": 0 if self._relay else self._recorders, **given}

    def __enter__(self) -> "RigSession":
        if self._inside:
            raise HarnessError("this session runs already; make another RigSession beside it")
        self._inside = True
        # What a block before this one has left says nothing of new nodes.
        self._paused = self._starts_paused
        self._controller_begins()
        self._opening = OpeningProcess()
        with ExitStack() as stack:
            stack.callback(self._end)
            self._start(stack)
            self._observer = Observer(
                self._environment, timeout=self._timeout, check=self._between_spins
            )
            stack.callback(self._observer.close)
            self._join(stack)
            self._stack = stack.pop_all()
        return self

    def _end(self) -> None:
        self._inside = False

    def _start(self, stack: ExitStack) -> None:
        """Start the processes; ``stack`` ends them."""
        self._environment = {**stack.enter_context(own_domain()), **self._extra_environment}
        own = Path(stack.enter_context(temporary_folder()))
        folder = self._output or own
        try:
            stack.enter_context(results_folder(folder))
            # A node that is started again reads its parameters anew: they are no one else's.
            commands = self._plan.command_lines(own)
            self._processes = SessionProcesses(commands, self._environment, folder)
        except OSError as error:
            if error.errno == errno.EBUSY:
                raise HarnessError(f"output {folder}: {IN_USE}") from error
            raise HarnessError(cannot_be_written(error.filename or folder, error)) from error
        self._outputs = self._exit_codes = None
        # Before the folder goes, and after all have ended.
        stack.callback(self._keep_what_remains)
        stack.enter_context(self._processes)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if not self._opening.is_this:
            return  # forked inside the block; who opened the session ends it
        with self._stack:
            if error is None:
                self._processes.check()
                if self._inside and self._bag is not None:
                    self._bag.catch_up(len(self._received.voltage))
        if error is not None:
            return
        if self._law_watch is not None:
            self._law_watch.check_to_the_end()
            self._check_that_the_law_returned()
        if self._bag is not None:
            self._bag.check()

    def _check_that_the_law_returned(self) -> None:
        """Raise LawFailedError where a law of the user's own has kept its node from ending."""
        law = self._law
        with_law = [name for name in self._processes.names if name != "plant"]
        stuck = [name for name in with_law if self._processes[name].had_to_be_killed]
        if stuck and law not in LAWS:
            raise LawFailedError(
                f"the {stuck[-1]} did not end when it was asked to, and was killed: its law {law} "
                f"does not return, or the machine is too busy; {WAY_OUT}"
            )

    def _keep_what_remains(self) -> None:
        self._outputs = self._processes.outputs
        self._exit_codes = self._processes.exit_codes

    def _between_spins(self) -> None:
        self._user_check()
        super()._between_spins()

    # What follows matches the observer with the nodes, in an order that loses no message.

    def _join(self, stack: ExitStack) -> None:
        if self._plan.runs_controller_node and not self._law_may_fail:
            self._law_watch = LawWatch(self._observer, lambda: "\n".join(self.outputs.values()))
        self._receiver = Receiver(self._observer)
        self._received = self._receiver.received
        if self._mode == "realtime":
            self._lag = self._receiver.lag
        self._setpoint = self._observer.publisher(Float64, SETPOINT, subscribers=0)
        self._command_listeners: Callable[[], int] = lambda: 0
        if not self._has_controller or self._relay:
            self._make_commander()
        if not self._has_controller:
            self._receiver.stand_in_for_a_controller()
        if self._paused:
            self.pause()
        if self._bag_path is not None:
            self._record(self._bag_path, stack)
        self._listen()
        self._wait_for_listeners()
        self._wait(lambda: self._received.runs, "sample 0")

    def _record(self, path: Path, stack: ExitStack) -> None:
        """Start the bag; the rig, which waits for the session as well, does not start yet."""
        bag = SessionBag(path, self._bag_topics, self._observer)
        # Any sample: whether one is complete cannot be told of a run that others have torn.
        stack.callback(lambda: bag.close(has_begun=bool(self._received.joint.runs)))
        self._bag = bag
        try:
            self._wait(lambda: bag.ready, "the topics of the bag to appear")
        except WaitTimeoutError as error:
            missing = ", ".join(bag.missing)
            hint = f"nobody publishes {missing}; take it out of bag_topics, or start who does"
            raise (WaitTimeoutError(f"{hint}; {error}") if missing else error) from error

    def _listen(self) -> None:
        topic = WANTED_VOLTAGE if self._relay else VALVE_VOLTAGE
        if self._has_controller and not self._plan.runs_controller_node:
            # The plant starts once it is heard. A controller of which that depends on nothing
            # should by then know the plant, or its first answer is lost.
            self._heard = self._receiver.listen_to_answers(topic)
            self._wait(self._heard, f"a publisher of {topic}")
            rest = self._receiver.listen_to_the_rest(self._terms)
        else:
            # The PID starts once its commands are heard: they must be the last thing to be.
            rest = self._receiver.listen_to_the_rest(self._terms)
            self._heard = self._receiver.listen_to_answers(topic)
        for other, is_heard in rest.items():
            self._wait(is_heard, f"a publisher of {other}")
        self._wait(self._heard, f"a publisher of {topic}")

    @property
    def _terms(self) -> tuple[str, ...]:
        """What the session receives of the controller's insides."""
        if not self._telemetry:
            return ()
        return ("reference", *law_class(self._law).TERMS)

    @property
    def _law(self) -> str:
        """The name of the law that the controller starts with; the default where it is not told."""
        given = self._plan.controller
        told = given if isinstance(given, Mapping) else {}
        return str(told.get("controller.law", DEFAULT_LAW))

    def _make_commander(self) -> None:
        commander = self._observer.publisher(Float64, VALVE_VOLTAGE, subscribers=0)
        self._command_listeners = commander.get_subscription_count
        if self._mode == "lockstep":
            self._plant_hears = PlantHears(self._observer.node, commander)

        def send(voltage: float) -> None:
            commander.publish(Float64(data=voltage))

        if self._relay:
            self._relayed = RelayedCommands(self._received, send, self._mode == "lockstep")
        else:
            self._own = OwnCommands(self._received, send, self._mode == "lockstep")

    def _wait_for_listeners(self) -> None:
        # The plant and the recorders, where the test sends.
        listeners = 1 + self._recorders if self._relay or not self._has_controller else 0
        self._wait(
            lambda: self._command_listeners() >= listeners,
            f"the plant to listen to {VALVE_VOLTAGE}",
        )
        if self._plan.runs_controller_node:
            self._wait_for_controller()
