"""The rig's instruments at work, sample after sample."""

import numpy as np

from rodless_base.kernels import specialise
from rodless_sim.instruments.instruments import Instruments, Lags, Readings, read_rig
from rodless_sim.instruments.transmitter import Transmitter
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.plant import piston_area
from rodless_sim.rig import State
from rodless_sim.timing import nanoseconds

# Numbers drawn for each sample: position, chambers A and B, supply.
NOISE_CHANNELS = 4


def drawn(parameters: RigParameters) -> tuple[Instruments, np.random.Generator]:
    """Return the instruments that ``sensors.seed`` stands for, and what then draws their noise."""
    generator = np.random.default_rng(int(parameters.number("sensors.seed")))
    return Instruments.drawn(parameters, generator), generator


class Sensing:
    """Reads the instruments of a rig; each start with the same seed gives the same readings."""

    def __init__(self, parameters: RigParameters) -> None:
        """Draw the instruments of ``parameters``."""
        self._take(parameters)
        example = Readings(0.0, 0.0, 0.0, 0.0)
        lags = Lags(example, example)
        self._read = specialise(
            read_rig, self._instruments, lags, example, 0.0, np.zeros(NOISE_CHANNELS)
        )
        self.start()

    def configure(self, parameters: RigParameters) -> None:
        """Change the instruments; their noise goes on, unless the seed is another."""
        before = self._parameters["sensors.seed"]
        self._take(parameters)
        if parameters["sensors.seed"] != before:
            self.start()

    def _take(self, parameters: RigParameters) -> None:
        self._parameters = parameters
        self._instruments, _ = drawn(parameters)
        self._ideal = all(
            tool == Transmitter(tool.span) for tool in self._instruments[:NOISE_CHANNELS]
        )
        self._period = nanoseconds(parameters.number("time.period")) * 1e-9
        self._area = piston_area(parameters)

    def start(self) -> None:
        """Begin with sample 0, its lags settled."""
        _, self._generator = drawn(self._parameters)
        self._before: Lags | None = None
        self._after: Lags | None = None
        self._noise = self._generator.standard_normal(NOISE_CHANNELS)

    def step(self) -> None:
        """Go on to the sample one period later."""
        self._before = self._after
        if not self._ideal:
            self._noise = self._generator.standard_normal(NOISE_CHANNELS)

    def read(self, state: State, supply_pressure: float) -> tuple[State, float]:
        """Return ``state`` and ``supply_pressure`` as read in the present sample.

        Force is A (P_a - P_b) of the readings. Velocity and mass flows, which nothing on the rig
        measures, stay true.
        """
        if self._ideal:
            self._after = None
            return state, supply_pressure
        true = Readings(state.position, state.pressure_a, state.pressure_b, supply_pressure)
        before = self._before or Lags(true, true)
        shown, self._after = self._read(
            self._instruments, before, true, self._period if self._before else 0.0, self._noise
        )
        seen = state._replace(
            position=shown.position,
            pressure_a=shown.pressure_a,
            pressure_b=shown.pressure_b,
            force=self._area * (shown.pressure_a - shown.pressure_b),
        )
        return seen, shown.supply_pressure
