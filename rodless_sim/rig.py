# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig: the plant at one instant, advanced by applying a voltage for a while."""

import math
from collections.abc import Iterator, Mapping, Set
from contextlib import contextmanager
from copy import deepcopy

import numpy as np
import numpy.typing as npt

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE, SECONDS_PER_NANOSECOND
from rodless_base.kernels import is_kept, specialise
from rodless_base.measurement import Measurement
from rodless_base.memory import refuse_more_than_there_is
from rodless_base.number_rows import numbers_of
from rodless_base.one_line import shown
from rodless_base.parameters import ParameterError
from rodless_sim.commands import Commands
from rodless_sim.faults import ValveFault
from rodless_sim.instruments.sampling import Sampling
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.drift import first_dice
from rodless_sim.physics.faults import SimulationError, simulation_error
from rodless_sim.physics.full_rates import full_supply_at_valve
from rodless_sim.physics.motion import advance_at_voltage
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings, supply_flow
from rodless_sim.physics.settled import settled_motion
from rodless_sim.physics.spool import (
    AnySpool,
    Memory,
    holding_voltage,
    place_of,
    spool_in,
    starting_spool,
    with_spool,
)
from rodless_sim.physics.state import (
    TEMPERATURES,
    AnyMotion,
    FullMotion,
    HeatedMotion,
    Motion,
    State,
    state_with,
)
from rodless_sim.physics.streams import heated_supply_flow
from rodless_sim.physics.supply import rippled
from rodless_sim.physics.timed import (
    at_speed_of,
    copied,
    memory_like,
    memory_of,
    supplied_anew,
    tubes_in,
    with_tubes,
)
from rodless_sim.scenario import AnyScenario, Entry, as_scenario
from rodless_sim.scenario_player import ScenarioPlayer
from rodless_sim.single_number import single_number
from rodless_sim.timing import step_nanoseconds
from rodless_sim.trace import (
    Trace,
    columns_of,
    columns_of_states,
    further_of,
    run_open_loop,
    trace,
)
from rodless_sim.trace import shown as shown_of

# Of a trace beside those that are integrated: time, voltage, force, twice the command.
FURTHER_COLUMNS = 5

# Rows are integrated, and then columns are made of them.
COPIES = 2

# Of the state that a run made step by step keeps of each sample: a number of Python, and its place.
BYTES_OF_A_NUMBER = 32

# Flows at much more than this (Pa) overflow.
LARGEST_PRESSURE = 1e150


def applied_voltage(voltage: float) -> float:
    """Return the command as the valve takes it, within 0-10 V.

    Raises ValueError for NaN or Inf, TypeError for what is no number.
    """
    number = single_number(voltage, "voltage", "volts")
    if not math.isfinite(number):
        raise ValueError(f"voltage {shown(voltage)} refused: not a finite number")
    return min(max(number, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE)


def applied_voltages(voltages: "npt.ArrayLike") -> npt.NDArray[np.float64]:
    """Return :func:`applied_voltage` of each of ``voltages``; raises ValueError for none.

    A single number counts as one voltage.
    """
    commands = np.atleast_1d(numbers_of(voltages, "voltages", "volts"))
    if commands.ndim > 1:
        raise ValueError(
            f"voltages of shape {commands.shape} refused: must be one after the other, shape (n,); "
            "give one row or column, or ravel() them"
        )
    if not commands.size:
        raise ValueError("no voltages given")
    if not np.isfinite(commands).all():
        applied_voltage(float(commands[~np.isfinite(commands)][0]))
    return np.clip(commands, MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE)


def starting_motion(
    plant: Plant,
    parameters: RigParameters,
    position: float | None = None,
    pressures: tuple[float, float] | None = None,
    temperatures: tuple[float, float] | None = None,
) -> AnyMotion:
    """Return the state at rest that :meth:`Rig.reset` describes; raises as it does."""
    if position is None:
        position = parameters.number("cylinder.initial_position")
    start = single_number(position, "position", "metres")
    stroke = plant.cylinder.stroke
    if not 0.0 <= start <= stroke:
        raise ValueError(
            f"position {shown(position)} m refused: outside the stroke, must be from 0 to "
            f"{stroke:g} m"
        )
    given: dict[str, float] = {}
    if pressures is not None:
        given.update(zip(PRESSURES, _two_of("pressures", "Pa", pressures), strict=True))
    if temperatures is not None:
        if not plant.heated:
            raise ValueError(
                f"temperatures {shown(temperatures)} refused: all air has supply.temperature; "
                "chambers.thermodynamics energy_balance gives the chambers their own"
            )
        given.update(zip(TEMPERATURES, _two_of("temperatures", "K", temperatures), strict=True))
    if len(given) == (4 if plant.heated else 2):
        return with_states_of(plant, Motion(start, 0.0, 0.0, 0.0))._replace(**given)
    settled = settled_motion(plant, plant.valve.closed_voltage, start)
    return with_states_of(plant, settled)._replace(**given)


PRESSURES = ("pressure_a", "pressure_b")


def _two_of(name: str, unit: str, values: object) -> tuple[float, float]:
    """Return the ``values`` of chambers A and B as floats; raises ValueError."""
    try:
        if isinstance(values, str | bytes | bytearray | Set | Mapping):
            raise TypeError("no ordered pair")
        a, b = (single_number(one, name, unit) for one in values)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{name} {shown(values)} refused: must be two numbers of {unit}, for A and B"
        ) from error
    if not (0.0 < a < math.inf and 0.0 < b < math.inf):
        raise ValueError(f"{name} {a!r} and {b!r} {unit} refused: must be finite and positive")
    if name == "pressures" and max(a, b) > LARGEST_PRESSURE:
        raise ValueError(
            f"pressures {a!r} and {b!r} Pa refused: no chamber holds more than "
            f"{LARGEST_PRESSURE:g} Pa"
        )
    return a, b


def with_states_of(plant: Plant, motion: AnyMotion) -> AnyMotion:
    """Return ``motion`` with the states that ``plant`` has.

    Chambers that have just been given temperatures begin with the supply's.
    """
    if plant.full:
        return full_motion(plant, motion)
    shared = Motion(*motion[: len(Motion._fields)])
    if not plant.heat:
        return shared
    if isinstance(motion, HeatedMotion | FullMotion):
        return HeatedMotion(*shared, motion.temperature_a, motion.temperature_b)
    return HeatedMotion(*shared, plant.air.temperature, plant.air.temperature)


def full_motion(plant: Plant, motion: AnyMotion) -> FullMotion:
    """Return ``motion`` with the states of all options: those it has not had begin at rest."""
    if not isinstance(motion, FullMotion):
        warm_a = warm_b = plant.air.temperature
        if isinstance(motion, HeatedMotion):
            warm_a, warm_b = motion.temperature_a, motion.temperature_b
        motion = FullMotion(
            position=motion.position,
            velocity=motion.velocity,
            pressure_a=motion.pressure_a,
            pressure_b=motion.pressure_b,
            temperature_a=warm_a,
            temperature_b=warm_b,
            bristle_deflection=0.0,
            piston_position=motion.position,
            piston_velocity=motion.velocity,
            piston_bristle_deflection=0.0,
            coupled=1.0,
            supply_pressure=plant.supply_pressure,
            receiver_pressure=plant.full.supply.initial_pressure,
            compressor=0.0,
            friction_clock=0.0,
            friction_dice=first_dice(plant.full.drift.seed),
            static_drift=0.0,
            coulomb_drift=0.0,
            viscous_drift=0.0,
        )
    if not plant.heated:
        # The air that flows out is taken to have the supply's temperature.
        motion = motion._replace(**dict.fromkeys(TEMPERATURES, plant.air.temperature))
    return motion


def rig_parameters(parameters: object) -> RigParameters:
    """Return ``parameters``; raises TypeError for what is no :class:`RigParameters`."""
    if not isinstance(parameters, RigParameters):
        raise TypeError(f"{shown(parameters)} are no RigParameters: give RigParameters({{...}})")
    return parameters


# Uncompiled: from Python it would unpack the whole plant in each call.
_full_supply = getattr(full_supply_at_valve, "py_func", full_supply_at_valve)


def supply_at_valve(plant: Plant, motion: AnyMotion) -> float:
    """Return the supply's pressure in Pa at the valve."""
    if isinstance(motion, FullMotion):
        return float(_full_supply(plant, motion))
    return plant.supply_pressure


def at_time(plant: Plant, time: float) -> Plant:
    """Return the plant with its supply as it is at ``time`` (s)."""
    if not plant.ripple:
        return plant
    return plant._replace(supply_pressure=rippled(plant.ripple, plant.supply_pressure, time))


def kinds_of(plant: Plant) -> tuple[bool, ...]:
    """Return what decides which version of the equations a plant has."""
    return tuple(map(bool, (plant.heat, plant.drive, plant.full, plant.ripple, plant.tubes)))


def _arguments(plant: Plant, spool: AnySpool, motion: AnyMotion) -> tuple[object, ...]:
    """Return arguments of :func:`advance_at_voltage` of the types that such a rig calls it with."""
    return plant, spool, 0.0, motion, 0.0, 1.0


def equations_are_kept(parameters: RigParameters) -> bool:
    """Whether a rig of these finds its equations compiled, by this process or by another."""
    plant = Plant.of(parameters)
    motion = with_states_of(plant, Motion(0.0, 0.0, 1.0, 1.0))
    return is_kept(advance_at_voltage, *_arguments(plant, memory_like(plant), motion))


# Of what can change while a rig runs, what gives it other equations where it is switched on or off.
SWITCHES = ("supply.droop", "supply.ripple_amplitude")


class Rig:
    """A rig advanced step by step.

    It starts at rest, with the chambers settled at the closed valve.

    Parameters
    ----------
    parameters
        Those of the rig; by default all defaults, the preset ``paper``.
    scenario
        Changes of them at given times, which :meth:`advance` makes; or the path of its file.

    Examples
    --------
    >>> from rodless_sim import Rig, RigParameters
    >>> rig = Rig(RigParameters({"sensors.position_noise": 20e-6}))
    >>> for _ in range(500):
    ...     state = rig.advance(voltage=6.0, duration=1e-3)
    >>> f"{state.position * 1e3:.1f} mm, in truth"
    '9.1 mm, in truth'
    >>> abs(rig.read().position - state.position) < 1e-4
    True

    """

    def __init__(
        self, parameters: RigParameters | None = None, scenario: AnyScenario | None = None
    ) -> None:
        """Build the rig.

        Raises
        ------
        TypeError
            For what is no :class:`RigParameters`, such as a dict. Each of those makes a rig: what
            no rig has was refused when the set was made.
        ScenarioError
            For a scenario with an entry that this rig refuses.
        """
        given = RigParameters() if parameters is None else rig_parameters(parameters)
        played = as_scenario(scenario)
        self._player = None if played is None else ScenarioPlayer(played, given)
        self._take(given)
        self._sampling: Sampling | None = None
        self._nanoseconds = 0
        self._motion = with_states_of(self._plant, Motion(0.0, 0.0, 1.0, 1.0))
        self._spool = self._remembered(self._motion, self._plant.valve.closed_voltage)
        self._specialise()
        self.reset()

    def _take(self, parameters: RigParameters) -> None:
        self._parameters, self._plant = parameters, Plant.of(parameters)
        self._valve_fault = ValveFault.of(parameters)

    def _specialise(self) -> None:
        self._advance = specialise(
            advance_at_voltage, *_arguments(self._plant, self._spool, self._motion)
        )

    def ahead(self, parameters: RigParameters) -> Iterator[RigParameters]:
        """Yield all that the rig may become with ``parameters``: these, and by its scenario."""
        yield parameters
        if self._player is not None:
            yield from self._player.ahead(parameters)

    def _remembered(self, motion: AnyMotion, voltage: float) -> AnySpool:
        return memory_of(self._plant, motion, voltage, self._nanoseconds * SECONDS_PER_NANOSECOND)

    def __repr__(self) -> str:
        """Show time, position and velocity, and the parameters."""
        return (
            f"<Rig at {self._nanoseconds * SECONDS_PER_NANOSECOND:g} s: carriage at "
            f"{self._motion.position * 1e3:.3f} mm, {self._motion.velocity * 1e3:.3f} mm/s, "
            f"{self._voltage:g} V; {self._parameters!r}>"
        )

    def __copy__(self) -> "Rig":
        """Return a rig of its own, as :func:`copy.deepcopy` does: they share nothing."""
        return deepcopy(self)

    def __getstate__(self) -> dict[str, object]:
        """Leave the compiled function out: :mod:`pickle` cannot have it."""
        return {name: value for name, value in vars(self).items() if name != "_advance"}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Compile again."""
        vars(self).update(state)
        self._specialise()

    @property
    def parameters(self) -> RigParameters:
        """The parameters in force."""
        return self._parameters

    def configure(self, parameters: RigParameters) -> None:
        """Change the parameters; the carriage and the air in the chambers stay as they are.

        Time and the command stay too. The noise of the instruments goes on, unless
        ``sensors.seed`` is another.

        Parameters
        ----------
        parameters
            A whole set; :meth:`ParameterSet.with_values` of the one in force changes a few values.

        Raises
        ------
        TypeError
            For what is no :class:`RigParameters`; the rig stays as it was.
        ParameterError
            For a stroke that ends before the carriage or the piston, and for what :meth:`reset`
            could not have once it has taken back what a scenario has changed; the rig stays as it
            was.
        SimulationError
            Where the state is none that a rig of these parameters has; the rig stays as it was.

        Examples
        --------
        >>> from rodless_sim import Rig
        >>> rig = Rig()
        >>> rig.configure(rig.parameters.with_values({"supply.pressure": 0.7e6}))
        >>> rig.parameters["supply.pressure"]
        700000.0
        """
        self._check_stroke(parameters)
        self._check_way_back(parameters)
        before, stayed = self._plant, self._valve_fault.stays
        with self._all_or_nothing():
            self._take(parameters)
            self._motion = self._supplied_on(before, with_states_of(self._plant, self._motion))
            self._remember_anew(before)
            self._spool = supplied_anew(self._plant, before, self._spool, self._motion)
            if self._valve_fault.stays and not stayed:
                self._hold_spool()
            self._apply(self._voltage, self._motion, self._spool, self._commands, 0)
            if self._sampling is not None:
                self._sampling.configure(parameters)

    def _supplied_on(self, before: Plant, motion: AnyMotion) -> AnyMotion:
        """Return ``motion``; a supply that begins to sink does so from where it was."""
        sagged = before.full and before.full.supply.sags
        if sagged or not isinstance(motion, FullMotion) or not self._plant.full.supply.sags:
            return motion
        here = supply_at_valve(
            at_time(before, self._nanoseconds * SECONDS_PER_NANOSECOND), self._motion
        )
        return motion._replace(supply_pressure=here)

    @contextmanager
    def _all_or_nothing(self) -> Iterator[None]:
        """Leave the rig as it was where the block ends by an exception."""
        before = dict(vars(self))
        try:
            yield
        except BaseException:
            vars(self).update(before)
            raise

    def _remember_anew(self, before: Plant) -> None:
        """Have valve and tubes remember what those of this plant can, after another one."""
        plant = self._plant
        if plant.tubes and before.tubes and plant.tubes.delay != before.tubes.delay:
            self._spool = at_speed_of(plant, before, self._spool)
        if kinds_of(plant) == kinds_of(before):
            return
        spool, tubes = spool_in(self._spool), tubes_in(self._spool)
        self._spool = with_tubes(self._remembered(self._motion, self._voltage), tubes)
        if bool(spool) == bool(plant.drive):
            self._spool = with_spool(self._spool, spool)
        else:
            self._commands = Commands(self._voltage)
        self._specialise()

    def _hold_spool(self) -> None:
        """Stop the spool where it is: what is under way to it moves it no more."""
        place = place_of(self._spool)
        if place is not None:
            held = applied_voltage(holding_voltage(self._plant.drive, self._spool))
            self._voltage, self._commands = held, Commands(held)
            self._spool = with_spool(self._spool, starting_spool(self._plant.drive, place))

    def _check_way_back(self, parameters: RigParameters) -> None:
        """Raise ParameterError where a reset could not take back what the scenario changes."""
        if self._player is None:
            return
        try:
            self._player.at_start(parameters)
        except ParameterError as error:
            raise ParameterError(
                f"refused, as a reset takes the scenario's changes back, and then: {error}; change "
                "those parameters with it"
            ) from error

    def _check_stroke(self, parameters: RigParameters) -> None:
        stroke = rig_parameters(parameters).number("cylinder.stroke")
        motion = self._motion
        places = {"carriage": motion.position}
        if isinstance(motion, FullMotion) and self._plant.full.coupling.magnetic:
            places["piston"] = motion.piston_position
        for what, place in places.items():
            if place > stroke:
                raise ParameterError(
                    f"cylinder.stroke: {stroke:g} m refused, the {what} is at {place:g} m; move "
                    "it back or reset the rig first"
                )

    def _apply(
        self,
        voltage: float,
        motion: AnyMotion,
        spool: AnySpool,
        commands: Commands,
        span: int,
    ) -> None:
        """Advance by ``span`` ns from ``motion`` and ``spool``, piece by piece as commands arrive.

        Raises SimulationError; the rig stays as it was then.
        """
        pieces, now = [(voltage, span)], self._nanoseconds
        if self._plant.drive:
            dead_time = self._plant.drive.dead_time
            pieces, commands = commands.during(voltage, now, span, dead_time)
        tolerance = self._parameters.number("time.tolerance")
        spool = copied(spool)
        for arrived, length in pieces:
            seconds = length * SECONDS_PER_NANOSECOND
            motion, spool, flow_a, flow_b, fault = self._advance(
                self._plant, spool, arrived, motion, seconds, tolerance
            )
            if fault:
                raise simulation_error(fault, now * SECONDS_PER_NANOSECOND, motion, spool)
        self._voltage, self._motion, self._commands = voltage, motion, commands
        self._spool = spool
        self._flow_a, self._flow_b = flow_a, flow_b

    def reset(
        self,
        position: float | None = None,
        pressures: tuple[float, float] | None = None,
        temperatures: tuple[float, float] | None = None,
    ) -> State:
        """Put the carriage at rest and return the state; time returns to zero, the valve closes.

        The instruments begin anew with the same noise, and so does the scenario: what it has
        changed is as it was before.

        Parameters
        ----------
        position
            Of the carriage, m; by default ``cylinder.initial_position``.
        pressures
            In chambers A and B, Pa absolute; by default those they settle at.
        temperatures
            In chambers A and B, K, where they have temperatures of their own; by default those
            they settle at.

        Raises
        ------
        ValueError
            For a position outside the stroke, for pressures or temperatures that are not two
            numbers, finite and positive, and for temperatures where the chambers have none; the
            rig stays as it was.

        """
        given, plant = self._parameters, self._plant
        if self._player is not None:
            given = self._player.at_start(given)
            plant = Plant.of(given)
        motion = starting_motion(plant, given, position, pressures, temperatures)
        closed, kinds = plant.valve.closed_voltage, kinds_of(self._plant)
        with self._all_or_nothing():
            if given is not self._parameters:
                self._take(given)
            self._motion, self._spool = motion, memory_of(plant, motion, closed)
            if kinds_of(plant) != kinds:
                self._specialise()
            self._apply(closed, motion, self._spool, Commands(closed), 0)
        self._nanoseconds = 0
        if self._player is not None:
            self._player.restart()
        if self._sampling is not None:
            self._sampling.configure(given)
            self._sampling.start()
        return self.state

    def advance(self, voltage: float, duration: float) -> State:
        """Apply a voltage for a while and return the true state after it.

        What the instruments read then, with the errors that ``sensors.*`` give them, is what
        :meth:`read` returns.

        Parameters
        ----------
        voltage
            Command to the valve, V, which saturates at 0 and 10 V.
        duration
            In s, to the nanosecond.

        Raises
        ------
        ValueError
            For a voltage that is not finite, a duration that is not positive, one over an hour.
        SimulationError
            Where the motion leaves what a rig can do; the rig stays as it was before.
        ScenarioError
            Where the rig cannot be as the scenario has it from now on, such as with a stroke that
            ends before the carriage.

        """
        applied = self._valve_fault.voltage(applied_voltage(voltage), self._voltage)
        span = step_nanoseconds(duration)
        self._apply(applied, self._motion, self._spool, self._commands, span)
        self._nanoseconds += span
        if self._player is not None:
            self._play(self._player)
        return self.state

    def _play(self, player: ScenarioPlayer) -> None:
        """Make the changes that the scenario has for now."""
        for entry in player.due(self._nanoseconds):
            try:
                self.configure(self._parameters.with_values(entry.changes))
            except (ParameterError, SimulationError) as error:
                raise player.refusal(error) from error

    def command(self, voltage: float) -> State:
        """Give the valve a voltage and return the state that begins: time stands still.

        Raises as :meth:`advance`.
        """
        applied = self._valve_fault.voltage(applied_voltage(voltage), self._voltage)
        self._apply(applied, self._motion, self._spool, self._commands, 0)
        return self.state

    @property
    def played(self) -> tuple[Entry, ...]:
        """What the scenario has changed so far."""
        return () if self._player is None else self._player.played

    def read(self) -> Measurement:
        """Return what the instruments read now: position and pressures, errors included.

        Read twice at one instant they show the same. The first reading after a reset is sample 0,
        its lags settled; each later one is the next sample, with noise of its own and lags that
        have followed for the time since the last.
        """
        if self._sampling is None:
            self._sampling = Sampling(self._parameters)
        return self._sampling.read(self.truth)

    @property
    def truth(self) -> Measurement:
        """What instruments without errors would read now."""
        position, _, pressure_a, pressure_b = self._motion[: len(Motion._fields)]
        plant = at_time(self._plant, self._nanoseconds * SECONDS_PER_NANOSECOND)
        supply = supply_at_valve(plant, self._motion)
        return Measurement(self._nanoseconds, position, pressure_a, pressure_b, supply)

    @property
    def nanoseconds(self) -> int:
        """Plant time as an integer count of nanoseconds."""
        return self._nanoseconds

    @property
    def plant(self) -> Plant:
        """The constants of the compiled equations."""
        return self._plant

    @property
    def motion(self) -> AnyMotion:
        """Position, velocity, pressures and what else the compiled equations integrate."""
        return self._motion

    @property
    def free_air_flow(self) -> float:
        """Air taken from the supply in m³/s, dry, at ambient pressure and temperature."""
        plant, motion = self._plant, self._motion
        plant = at_time(plant, self._nanoseconds * SECONDS_PER_NANOSECOND)
        lands = openings(plant, self.state.spool_voltage)
        if isinstance(self._spool, Memory) and plant.tubes:
            tubes = self._spool.tubes
            supply = supply_at_valve(plant, motion)
            plant = plant._replace(supply_pressure=supply)
            mass_flow = supply_flow(plant, lands, tubes.a.pressure, tubes.b.pressure)
        elif isinstance(motion, HeatedMotion | FullMotion):
            supply = supply_at_valve(plant, motion)
            mass_flow = heated_supply_flow(plant, supply, lands, motion)
        else:
            mass_flow = supply_flow(plant, lands, motion.pressure_a, motion.pressure_b)
        temperature = self._parameters.number("atmosphere.temperature")
        return mass_flow * plant.air.gas_constant * temperature / plant.ambient_pressure

    @property
    def state(self) -> State:
        """The rig now: :class:`HeatedState` where its chambers have temperatures of their own."""
        motion = self._motion
        force = self._plant.cylinder.piston_area * (motion.pressure_a - motion.pressure_b)
        time = self._nanoseconds * SECONDS_PER_NANOSECOND
        position, velocity, pressure_a, pressure_b, *further = shown_of(self._plant, motion)
        place = place_of(self._spool)
        spool = [] if place is None else [place]
        return state_with(further_of(self._plant))(
            time,
            position,
            velocity,
            pressure_a,
            pressure_b,
            self._voltage,
            force,
            self._flow_a,
            self._flow_b,
            *further,
            *spool,
        )


def simulate(
    parameters: RigParameters,
    voltages: "npt.ArrayLike",
    period: float,
    position: float | None = None,
    pressures: tuple[float, float] | None = None,
    temperatures: tuple[float, float] | None = None,
    scenario: AnyScenario | None = None,
) -> Trace:
    """Drive a rig at rest with voltages, one after the other, and return the true run.

    Parameters
    ----------
    parameters
        Those of the rig.
    voltages
        Commands to the valve, shape (n,), V; it saturates at 0 and 10 V.
    period
        How long each voltage applies, s.
    position, pressures, temperatures
        Where the carriage (m) and the chambers (Pa, K) start, as :meth:`Rig.reset` takes them.
    scenario
        Changes of the parameters at given times, or the path of their file. With one, and with a
        fault of the valve, the run is made step by step, at some hundred times real time.

    Returns
    -------
    Trace
        n+1 samples, the first at the start. Its ``voltage`` is what the valve followed.

    Raises
    ------
    ValueError
        For no voltages, for what are no numbers or not of that shape, and as :meth:`Rig.advance`
        and :meth:`Rig.reset`.
    SimulationError, ScenarioError
        As :meth:`Rig.advance`.

    Examples
    --------
    >>> from rodless_sim import RigParameters, simulate
    >>> run = simulate(RigParameters.preset("paper"), [6.0] * 500, period=1e-3)
    >>> f"{run.position[-1] * 1e3:.1f} mm"
    '9.1 mm'

    """
    plant = Plant.of(rig_parameters(parameters))
    span = step_nanoseconds(period, "period")
    stepped = scenario is not None or ValveFault.of(parameters).present
    _refuse_too_many(voltages, plant, stepped)
    commands = applied_voltages(voltages)
    if stepped:
        rig = Rig(parameters, scenario)
        rig.reset(position, pressures, temperatures)
        return _stepped(rig, commands, span)
    start = starting_motion(plant, parameters, position, pressures, temperatures)
    rows, state, spool, done, fault = run_open_loop(
        plant,
        commands,
        start,
        memory_of(plant, start, plant.valve.closed_voltage),
        span,
        parameters.number("time.tolerance"),
        len(columns_of(plant)),
    )
    if fault:
        raise simulation_error(fault, done * span * SECONDS_PER_NANOSECOND, state, spool)
    held = np.append(commands, commands[-1])
    return trace(columns_of(plant), plant.cylinder.piston_area, span, held, rows)


def _refuse_too_many(voltages: object, plant: Plant, stepped: bool) -> None:
    """Raise ValueError where a trace of so many voltages has no room in memory."""
    try:
        count = len(voltages)  # type: ignore[arg-type]
    except TypeError:  # one, or nothing that can be applied
        return
    numbers = (len(columns_of(plant)) + FURTHER_COLUMNS) * count
    refuse_more_than_there_is(
        (8 * COPIES + (BYTES_OF_A_NUMBER if stepped else 0)) * numbers,
        f"{count} voltages refused: their samples",
        "apply fewer at a time",
    )


def _stepped(rig: Rig, commands: npt.NDArray[np.float64], span: int) -> Trace:
    """Apply each of ``commands`` (V) for ``span`` ns to a rig that knows its faults."""
    states = []
    for command in commands:
        states.append(rig.command(command))
        rig.advance(command, span * SECONDS_PER_NANOSECOND)
    states.append(rig.command(commands[-1]))
    return Trace(**columns_of_states(states, span))
