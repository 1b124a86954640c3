"""A rig under test: the nodes in a domain of their own, and everything a test does with them."""

import math
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, TypeVar

from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.parameter_file import preset_file
from rodless_base.ros.topics import VALVE_VOLTAGE
from rodless_lab.session.commands import Alteration, Law, OwnCommands, RelayedCommands
from rodless_lab.session.domain import own_domain
from rodless_lab.session.errors import HarnessError, RefusedError, WaitTimeoutError
from rodless_lab.session.observer import Observer
from rodless_lab.session.receiver import Receiver
from rodless_lab.session.samples import Cursor, Sample, Samples
from rodless_lab.session.session_processes import WANTED_VOLTAGE, ProcessPlan, SessionProcesses

Mode = Literal["realtime", "lockstep"]
Found = TypeVar("Found")

# For whatever must come, in wall-clock s: the first start compiles, and machines are crowded.
TIMEOUT = 120.0

# For the first answer in lock-step, in wall-clock s: a sample that is offered twice because the
# answer was slow, not lost, would be answered twice.
COMMAND_TIMEOUT = 3.0


class RigSession:
    """A plant, and a controller or the test in its place, between ``__enter__`` and ``__exit__``.

    On entry both run in a DDS domain that nobody else on this machine has, matched with each
    other and with the test, and sample 0 has come. Whatever happens, all that was started ends
    with the block. The nodes run by themselves; the test hears of them, and its own commands go
    out, while it waits in one of these methods.

    All waits are bounded by ``timeout`` and raise :class:`WaitTimeoutError`; a node that ends by
    itself raises :class:`NodeDiedError`. Both texts show what the nodes have printed.
    """

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
        timeout: float = TIMEOUT,
        environment: Mapping[str, str] | None = None,
        output: Path | None = None,
    ) -> None:
        """Prepare a session; nothing starts yet.

        ``plant`` are parameters on top of ``preset``. ``controller`` are those of the PID node,
        or the command line of a controller of your own, or None: the test itself sends the
        voltages. The run ends at plant time ``duration`` (s; 0: never). With ``one_process``
        plant and PID share a process; with ``telemetry`` the PID's terms are recorded; with
        ``relay_commands`` commands pass through the test, which can lose or change them; with
        ``paused`` the plant holds at sample 0. ``environment`` is added for the nodes, and what
        they print goes to files in ``output`` (default: a temporary folder).

        Raises ValueError for options that contradict each other and FileNotFoundError for a
        preset that does not exist.
        """
        self._mode = mode
        self._duration = duration
        self._telemetry = telemetry
        self._relay = relay_commands
        self._paused = paused
        self._timeout = timeout
        self._extra_environment = dict(environment or {})
        self._output = output
        self._has_pid = isinstance(controller, Mapping)
        self._has_controller = controller is not None
        if one_process and not self._has_pid:
            raise ValueError("one_process: only the PID of this package can share the process")
        if relay_commands and not self._has_controller:
            raise ValueError("relay_commands: there is no controller whose commands to relay")
        self._plan = ProcessPlan(
            preset_file(preset),
            self._plant_parameters(plant or {}),
            self._controller_parameters(controller)
            if isinstance(controller, Mapping)
            else controller,
            one_process,
            relay_commands,
        )
        self._running = False
        self._outputs: dict[str, str] = {}
        self._exit_codes: dict[str, int | None] = {}

    def _plant_parameters(self, given: Mapping[str, object]) -> dict[str, object]:
        return {
            "time.mode": self._mode,
            "time.duration": self._duration,
            "time.recorders": 1,
            "time.command_timeout": COMMAND_TIMEOUT,
            **given,
        }

    def _controller_parameters(self, given: Mapping[str, object]) -> dict[str, object]:
        recorders = 0 if self._relay else 1
        return {"use_sim_time": True, "controller.recorders": recorders, **given}

    def __enter__(self) -> "RigSession":
        with ExitStack() as stack:
            self._start(stack)
            self._observer = Observer(
                self._environment, timeout=self._timeout, check=self._between_spins
            )
            stack.callback(self._observer.close)
            self._receiver = Receiver(self._observer)
            self._received = self._receiver.received
            self._answering = False
            self._join()
            self._stack = stack.pop_all()
        return self

    def _start(self, stack: ExitStack) -> None:
        """Start the processes; ``stack`` ends them."""
        self._environment = {**stack.enter_context(own_domain()), **self._extra_environment}
        folder = self._output or Path(tempfile.mkdtemp(prefix="rodless_sim-"))
        if self._output is None:
            stack.callback(shutil.rmtree, folder, ignore_errors=True)
        folder.mkdir(parents=True, exist_ok=True)
        self._processes = SessionProcesses(
            self._plan.command_lines(folder), self._environment, folder
        )
        # Before the folder goes, and after all have ended.
        stack.callback(self._keep_what_remains)
        stack.callback(self._processes.stop)
        self._running = True
        self._processes.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._stack:
            if error is None:
                self._processes.check()

    def _keep_what_remains(self) -> None:
        if self._running:
            self._outputs = self._processes.outputs
            self._exit_codes = self._processes.exit_codes
        self._running = False

    def _join(self) -> None:
        self._setpoint = self._observer.publisher(Float64, "setpoint", subscribers=0)
        self._own: OwnCommands | None = None
        self._command_listeners: Callable[[], int] = lambda: 0
        self._relayed: RelayedCommands | None = None
        if not self._has_controller or self._relay:
            self._make_commander()
        if not self._has_controller:
            self._receiver.stand_in_for_a_controller()
        if self._paused:
            self.pause()
        self._listen()
        self._wait(self._all_listen, "plant and controller to listen")
        self._wait(lambda: self._received.runs, "sample 0")

    def _listen(self) -> None:
        topic = WANTED_VOLTAGE if self._relay else VALVE_VOLTAGE
        if self._has_controller and not self._has_pid:
            # The plant starts once it is heard. A controller of which that depends on nothing
            # should by then know the plant, or its first answer is lost.
            self._heard = self._receiver.listen_to_answers(topic)
            self._wait(self._heard, "a publisher of valve/voltage")
            plant_is_heard = self._receiver.listen_to_the_rest(self._telemetry)
        else:
            # The PID starts once its commands are heard: they must be the last thing to be.
            plant_is_heard = self._receiver.listen_to_the_rest(self._telemetry)
            self._heard = self._receiver.listen_to_answers(topic)
        self._wait(plant_is_heard, "the plant to appear")
        self._wait(self._heard, "a publisher of valve/voltage")

    def _make_commander(self) -> None:
        commander = self._observer.publisher(Float64, VALVE_VOLTAGE, subscribers=0)
        self._command_listeners = commander.get_subscription_count

        def send(voltage: float) -> None:
            commander.publish(Float64(data=voltage))

        if self._relay:
            self._relayed = RelayedCommands(self._received, send, self._mode == "lockstep")
        else:
            self._own = OwnCommands(self._received, send)

    def _all_listen(self) -> bool:
        # The plant and this node's own recording, where the test sends.
        listeners = 2 if self._relay or not self._has_controller else 0
        return self._command_listeners() >= listeners and (
            not self._has_pid or self._setpoint.get_subscription_count() > 0
        )

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables that put another process into this session's domain."""
        return dict(self._environment)

    @property
    def outputs(self) -> dict[str, str]:
        """What each process has printed so far; also after the end."""
        return self._processes.outputs if self._running else self._outputs

    @property
    def exit_codes(self) -> dict[str, int | None]:
        """Exit code of each process, negative for a signal, None of what runs."""
        return self._processes.exit_codes if self._running else self._exit_codes

    @property
    def pids(self) -> dict[str, int]:
        """Process ID of each process."""
        return {name: self._processes[name].pid for name in self._processes.names}

    # Waiting

    def wait_until(
        self, condition: Callable[[], Found], what: str, timeout: float | None = None
    ) -> Found:
        """Let the rig run until ``condition()`` is true, and return what it returned.

        ``what`` completes the error "timed out … waiting for …". Raises WaitTimeoutError after ``timeout`` s of
        wall clock (default: the session's).
        """
        return self._wait(condition, what, timeout, running=True)

    def _wait(
        self,
        condition: Callable[[], Found],
        what: str,
        timeout: float | None = None,
        running: bool = False,
    ) -> Found:
        with self._waiting(running):
            return self._observer.wait(condition, what, timeout)

    def _between_spins(self) -> None:
        self._processes.check()
        if self._answering:
            self._answer()

    @contextmanager
    def _waiting(self, running: bool = False) -> Iterator[None]:
        """Send the commands that are due meanwhile; show what nodes have printed if it times out.

        In lock-step a plant that the test answers stands still except while it is to run.
        """
        before, self._answering = self._answering, running or self._mode == "realtime"
        try:
            yield
        except WaitTimeoutError as error:
            raise WaitTimeoutError(self._processes.with_outputs(str(error))) from error
        finally:
            self._answering = before

    def _answer(self) -> None:
        for commands in (self._own, self._relayed):
            if commands is not None:
                commands.answer()

    # Plant time

    @property
    def latest(self) -> Sample:
        """The newest sample that has come."""
        run = self._received.runs - 1
        return self._received.sample(run, self._received.complete(run) - 1)

    def run_until(
        self,
        condition: float | Callable[[Sample], object],
        what: str = "the condition of run_until",
        timeout: float | None = None,
    ) -> Sample:
        """Let the rig run to a plant time (s) or to a sample for which ``condition`` holds.

        Returns that sample, the newest counting first. In lock-step with commands from the test
        (no controller, or ``relay_commands``) the plant then stands at that very sample; it has
        gone on otherwise.
        """
        if not callable(condition):
            instant = round(condition * 1e9)
            what = f"plant time {condition:g} s"
            return self._run_until(lambda _, s: round(s.time * 1e9) >= instant, what, timeout)
        wanted = condition
        return self._run_until(lambda _, sample: wanted(sample), what, timeout)

    def _run_until(
        self, condition: Callable[[int, Sample], object], what: str, timeout: float | None = None
    ) -> Sample:
        samples = Cursor(self._received)

        def found() -> Sample | None:
            while (next_sample := samples.next()) is not None:
                if condition(*next_sample):
                    return next_sample[1]
            self._processes.check_plant()
            return None

        sample = self._wait(found, what, timeout, running=True)
        assert sample is not None
        return sample

    def run_for(self, duration: float, timeout: float | None = None) -> Sample:
        """Let the rig run for ``duration`` s of plant time; see :meth:`run_until`."""
        return self.run_until(self.latest.time + duration, timeout=timeout)

    def run(self, timeout: float | None = None) -> Samples:
        """Let the rig run to the end of its ``duration``; return all samples of the run.

        With a controller in lock-step, its answer to the last sample is there too. Raises
        HarnessError in a session without ``duration``.
        """
        if not self._duration:
            raise HarnessError("run: this session has no duration")
        self.run_until(self._duration, timeout=timeout)
        if self._mode == "lockstep" and self._has_controller and not self._relay:
            answers, last = self._received.answers, self._received.last_sent
            self._wait(lambda: answers and answers[-1].sent > last, "the answer to the last sample")
            if self._telemetry:
                terms = self._received.terms.values()
                self._wait(
                    lambda: all(term and term[-1].sent > answers[-1].sent for term in terms),
                    "the telemetry of the last sample",
                )
        return self.samples()

    def samples(self, run: int = -1) -> Samples:
        """Return what has come of a run of the plant: 0 the first, -1 the last; resets part runs.

        Raises LostSampleError if samples were lost and IndexError for a run that there is not.
        """
        return self._received.samples(range(self._received.runs)[run])

    def pause(self) -> None:
        """Stop plant time; a lock-step plant keeps the next answer back."""
        self._ask(SetBool, "plant/pause", data=True)
        self._paused = True

    def resume(self) -> None:
        """Let plant time run on."""
        self._ask(SetBool, "plant/pause", data=False)
        self._paused = False

    def step(self, count: int = 1) -> Sample:
        """Let a paused plant advance by ``count`` samples; return the last.

        In lock-step each step waits for the answer to the sample before. Raises RefusedError
        where the plant is not paused.
        """
        if not self._paused:
            raise RefusedError("step: pause the plant first")
        for _ in range(count):
            sample = self._step()
        return sample

    def _step(self) -> Sample:
        asked = time.time_ns()
        self._wait(
            lambda: self._call(Trigger, "plant/step").success, "the plant to step", running=True
        )
        return self._run_until(lambda sent, _: sent >= asked, "the sample of a step")

    def reset(self) -> Sample:
        """Return the plant to its start, where a new run begins; return its sample 0."""
        runs = self._received.runs
        self._ask(Trigger, "plant/reset")
        self._wait(lambda: self._received.runs > runs, "sample 0 after a reset", running=True)
        return self._received.sample(runs, 0)

    # Commands and set-points

    def setpoint(self, position: float) -> None:
        """Send a set-point (m)."""
        self._wait(self._setpoint.get_subscription_count, "a listener to set-points")
        self._setpoint.publish(Float64(data=float(position)))

    def send_voltage(self, voltage: float) -> None:
        """Send one command (V), NaN included; raises HarnessError where a controller does so."""
        self._commander("send_voltage").send(float(voltage))

    def drive(self, law: Law | float | None) -> None:
        """Answer every sample from now on by ``law``, a function or a voltage (V).

        A law that returns None loses its command; None in place of a law ends the answers.
        """
        commands = self._commander("drive")
        commands.drive(_as_law(law), from_now=self._mode == "realtime")

    def _commander(self, what: str) -> OwnCommands:
        if self._own is None:
            raise HarnessError(f"{what}: the controller of this session sends the commands")
        return self._own

    def alter_commands(self, alteration: Alteration | None) -> None:
        """Pass the controller's commands (V) through a function; what it makes None is lost.

        Needs ``relay_commands``. None passes them on as they are.
        """
        if self._relayed is None:
            raise HarnessError("alter_commands: start the session with relay_commands")
        self._relayed.alter = alteration

    @contextmanager
    def commands_lost(self) -> Iterator[None]:
        """Lose every command inside the block; needs ``relay_commands`` and real time.

        A lock-step plant would stand still for good: make its commands NaN instead.
        """
        if self._mode == "lockstep":
            raise HarnessError("commands_lost: a lock-step plant waits for its commands")
        self.alter_commands(lambda _: None)
        try:
            yield
        finally:
            self.alter_commands(None)

    def enable_controller(self, enabled: bool = True) -> None:
        """Switch the PID on, or off: the valve is then commanded closed."""
        self._ask(SetBool, "controller/enable", data=enabled)

    def reset_controller(self) -> None:
        """Let the PID forget the run so far."""
        self._ask(Trigger, "controller/reset")

    # Parameters and diagnostics

    def set_parameters(self, node: str, values: Mapping[str, object]) -> None:
        """Set parameters of a node (``plant``, ``controller``) as one change.

        Raises RefusedError with the node's reason, and then nothing has changed.
        """
        with self._waiting():
            self._observer.set_parameters(node, values)

    def parameters(self, node: str, names: Sequence[str]) -> dict[str, object]:
        """Return the values of a node's parameters."""
        with self._waiting():
            return self._observer.get_parameters(node, names)

    def diagnostics(self, node: str) -> dict[str, str]:
        """Return what a node last said on ``/diagnostics``: its ``message`` and its counters."""
        found = self._observer.diagnostics.get(f"/{node}")
        return {} if found is None else {"message": found.message, **found.values}

    def counter(self, node: str, name: str) -> float:
        """Return a counter of :meth:`diagnostics`, NaN before the node has said it."""
        return float(self.diagnostics(node).get(name, math.nan))

    # Faults

    def kill(self, process: str) -> None:
        """Kill a process (``plant``, ``controller``; ``rig`` when they share one)."""
        self._processes[process].kill()

    def restart(self, process: str) -> None:
        """Stop a process, unless it was killed before, start it again, wait until it works.

        A lock-step plant offers its last sample anew to a new controller, unless commands are
        relayed: reset it then. One that was killed stays on the books of DDS for some 20 s of
        wall clock, for which lock-step waits.
        """
        managed = self._processes[process]
        managed.ask_to_stop()
        managed.end()
        if process == "controller" and self._mode == "lockstep":
            self._wait(lambda: not self._heard(), "the old controller to be forgotten")
            managed.start()
            self._wait(self._heard, "the new controller")
            return
        runs, began = self._received.runs, time.time_ns()
        managed.start()
        if process == "controller":
            answers = self._received.answers
            self._wait(lambda: answers and answers[-1].sent > began, "the new controller")
        else:
            self._wait(lambda: self._received.runs > runs, f"sample 0 of the new {process}")

    def freeze(self, process: str) -> None:
        """Hold a process where it is, as a machine does that has no time for it."""
        self._processes[process].freeze()

    def thaw(self, process: str) -> None:
        """Let a frozen process go on."""
        self._processes[process].thaw()

    # Services

    def _ask(self, kind: type, service: str, **fields: object) -> None:
        response = self._call(kind, service, **fields)
        if not response.success:
            raise RefusedError(f"{service}: {response.message}")

    def _call(self, kind: Any, service: str, **fields: object) -> Any:
        with self._waiting():
            return self._observer.call(kind, service, **fields)


def _as_law(law: Law | float | None) -> Law | None:
    if law is None or callable(law):
        return law
    voltage = law
    return lambda _: voltage
