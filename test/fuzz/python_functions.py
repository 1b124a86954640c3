# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Every public function and class of the packages, given odd arguments."""

import copy
import math
import pickle
from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from draw import Draw
from target import Change, Target

import rodless_control
import rodless_lab
import rodless_sim
from rodless_base.parameter_file import number_meant
from rodless_base.parameters import Parameter, ParameterSet
from rodless_control import (
    ControllerParameters,
    Measurement,
    Pid,
    PidParameters,
    ReferencePoint,
    references,
)
from rodless_control.controller_parameters import ControllerParameters as Controller
from rodless_control.laws import LAWS
from rodless_control.loop import ControlLoop
from rodless_control.setpoint import SetpointFollower
from rodless_control.trajectory import Trajectory, Waypoint
from rodless_lab import (
    Range,
    closed_loop,
    draw,
    ensemble,
    identification,
    linearise,
    read_bag,
    read_commands,
    read_run,
    run_metrics,
    sweep,
)
from rodless_lab.gym import RigEnv
from rodless_lab.runs.measured_run import MeasuredRun, run_of_trace
from rodless_lab.runs.step_metrics import step_metrics
from rodless_sim import Rig, RigParameters, Scenario, simulate
from rodless_sim.scenario import shipped_scenario

RIG = RigParameters.preset("paper")
CONTROLLER = ControllerParameters.preset("paper")
CONTROLLERS = {law: ControllerParameters.for_law(law).preset("paper") for law in LAWS}
RUN = simulate(RIG, [6.0] * 30 + [5.08] * 30, 1e-3)
MEASURED = run_of_trace(RUN, RIG.number("supply.pressure"))

LOOP = closed_loop(RIG, CONTROLLER, references.step(0.0, 0.05, at=0.01), 0.02, 1e-3)
MODEL = linearise(RIG, 0.1, 6.0)

_SPEEDS = np.linspace(1e-3, 0.1, 30)
_FORCES = 12.0 + 4500.0 * _SPEEDS
_VOLTS = np.linspace(0.1, 4.9, 30)
_SECONDS = np.arange(600) * 1e-3

# What takes rows of measured numbers, and rows with which it works.
ROWS: dict[Callable[..., object], dict[str, object]] = {
    identification.auxiliary_lines: {"speeds": _SPEEDS, "forces": _FORCES, "breakaway": 30.0},
    identification.fit_area_curve: {"voltages": _VOLTS, "areas": _VOLTS * 1e-7, "start": None},
    identification.fit_flow_coefficient: {
        "deflections": _VOLTS, "coefficients": 1.1 - 0.01 * _VOLTS, "weights": np.ones(30),
    },
    identification.fit_friction: {
        "speeds": _SPEEDS, "forces": _FORCES, "speed_errors": 1e-6, "force_errors": np.ones(30),
        "breakaways": (30.0,), "breakaway_errors": 0.1, "stops": (), "stop_errors": None,
    },
    identification.stick_slip_events: {
        "time": _SECONDS, "position": _SECONDS, "force": _SECONDS, "lag": 0.0,
    },
    identification.three_sines: {
        "coefficients": np.array([2e-6, 0.5, 0.0] * 3), "voltage": _VOLTS,
    },
    identification.uniform_parts: {
        "time": _SECONDS, "position": _SECONDS, "window": 0.25, "tolerance": 0.05,
    },
}  # fmt: skip

# Given where a function leaves open what is in it.
TIMES = np.linspace(0.0, 1.0, 50)


class Call(NamedTuple):
    """A function and arguments with which it works; each is made anew for each call."""

    function: Callable[..., object]
    arguments: dict[str, Callable[[], Any]]


def rig_after(do: str) -> Callable[..., object]:
    """Return a function that does something with a new rig, and shows what has become of it."""

    def call(**arguments: object) -> object:
        rig = Rig(RIG)
        rig.advance(6.0, 1e-3)
        before = rig.state
        try:
            getattr(rig, do)(**arguments)
        except Exception:
            assert rig.state == before, "a refusal has changed the rig"
            raise
        return rig.state, rig.read()

    return call


def sampled(kind: Callable[..., Any]) -> Callable[..., object]:
    """Return a function that makes a reference and asks it for a point and for many."""

    def call(time: float = 0.5, **arguments: float) -> object:
        reference = kind(**arguments)
        points = references.sampled(reference, TIMES)
        assert np.array_equal(points[7], reference.sample(float(TIMES[7])))
        return points, reference.sample(time)

    return call


def pid_update(position: float, reference: float, velocity: float, interval: float) -> object:
    """Let a controller answer an odd sample, then a good one: nothing of the odd one is left."""
    pid = Pid(PidParameters())
    pid.update(Measurement(0, 0.05), ReferencePoint(0.06), 0.0)
    odd = Measurement(1_000_000, position)
    pid.update(odd, ReferencePoint(reference, velocity), interval)
    return tuple(pid.update(Measurement(2_000_000, 0.05), ReferencePoint(0.06), 1e-3))


def loop_sample(
    law: str, name: str, value: object, stamp: int, position: float, pressure: float
) -> object:
    """Give the loop of a law, changed in one value, an odd sample: the commands are safe."""
    controller = CONTROLLERS[law]
    if name != "":
        controller = controller.with_values({name: value})
    loop = ControlLoop(controller)
    odd = Measurement(stamp, position, pressure, pressure, pressure)
    answers = [loop.sample(one) for one in (Measurement(0, 0.05), odd, Measurement(2**40, 0.06))]
    assert all(answer is None or 0.0 <= answer.voltage <= 10.0 for answer in answers)
    assert loop.failure is None
    return answers[1]


def any_rig(values: dict[str, object], voltage: float, duration: float) -> object:
    """Let a rig with odd values move, as far as it can."""
    rig = Rig(RIG.with_values(values))
    for _ in range(3):
        rig.advance(voltage, duration)
    # A sensor that is gone reads NaN, and should.
    gone = {name.split(".")[1] for name, value in rig.parameters.items() if value == "gone"}
    seen = rig.read()
    return rig.state, [value for name, value in seen._asdict().items() if name not in gone]


def environment(actions: object, **arguments: object) -> object:
    """Make an environment and let it live for a few steps."""
    made = RigEnv(**arguments)  # type: ignore[arg-type]
    seen = [made.reset(seed=1)[0]]
    # A failure ends the episode, and what is read then is what was read before.
    seen += [made.step(actions)[0] for _ in range(3)]
    return seen


def setpoint(target: float, position: float, velocity: float, time: float) -> object:
    """Give set-points and commands, whatever they are; the reference stays within the travel."""
    follower = SetpointFollower(Controller())
    follower.sample(0.0, 0.05)
    follower.receive(target)
    follower.receive_command(position, velocity)
    point = follower.sample(time, 0.05)
    assert -1e-9 <= point.position <= 0.2 + 1e-9
    return point


def trajectory(time: float, position: float, velocity: float, acceleration: float) -> object:
    """Take an odd waypoint after a good one."""
    points = (Waypoint(0.1, 0.05), Waypoint(time, position, velocity, acceleration))
    follower = SetpointFollower(Controller())
    follower.sample(0.0, 0.05)
    follower.receive_trajectory(points)
    return Trajectory(points).sample(0.5), follower.sample(1.0, 0.05)


def change_set(kind: type[ParameterSet], name: object, value: object) -> object:
    """Change one value of a set; the result is as valid as the set before, and is shown whole."""
    found = kind().with_values(cast("dict[str, object]", {name: value}))
    assert eval(repr(found), {kind.__name__: kind}) == found
    assert pickle.loads(pickle.dumps(found)) == found
    return dict(found)


def saved(path: str, folder: Path) -> None:
    """Save a run somewhere in a folder."""
    MEASURED.save(folder / path.replace("..", "").lstrip("/"))


def measured(time: object, position: object, voltage: object) -> object:
    """Make a run with odd columns, and use it."""
    pressure = MEASURED.pressure_a
    run = MeasuredRun(time, position, pressure, pressure, pressure, voltage)  # type: ignore[arg-type]
    return run.period


def of_rows(function: Callable[..., object]) -> Callable[..., object]:
    """Return a function that takes rows, and an odd value in the first or second of them."""

    def call(first: object, second: object, **rows: Any) -> int:
        for name, value in zip(list(rows), (first, second), strict=False):
            if value is not None and isinstance(rows[name], np.ndarray) and rows[name].ndim:
                rows[name] = [*rows[name][:3], value, *rows[name][4:]]
        function(**rows)
        return 0  # what is not informed is NaN

    return call


def constant(value: Any) -> Callable[[], Any]:
    """Return ``value``, copied."""
    return lambda: copy.copy(value)


def given(**arguments: object) -> dict[str, Callable[[], Any]]:
    """Return these arguments as they are."""
    return {name: constant(value) for name, value in arguments.items()}


def calls(folder: Path) -> dict[str, Call]:
    """Return a good call of everything public."""
    step = references.step(0.0, 0.05, at=0.01)
    return {
        "rodless_sim.RigParameters": Call(RigParameters, given(values={"supply.pressure": 6e5})),
        "rodless_sim.RigParameters.preset": Call(RigParameters.preset, given(name="paper")),
        "rodless_sim.RigParameters.with_values": Call(RIG.with_values, given(changes={})),
        "rodless_sim.RigParameters.from_file": Call(
            RigParameters.from_file, given(path=str(folder))
        ),
        "rodless_sim.RigParameters.number": Call(RIG.number, given(name="supply.pressure")),
        "change of a rig": Call(
            lambda name, value: change_set(RigParameters, name, value),
            given(name="supply.pressure", value=6e5),
        ),
        "change of a controller": Call(
            lambda name, value: change_set(PidParameters, name, value),
            given(name="controller.kp", value=600.0),
        ),
        "change of another controller": Call(
            lambda law, name, value: change_set(type(CONTROLLERS[law]), name, value),
            given(law="adrc", name="reference.start", value=0.05),
        ),
        "rodless_sim.Rig": Call(Rig, given(parameters=RIG)),
        "rodless_sim.Rig.advance": Call(rig_after("advance"), given(voltage=6.0, duration=1e-3)),
        "rodless_sim.Rig.reset": Call(rig_after("reset"), given(position=0.1, pressures=None)),
        "rodless_sim.Rig.configure": Call(rig_after("configure"), given(parameters=RIG)),
        "rodless_sim.simulate": Call(
            lambda **arguments: simulate(**arguments).columns(),
            given(parameters=RIG, voltages=[6.0] * 9, period=1e-3, position=0.1, pressures=None),
        ),
        "rodless_sim.simulate with a scenario": Call(
            lambda scenario, at, value: simulate(
                RIG,
                [6.0] * 9,
                1e-3,
                scenario=Scenario([(at, value)]) if scenario is None else scenario,
            ).columns(),
            given(scenario=None, at=2e-3, value={"fault.valve.offset": 0.1}),
        ),
        "rodless_sim.Scenario": Call(
            Scenario, given(entries=[(0.1, {"fault.valve.offset": 0.1})], name="mine")
        ),
        "rodless_sim.Scenario.from_file": Call(
            Scenario.from_file, given(path=str(shipped_scenario("leak")))
        ),
        "rodless_control.ControllerParameters": Call(
            ControllerParameters, given(values={"controller.kp": 700.0})
        ),
        "rodless_control.PidParameters": Call(
            PidParameters, given(values={"controller.kp": 700.0})
        ),
        "rodless_control.Pid": Call(Pid, given(parameters={"controller.kp": 700.0})),
        "rodless_control.Pid.update": Call(
            pid_update, given(position=0.05, reference=0.06, velocity=0.0, interval=1e-3)
        ),
        "any rig": Call(any_rig, given(values={}, voltage=6.0, duration=1e-3)),
        "rodless_lab.gym.RigEnv": Call(
            environment,
            given(rig=RIG, reference=step, duration=0.01, period=1e-3, ranges={}, actions=[6.0]),
        ),
        "control loop": Call(
            loop_sample,
            given(law="pid", name="", value=None, stamp=1_000_000, position=0.05, pressure=3e5),
        ),
        "set-point": Call(setpoint, given(target=0.05, position=0.06, velocity=0.0, time=0.1)),
        "trajectory": Call(
            trajectory, given(time=1.0, position=0.1, velocity=0.0, acceleration=0.0)
        ),
        "rodless_control.references.constant": Call(
            sampled(references.constant), given(position=0.05, time=0.5)
        ),
        "rodless_control.references.step": Call(
            sampled(references.step), given(before=0.0, after=0.05, at=0.1, time=0.5)
        ),
        "rodless_control.references.ramp": Call(
            sampled(references.ramp), given(start=0.0, target=0.05, velocity=0.1, at=0.1, time=0.5)
        ),
        "rodless_control.references.sine": Call(
            sampled(references.sine),
            given(centre=0.1, amplitude=0.05, frequency=1.0, at=0.1, time=0.5),
        ),
        "rodless_control.references.move": Call(
            sampled(references.move),
            given(
                start=0.0, target=0.1, velocity=0.1, acceleration=1.0, jerk=10.0, at=0.1, time=0.5
            ),
        ),
        "rodless_control.references.sampled": Call(
            references.sampled, given(reference=step, times=TIMES)
        ),
        "rodless_lab.closed_loop": Call(
            lambda **arguments: closed_loop(**arguments).columns(),
            given(rig_parameters=RIG, law=CONTROLLER, reference=step, duration=0.02, period=1e-3),
        ),
        "rodless_lab.closed_loop with a function": Call(
            lambda answer: closed_loop(RIG, lambda _m, _r: answer, step, 0.005, 1e-3).columns(),
            given(answer=5.5),
        ),
        "rodless_lab.ensemble": Call(
            # What a run does not have is NaN.
            lambda **arguments: len(ensemble([RIG, RIG], CONTROLLER, step, **arguments)),
            given(duration=0.02, period=1e-3, position=0.0, since=0.0, workers=2),
        ),
        "rodless_lab.sweep": Call(
            lambda **arguments: len(sweep(output=folder / "sweep", **arguments)),
            given(study="friction", workers=2),
        ),
        "rodless_lab.draw": Call(
            lambda **arguments: [dict(rig) for rig in islice(draw(**arguments), 3)],
            given(
                ranges={"supply.pressure": (5e5, 6e5)},
                count=2,
                base=RIG,
                seed=1,
                method="random",
                factors={"friction.*.static": Range(0.9, 1.1)},
            ),
        ),
        "rodless_lab.Range": Call(
            lambda **arguments: Range(**arguments).at(0.5),
            given(low=1.0, high=2.0, count=0, logarithmic=False),
        ),
        "rodless_lab.run_metrics": Call(
            lambda since: run_metrics(LOOP, since) and 0, given(since=0.0)
        ),
        "rodless_lab.linearise": Call(
            lambda **arguments: tuple(linearise(**arguments).A.ravel()),
            given(parameters=RIG, position=0.1, voltage=6.0, velocity=None),
        ),
        "rodless_lab.LinearModel": Call(
            lambda **arguments: tuple(MODEL.response(**arguments)),
            given(frequencies=[1.0, 10.0], output="velocity", source="voltage"),
        ),
        "rodless_lab.read_bag": Call(read_bag, given(path=str(folder), recover=False)),
        "rodless_lab.read_run": Call(read_run, given(path=str(folder), namespace="")),
        "rodless_lab.read_commands": Call(read_commands, given(path=str(folder), namespace="")),
        "rodless_lab.MeasuredRun": Call(
            measured,
            given(time=MEASURED.time, position=MEASURED.position, voltage=MEASURED.voltage),
        ),
        "rodless_lab.MeasuredRun.save": Call(
            lambda path: saved(path, folder), given(path="run.csv")
        ),
        "step metrics": Call(
            # What has not happened is NaN.
            lambda **arguments: (
                step_metrics(RUN.time, RUN.position, RUN.voltage, **arguments) and 0
            ),
            given(start=0.0, target=0.01, at=0.0),
        ),
        **{
            f"rodless_lab.identification.{function.__name__}": Call(
                of_rows(function), given(first=None, second=None, **arguments)
            )
            for function, arguments in ROWS.items()
        },
        "number meant": Call(number_meant, given(text="1e-5")),
    }


# What is asked at every sample takes numbers on trust; who calls it has checked them.
NUMBERS_ONLY = {
    *(
        (f"rodless_control.references.{name}", "time")
        for name in ("constant", "step", "ramp", "sine", "move")
    ),
    *(
        ("rodless_control.Pid.update", name)
        for name in ("position", "reference", "velocity", "interval")
    ),
    *(("trajectory", name) for name in ("time", "position", "velocity", "acceleration")),
    *(("set-point", name) for name in ("target", "position", "velocity", "time")),
    *(("control loop", name) for name in ("position", "pressure")),
    ("any rig", "voltage"),
    ("step metrics", "start"),
    ("step metrics", "target"),
    ("step metrics", "at"),
}

# In place of a duration, beside numbers.
ODD = (None, True, "1", b"1", [], (1.0,), 1j, {}, -1, 0, 10**400)

# What is public and has nothing to call that others here do not call.
PASSIVE = {
    "rodless_sim": {
        "HeatedState", "ParameterError", "ScenarioError", "SimulationError", "State", "Trace",
    },
    "rodless_control": {
        "Command", "CompiledLaw", "Law", "Measurement", "ParameterError", "ReferencePoint",
        "references",
    },
    "rodless_lab": {
        "Bag", "ClosedLoopTrace", "Commands", "Ensemble", "RunMetrics", "TopicMessages",
    },
    "rodless_lab.identification": {
        *(name for name in identification.__all__ if name[0].isupper()),
        # They take what has been checked, a MeasuredRun and RigParameters, and seconds.
        *(name for name in identification.__all__ if name.startswith("identify_")),
        "friction_points", "run_of_trace",
        # Formulas, which take numbers on trust.
        "effective_area", "flow_coefficient", "friction_force", "turning_points",
    },
}  # fmt: skip


def uncalled() -> set[str]:
    """Return what is public in the packages and neither called here nor passive."""
    called = calls(Path())
    return {
        f"{package.__name__}.{name}"
        for package in (rodless_sim, rodless_control, rodless_lab, identification)
        for name in {*package.__all__} - PASSIVE[package.__name__]
        if f"{package.__name__}.{name}" not in called
    }


def _good(declared: Parameter) -> Sequence[object]:
    """Return values that one parameter takes: its default, its ends, its choices."""
    if declared.name == "cylinder.model":
        return "other", "CY3R25-200", "CY3R6-50", "CY3R63-1000", "CY3R25-0", "CY3R25-2001", "CY1"
    if isinstance(declared.default, bool):
        return True, False
    if isinstance(declared.default, float):
        middle = math.sqrt(abs(declared.minimum * declared.maximum))
        return declared.default, declared.minimum, declared.maximum, middle
    return (declared.default, *declared.choices)


def _time(draw: Draw) -> object:
    """Return a time in s; days, or a second in steps of 1 ns, would take hours."""
    number = draw.float()
    if 1e-10 < number < 1e10:
        number = draw.uniform(1e-5, 1.0)
    return draw.choice(ODD) if draw.random() < 0.3 else number


class PythonFunctions(Target):
    """A change is the name of an argument, and what is given for it."""

    def __init__(self, folder: Path) -> None:
        """List what is called."""
        super().__init__(folder)
        self._calls = calls(folder)
        laws = {name for one in CONTROLLERS.values() for name in one}
        self._names = [*RigParameters(), *sorted(laws)]
        # Values that a parameter takes, whatever stands beside it.
        declared = {**RigParameters.DECLARATIONS}
        for one in CONTROLLERS.values():
            declared |= type(one).DECLARATIONS
        self._good = {name: _good(one) for name, one in declared.items()}

    def draw(self, draw: Draw) -> list[Change]:
        """Return a call, and odd arguments."""
        name = draw.choice(list(self._calls))
        arguments = draw.some(list(self._calls[name].arguments))
        return [name, *((argument, self._value(draw, name, argument)) for argument in arguments)]

    def _value(self, draw: Draw, call: str, argument: str) -> object:
        if (call, argument) in NUMBERS_ONLY:
            number = draw.float()
            # Time is counted in ns, in 64 bits: 292 years.
            return number if argument != "time" or abs(number) < 1e10 else 0.0
        if argument == "law":
            return draw.choice(list(LAWS))
        if (call, argument) == ("control loop", "name"):
            return draw.text(self._names)
        own: dict[str, Callable[[], object]] = {
            "path": lambda: draw.text([str(self.folder), "run.csv", "run.parquet"]),
            "text": lambda: draw.text(self._names),
            "name": lambda: draw.text(self._names),
            "stamp": draw.integer,
            "duration": lambda: _time(draw),
            "period": lambda: _time(draw),
            "values": lambda: self._values(draw),
            "changes": lambda: self._values(draw),
        }
        if argument in own and (call.startswith("change of") or draw.random() < 0.9):
            return own[argument]()
        if argument in ("duration", "period", "path", "text", "stamp"):
            return own[argument]()
        return draw.float() if draw.random() < 0.5 else draw.value()

    def _values(self, draw: Draw) -> dict[str, object]:
        if draw.random() < 0.5:
            return {draw.text(self._names): draw.value() for _ in range(draw.choice((1, 1, 2, 5)))}
        # What could be: many at once.
        names = draw.sample(self._names, draw.choice((1, 2, 5, 20)))
        return {name: draw.choice(self._good[name]) for name in names}

    def run(self, changes: list[Change]) -> object:
        """Call it. One without changes is good."""
        name, *odd = changes or ["rodless_sim.Rig"]
        if not isinstance(name, str):
            return None
        call = self._calls[name]
        arguments = {argument: make() for argument, make in call.arguments.items()}
        return call.function(**{**arguments, **dict(odd)})
