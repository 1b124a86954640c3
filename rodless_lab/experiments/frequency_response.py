# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Frequency response of the rig in steady motion, beside that of its linear model."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodless_lab.experiments.experiment import Experiment, Options
from rodless_lab.experiments.result import Comparison, Limits, Picture
from rodless_lab.figures.style import PRESET_COLOURS, label, panels
from rodless_lab.simulation.linear_model import LinearModel
from rodless_lab.simulation.linearise import linearise
from rodless_sim import RigParameters, simulate

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

SAMPLE_PERIOD = 1e-3  # s
REPETITION = 2.0  # s; the first is left out, the second measured
RUNS = 16  # each with phases of its own: what they do not share is no linear response
LINES = np.unique(np.round(np.geomspace(1.0, 100.0, 16) * REPETITION)) / REPETITION  # Hz
AMPLITUDE = 0.02  # V, root mean square of the whole excitation

# Both presets slide at about 10 to 15 mm/s there: beyond the fall of friction, and slow enough to
# stay near the middle for as long as it takes.
BIAS = 5.5  # V
CENTRE = 0.1  # m

# What no linear model has: temperatures of the chambers, and the play of the spool.
LINEAR = {"chambers.thermodynamics": "adiabatic", "valve.hysteresis": 0.0}

LEAST_COHERENCE = 0.9
COHERENT = Limits(LEAST_COHERENCE, 1.0, "below 0.9 the response is not linear")
GAIN = Limits(0.0, 5.0, "a linear model whose gain is 5 % off is no help in design")
PHASE = Limits(0.0, 3.0, "nor one whose phase is 3° off")


@dataclass(frozen=True)
class Response:
    """Velocity per volt at ``LINES``, as measured and as the linear model has it; SI."""

    model: LinearModel
    measured: Complex  # m/(s·V)
    expected: Complex  # m/(s·V), samples and hold of the measurement included
    coherence: Array

    @property
    def deviation(self) -> Complex:
        """Measured over expected, where the response is coherent."""
        coherent = self.coherence >= LEAST_COHERENCE
        found: Complex = self.measured[coherent] / self.expected[coherent]
        return found


@dataclass(frozen=True)
class FrequencyResponse:
    """Responses by preset."""

    responses: Mapping[str, Response]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """How far gain and phase are from the linear model's."""
        return tuple(row for preset in self.responses for row in self._rows(preset))

    def _rows(self, preset: str) -> Iterator[Comparison]:
        response = self.responses[preset]
        gain = np.abs(np.abs(response.deviation) - 1.0).max() * 1e2
        phase = np.degrees(np.abs(np.angle(response.deviation))).max()
        paper = "not measured"
        yield Comparison(
            f"{preset}: least coherence, 1 to 100 Hz",
            float(response.coherence.min()),
            "",
            paper,
            COHERENT,
            decimals=3,
        )
        yield Comparison(
            f"{preset}: gain, largest deviation from the linear model", gain, "%", paper, GAIN
        )
        yield Comparison(
            f"{preset}: phase, largest deviation from the linear model", phase, "°", paper, PHASE
        )

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Bode diagram of voltage to velocity."""
        caption = f"Velocity per volt about {BIAS:g} V, mid-stroke: gain and phase"
        return (Picture("frequency_response", caption, self.draw),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is measured, and how."""
        return (
            f"The carriage slides through mid-stroke at {BIAS:g} V. {len(LINES)} sines of random "
            f"phases, {AMPLITUDE * 1e3:g} mV RMS together, are added to the voltage in each of "
            f"{RUNS} runs; what a run without them does is subtracted. The true velocity is taken, "
            "without instruments.",
            "The linear model is `rodless_lab.linearise` about that motion, seen through samples "
            "and hold of 1 ms. Temperatures of the chambers and the play of the spool, which no "
            "linear model has, are off.",
        )

    def draw(self) -> Figure:
        """Draw gain and phase over frequency; the linear model as a line."""
        figure, (gain, phase) = panels(2, share_x=True)
        for preset, response in self.responses.items():
            pair = np.array([response.expected, response.measured])
            self._draw(gain, preset, *(np.abs(pair) * 1e3))
            self._draw(phase, preset, *np.degrees(np.unwrap(np.angle(pair))))
        gain.set_yscale("log")
        label(gain, "", "gain / (mm/s per V)")
        label(phase, "frequency / Hz", "phase / °")
        return figure

    @staticmethod
    def _draw(axes: Axes, preset: str, expected: Array, measured: Array) -> None:
        colour = PRESET_COLOURS[preset]
        axes.semilogx(LINES, expected, color=colour, label=f"{preset}, linear model")
        axes.semilogx(LINES, measured, "o", color=colour, markersize=4, label=f"{preset}, measured")


def run_frequency_response(
    presets: Sequence[str] = Options.presets, seed: int = Options.seed
) -> FrequencyResponse:
    """Measure both presets; ``seed`` draws the phases."""
    return FrequencyResponse({preset: respond(preset, seed) for preset in presets})


def respond(preset: str, seed: int) -> Response:
    """Measure one preset."""
    rig = RigParameters.preset(preset).with_values(LINEAR)
    model = linearise(rig, CENTRE, BIAS)
    count = round(REPETITION / SAMPLE_PERIOD)
    undisturbed = velocity(rig, model, np.zeros(2 * count))
    generator = np.random.default_rng(seed)
    excitations = [random_phases(generator, 2 * count) for _ in range(RUNS)]
    voltages = np.array([spectrum(one[count:]) for one in excitations])
    answers = np.array(
        [spectrum((velocity(rig, model, one) - undisturbed)[count:]) for one in excitations]
    )
    cross = np.mean(np.conj(voltages) * answers, axis=0)
    power = np.mean(np.abs(voltages) ** 2, axis=0)
    return Response(
        model,
        measured=cross / power,
        expected=model.sampled_response(LINES, SAMPLE_PERIOD, "velocity"),
        coherence=np.abs(cross) ** 2 / power / np.mean(np.abs(answers) ** 2, axis=0),
    )


def random_phases(generator: np.random.Generator, count: int) -> Array:
    """Return ``count`` samples of a sum of sines of random phases, V."""
    phases = generator.uniform(0.0, 2.0 * np.pi, len(LINES))
    angles = 2.0 * np.pi * np.outer(np.arange(count) * SAMPLE_PERIOD, LINES) + phases
    sines: Array = np.cos(angles).sum(axis=1)
    excitation: Array = AMPLITUDE * np.sqrt(2.0 / len(LINES)) * sines
    return excitation


def velocity(rig: RigParameters, model: LinearModel, added: Array) -> Array:
    """Return the velocity (m/s) at the start of each sample, with ``added`` (V) at the valve.

    The carriage passes the operating point in the middle of the second repetition.
    """
    motion = model.point.motion
    start = motion.position - motion.velocity * 1.5 * REPETITION
    pressures = (motion.pressure_a, motion.pressure_b)
    run = simulate(rig, model.point.voltage + added, SAMPLE_PERIOD, start, pressures)
    before_last: Array = run.velocity[:-1]
    return before_last


def spectrum(samples: Array) -> Complex:
    """Return the amplitudes at ``LINES`` of samples of one repetition."""
    lines: Complex = np.fft.rfft(samples)[np.round(LINES * REPETITION).astype(int)]
    return lines


EXPERIMENT = Experiment(
    name="frequency-response",
    title="Frequency response",
    source="not in the paper",
    summary=(
        f"The valve's voltage swings by {AMPLITUDE * 1e3:g} mV RMS about {BIAS:g} V while the "
        "carriage slides through mid-stroke."
    ),
    run=lambda options: run_frequency_response(options.presets, options.seed),
    takes=("presets", "seed"),
)
