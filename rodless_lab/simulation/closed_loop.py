# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rig and control law in one loop, without ROS: compiled, or step by step for a law in Python."""

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.kernels import linked, unlinked
from rodless_base.measurement import Measurement
from rodless_base.memory import refuse_more_than_there_is, room_for
from rodless_base.one_line import OneLineError, shown
from rodless_control import ControllerParameters, ReferencePoint
from rodless_control.controller import (
    CompiledLaw,
    FunctionLaw,
    Kernels,
    Law,
    LawError,
    checked_base,
    checked_terms,
    law_name,
    output_limits,
)
from rodless_control.laws import law_with, make_law
from rodless_control.parameters import LawParameters
from rodless_control.references import Reference, sampled
from rodless_lab.simulation.asked_law import LawFailedError, ask
from rodless_lab.simulation.stepped_loop import needs_steps, run_stepped
from rodless_sim import Rig, RigParameters, Trace
from rodless_sim.instruments.instruments import Instruments, Lags, read_rig, truth
from rodless_sim.instruments.sampling import NOISE_CHANNELS, are_ideal, instruments_and_noise
from rodless_sim.physics.course import course_at, spool_of
from rodless_sim.physics.dead_time import advance_period, arriving
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.faults import simulation_error
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import AnySpool
from rodless_sim.physics.state import AnyMotion
from rodless_sim.physics.timed import memory_of
from rodless_sim.rig import BYTES_OF_A_NUMBER, starting_motion
from rodless_sim.rig import rig_parameters as checked
from rodless_sim.scenario import AnyScenario
from rodless_sim.timing import nanoseconds, sample_times, step_nanoseconds
from rodless_sim.trace import MOST_COLUMNS, columns_of, read_only, record, trace

Array = npt.NDArray[np.float64]

# What a trace has beside the columns of a run's rows.
GIVEN = {"time", "voltage", "force"}

# What the node takes for a reference, too.
REACH = ControllerParameters.DECLARATIONS["reference.target"]

# Numbers that a run keeps of each sample, at the most: noise, reference, rows, their copies by
# columns, times, reference and error; and for the voltage and each term, the command and its copy.
NUMBERS_PER_SAMPLE = NOISE_CHANNELS + 3 * 2 + 2 * MOST_COLUMNS + 8
NUMBERS_PER_COMMAND = 3

# What a run made step by step keeps of each sample beside: state and measurement, as of Python.
BYTES_OF_A_STATE = BYTES_OF_A_NUMBER * (MOST_COLUMNS + len(Measurement._fields))

# Rows, commands, number of samples done, fault, last state and last place of the spool of a run.
LoopResult = tuple[Array, Array, int, int, AnyMotion, AnySpool]

# What closed_loop takes for a law.
AnyLaw = (
    Law
    | type[Law]
    | LawParameters
    | ControllerParameters
    | Callable[[Measurement, ReferencePoint], float]
)


class ClosedLoopTrace(Trace):
    """A run of the rig with the reference it followed and the error r − y.

    Position, pressures and force are as the instruments of ``sensors.*`` read them, the rest is
    true. :func:`rodless_sim.simulate` of ``voltage`` gives the true ones. ``true_position`` (m) is
    that of the carriage, no column of the table. ``terms`` holds the law's TERMS by name, one entry
    per sample.

    :meth:`columns`, and so what is saved, has the terms too, behind the other columns. Their units
    are empty, since a law does not state them. A term that equals the column of its name, such as
    the PID's ``error``, is left out; one that differs becomes ``term_<name>``.
    """

    reference: Annotated[Array, "m", "reference for the position"]
    error: Annotated[Array, "m", "reference less the position read"]

    true_position: Array
    terms: Mapping[str, Array] = MappingProxyType({})
    _term_columns: Mapping[str, Array] = MappingProxyType({})

    def __init__(self, true_position: Array | None = None, **columns: Array) -> None:
        """Take the columns, and the true position where the one read has errors."""
        super().__init__(**columns)
        true = self.position if true_position is None else read_only(true_position)
        vars(self)["true_position"] = true

    def with_terms(self, terms: Mapping[str, Array]) -> "ClosedLoopTrace":
        """Return the same run with the law's terms, one entry per sample each."""
        own = self._own_columns()
        terms = {name: read_only(values) for name, values in terms.items()}
        run = ClosedLoopTrace(self.true_position, **own)
        vars(run)["terms"] = MappingProxyType(terms)
        vars(run)["_term_columns"] = {
            f"term_{name}" if name in own else name: values
            for name, values in terms.items()
            if name not in own or not np.array_equal(values, own[name], equal_nan=True)
        }
        return run

    def __getstate__(self) -> dict[str, object]:
        """Return what :mod:`pickle` and :mod:`copy` can have."""
        return {
            **self._own_columns(),
            "true_position": self.true_position,
            "terms": dict(self.terms),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take it back."""
        terms = state.pop("terms")
        super().__setstate__(state)
        vars(self).update(vars(self.with_terms(terms)))

    def columns(self) -> dict[str, Array]:
        """Return the arrays by name, the law's terms last."""
        return {**self._own_columns(), **self._term_columns}

    def units(self) -> dict[str, str]:
        """Return the unit of each column by name; empty for the law's terms."""
        return {**super().units(), **dict.fromkeys(self._term_columns, "")}

    def _own_columns(self) -> dict[str, Array]:
        return {name: getattr(self, name) for name in super().units()}


def begin(gains: Any, measurement: Measurement) -> Any:
    """Return the law's memory before its first sample; the loop's copies have the law's own."""
    raise NotImplementedError


def update(
    gains: Any, memory: Any, measurement: Measurement, reference: ReferencePoint, interval: float
) -> Any:
    """Return memory and command of the law; the loop's copies have the law's own."""
    raise NotImplementedError


def run_closed_loop(
    plant: Plant,
    instruments: Instruments,
    noise: Array,
    gains: Any,
    limits: tuple[float, float],
    references: Array,
    state: AnyMotion,
    spool: AnySpool,
    tolerance: float,
    period: int,
    recorded: int,
    columns: int,
) -> LoopResult:
    """Control ``state`` along ``references`` (shape (n, 2): m, m/s), one row per sample.

    ``noise``, shape (n, 4), are what the instruments' noise is made of, ``period`` is in ns and
    ``limits`` in V. Returns the rows of :func:`rodless_sim.trace.record` as read, shape
    (n, recorded); the commands, shape (n, columns + 1): the voltage, within ``limits``, the law's
    terms, and the true position (m); the number of samples done: fewer than n where the law's
    voltage was not finite, or where the motion ended with the fault that comes next; and the last
    state and spool.
    """
    rows = np.empty((len(references), recorded))
    commands = np.empty((len(references), columns + 1))
    true = truth(plant, 0, state)
    lags = Lags(true, true)
    read, _ = read_rig(instruments, lags, true, noise[0])
    memory = begin(gains, read)
    seconds = period * SECONDS_PER_NANOSECOND
    closed = plant.valve.closed_voltage
    for k in range(len(references)):
        since = 0.0 if k == 0 else seconds
        read, lags = read_rig(instruments, lags, truth(plant, k * period, state), noise[k])
        reference = ReferencePoint(references[k, 0], references[k, 1])
        memory, command = update(gains, memory, read, reference, since)
        for column in range(columns):
            commands[k, column] = command[column]
        commands[k, columns] = state.position
        if not math.isfinite(command[0]):
            return rows, commands, k, 0, state, spool
        voltage = min(max(command[0], limits[0]), limits[1])
        commands[k, 0] = voltage
        arrivals = arriving(plant.drive, commands[:, 0], k, period, closed)
        course = course_at(plant, spool, arrivals[0])
        flows = inflows(plant, course, state)
        record(plant, state, course, flows, rows[k])
        rows[k, 0], rows[k, 2], rows[k, 3] = read.position, read.pressure_a, read.pressure_b
        # A run ends with its last sample: nobody sees what comes after it.
        if k + 1 < len(references):
            state, course, fault = advance_period(
                plant, course, state, flows, arrivals, period, tolerance
            )
            spool = spool_of(course)
            if fault != 0:
                return rows, commands, k, fault, state, spool
    return rows, commands, len(references), 0, state, spool


@cache
def compiled_loop(kernels: Kernels) -> Callable[..., LoopResult]:
    """Return the loop compiled together with a law."""
    return linked(run_closed_loop, begin=kernels.begin, update=kernels.update)


def plain_loop(law: Law) -> Callable[..., LoopResult]:
    """Return the loop in Python, around a law in Python."""

    def begin_plain(_gains: None, _measurement: Measurement) -> None:
        """Keep no memory: the law does."""

    def update_plain(
        _gains: None,
        _memory: None,
        measurement: Measurement,
        reference: ReferencePoint,
        interval: float,
    ) -> tuple[None, tuple[float, ...]]:
        # A law divides by zero as it does in the node: numpy's numbers would go on with infinity.
        reference = ReferencePoint(float(reference.position), float(reference.velocity))
        return None, ask(law, measurement, reference, interval)

    return unlinked(run_closed_loop, begin=begin_plain, update=update_plain)


def loop_of(law: Law) -> tuple[Callable[..., LoopResult], Any]:
    """Return the loop around a law, and the gains it takes; compiled where the law is."""
    if isinstance(law, CompiledLaw) and is_compiled(law):
        return compiled_loop(law.KERNELS), law.gains
    return plain_loop(law), None


def is_compiled(law: Law) -> bool:
    """Whether a law runs in the compiled loop."""
    # A subclass that updates in Python wants to be asked there.
    return isinstance(law, CompiledLaw) and type(law).update is CompiledLaw.update


def as_law(law: AnyLaw) -> Law:
    """Return the law that is meant; raises TypeError for what is none."""
    if isinstance(law, Law):
        return law
    if isinstance(law, type) and issubclass(law, Law):
        return law()
    if isinstance(law, ControllerParameters):
        return make_law(law.LAW_CLASS, law.of_law())
    if isinstance(law, LawParameters):
        return law_with(law)
    if callable(law) and not isinstance(law, type):
        return FunctionLaw(law)
    raise TypeError(
        f"{shown(law)} is no control law: give a Law, a law's parameters, or a function "
        "(measurement, reference) -> voltage in V"
    )


def limits_of(law: Law) -> tuple[float, float]:
    """Return the lowest and the highest command in V; raises TypeError for a law without."""
    return output_limits(checked_base(law).parameters)


def sample_count(duration: int, period: int) -> int:
    """Return the number of samples of a run (ns); raises ValueError for less than one period."""
    if duration < period:
        raise ValueError(
            f"duration {duration * SECONDS_PER_NANOSECOND:g} s refused: shorter than one period, "
            f"{period * SECONDS_PER_NANOSECOND:g} s; the duration comes first"
        )
    return round(duration / period) + 1


def closed_loop(
    rig_parameters: RigParameters,
    law: AnyLaw,
    reference: Reference,
    duration: float,
    period: float,
    position: float | None = None,
    scenario: AnyScenario | None = None,
) -> ClosedLoopTrace:
    """Control a rig at rest for ``duration`` s with a sample and a command every ``period`` s.

    Samples 0 to ``duration``/``period`` are returned, that being rounded to a whole number: the
    nearest, the even one of two. The law is given what the instruments of
    ``sensors.*`` read.

    Parameters
    ----------
    rig_parameters
        The rig.
    law
        A law of :mod:`rodless_control` or of your own, a law's parameters, or a function of
        measurement and reference that returns a voltage in V. The law is reset first; a law in
        plain Python keeps what the run leaves in it.
    reference
        Where the carriage should be: position (m) and velocity (m/s) by plant time (s).
    duration, period
        In s, to the nanosecond.
    position
        Where the carriage starts, in m (default ``cylinder.initial_position``).
    scenario
        Changes of the rig's parameters at given times, or the path of their file. With one, and
        with faults of the valve or late or missing readings, the run is made step by step, at some
        seventy times real time. A reading that the law uses and that is not finite closes the
        valve, as in the node.

    Raises
    ------
    ValueError
        For times that are not positive, a duration shorter than one period, a position outside the
        stroke, a reference farther away than any rig is long, and a law or reference that answers
        with something that is no command or no point; that text names law or reference, time and
        answer. For more samples than there is memory
        for.
    ParameterError
        For parameters that are no law's.
    TypeError
        For what is no law or no reference, for ``TERMS`` that cannot be columns, and for a law
        whose ``__init__`` did not call its base class's.
    SimulationError
        Where the motion leaves what a rig can do.
    ScenarioError
        For a scenario that this rig cannot follow.

    Examples
    --------
    >>> from rodless_control import PidParameters, references
    >>> step = references.step(0.0, 0.058, at=0.1)
    >>> run = closed_loop(RigParameters(), PidParameters(), step, duration=3.0, period=1e-3)
    >>> bool(abs(run.error[-1]) < 2e-4)
    True

    The same with a law of one line, 0.1 V per mm:

    >>> run = closed_loop(
    ...     RigParameters(), lambda m, r: 5.08 + 100.0 * (r.position - m.position), step, 0.5, 1e-3
    ... )
    >>> len(run.voltage)
    501
    """
    checked(rig_parameters)
    loop = Loop(law, reference, duration, period)
    try:
        run = loop.run(rig_parameters, position, scenario)
    except LawFailedError as failure:
        # Who wrote the law sees the own exception, with the own line in its traceback.
        raise failure.raised from None
    return loop.traced(run)


def refuse_beyond_any_rig(positions: Array, times: Array) -> None:
    """Raise ValueError for a reference (m) beyond what `reference.target` may be: likely mm."""
    beyond = np.flatnonzero((positions < REACH.minimum) | (positions > REACH.maximum))
    if beyond.size:
        first = beyond[0]
        raise OneLineError(
            f"at {times[first]:g} s: the reference asks for {positions[first]:g} m, must be from "
            f"{REACH.minimum:g} to {REACH.maximum:g} m; positions are in m"
        )


class LoopRun(NamedTuple):
    """What a loop leaves of a run, one row per sample."""

    names: Sequence[str]  # of the columns of rows
    areas: float | Array  # of the piston, m²
    rows: Array  # shape (n, k): as :func:`rodless_sim.trace.record`, as read
    commands: Array  # shape (n, m): voltage (V), the law's terms, true position (m)

    @property
    def flows(self) -> int:
        """The column of ``rows`` with the mass flow into A; that into B follows."""
        return self.names.index("mass_flow_a")


class Loop:
    """A law, a reference and times: what the runs of many rigs have in common.

    Several threads may :meth:`run` rigs at once where the law is compiled.
    """

    def __init__(self, law: AnyLaw, reference: Reference, duration: float, period: float) -> None:
        """Prepare the loop; raises as :func:`closed_loop`."""
        self._span = step_nanoseconds(period, "period")
        whole = nanoseconds(duration)
        count = sample_count(whole, self._span)
        self.law = as_law(law)
        self._terms = checked_terms(type(self.law))
        numbers = NUMBERS_PER_SAMPLE + NUMBERS_PER_COMMAND * (1 + len(self._terms))
        self.size = 8 * numbers * count
        self._times_in_words = (
            f"duration {whole * SECONDS_PER_NANOSECOND:g} s at period "
            f"{self._span * SECONDS_PER_NANOSECOND:g} s"
        )
        self._refuse_beyond_memory(self.size, count)
        self._limits = limits_of(self.law)
        self.times = sample_times(count, self._span)
        self.references = sampled(reference, self.times)  # shape (n, 2): m, m/s
        self.wanted = self.references[:, 0].copy()  # shape (n,): m
        refuse_beyond_any_rig(self.wanted, self.times)
        self._noise_shape = (count, NOISE_CHANNELS)
        self._no_noise = np.zeros(self._noise_shape)

    def _refuse_beyond_memory(self, size: int, count: int) -> None:
        refuse_more_than_there_is(
            size,
            f"{self._times_in_words} refused: {count} samples",
            "shorten it, or lengthen the period",
        )

    @property
    def compiled(self) -> bool:
        """Whether the law is, so that a run releases the GIL."""
        return is_compiled(self.law)

    @property
    def room(self) -> int:
        """How many runs at once there is memory for."""
        return room_for(self.size)

    def run(
        self,
        rig_parameters: RigParameters,
        position: float | None = None,
        scenario: AnyScenario | None = None,
    ) -> LoopRun:
        """Control a rig that starts at rest at ``position`` (m); raises as :func:`closed_loop`."""
        checked(rig_parameters)
        if scenario is not None or needs_steps(rig_parameters):
            return self._run_stepped(rig_parameters, position, scenario)
        plant = Plant.of(rig_parameters)
        start = starting_motion(plant, rig_parameters, position)
        self.law.reset()
        instruments, generator = instruments_and_noise(rig_parameters)
        ideal = are_ideal(instruments)
        run, gains = loop_of(self.law)
        rows, commands, done, fault, state, spool = run(
            plant,
            instruments,
            self._no_noise if ideal else generator.standard_normal(self._noise_shape),
            gains,
            self._limits,
            self.references,
            start,
            memory_of(plant, start, plant.valve.closed_voltage),
            rig_parameters.number("time.tolerance"),
            self._span,
            len(columns_of(plant)),
            1 + len(self._terms),
        )
        if fault:
            raise simulation_error(fault, float(self.times[done]), state, spool)
        if done < len(self.times):
            raise LawError(
                f"at {self.times[done]:g} s: {law_name(self.law)} answered {commands[done, 0]!s} "
                "V: must be a finite number"
            )
        return LoopRun(columns_of(plant), plant.cylinder.piston_area, rows, commands)

    def _run_stepped(
        self, rig_parameters: RigParameters, position: float | None, scenario: AnyScenario | None
    ) -> LoopRun:
        count = len(self.times)
        self._refuse_beyond_memory(self.size + BYTES_OF_A_STATE * count, count)
        rig = Rig(rig_parameters, scenario)
        rig.reset(position)
        # A compiled law remembers in the object what it keeps to itself in the compiled loop.
        law = copy(self.law) if self.compiled else self.law
        law.reset()
        run = run_stepped(rig, law, self.references, self._span)
        names = [name for name in run.columns if name not in GIVEN]
        rows = np.column_stack([run.columns[name] for name in names])
        commands = np.column_stack([run.commands, run.true_position])
        return LoopRun(names, run.areas, rows, commands)

    def traced(self, run: LoopRun) -> ClosedLoopTrace:
        """Return a run as named columns."""
        voltage, *terms, position = run.commands.T.copy()
        found = trace(run.names, run.areas, self._span, voltage, run.rows)
        named = ClosedLoopTrace(
            position,
            **found.columns(),
            reference=self.wanted.copy(),
            error=self.wanted - found.position,
        )
        return named.with_terms(dict(zip(self._terms, terms, strict=True)))
