# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A linear model with names: what :func:`~rodless_lab.simulation.linearise.linearise` returns."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import signal

from rodless_base.columns import Quantity
from rodless_base.extras import missing_extra
from rodless_base.one_line import shown
from rodless_sim.physics.state import Motion
from rodless_sim.single_number import single_number
from rodless_sim.timing import LONGEST_STEP
from rodless_sim.trace import read_only

Array = npt.NDArray[np.float64]

HIGHEST_FREQUENCY = 1e12  # Hz


class OperatingPoint(NamedTuple):
    """The steady motion that a linear model is about: all but the position stay as they are."""

    motion: Motion  # position, velocity and pressures
    voltage: float  # V, the command
    load: float  # N, on the carriage toward chamber B's end: what keeps the velocity as asked for


@dataclass(frozen=True)
class LinearModel:
    """Small deviations from an operating point: dx/dt = A x + B u, y = C x + D u.

    Attributes
    ----------
    A, B, C, D
        The matrices, shapes (n, n), (n, m), (p, n) and (p, m), in SI units, read-only.
    states, inputs, outputs
        Name, unit and meaning of each of the n states, m inputs and p outputs.
    point
        The operating point. States and inputs are deviations from it.

    Examples
    --------
    >>> from rodless_lab import linearise
    >>> from rodless_sim import RigParameters
    >>> model = linearise(RigParameters(), position=0.1, voltage=6.0)
    >>> [state.name for state in model.states]
    ['position', 'velocity', 'pressure_a', 'pressure_b']
    >>> bool(abs(model.poles).min() < 1e-6)  # the carriage may be anywhere
    True

    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    point: OperatingPoint

    def __post_init__(self) -> None:
        """Make the matrices read-only: what is computed of the model is computed of them."""
        for name in ("A", "B", "C", "D"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take back what :mod:`pickle` and :mod:`copy` had."""
        vars(self).update(state)
        self.__post_init__()

    @property
    def poles(self) -> npt.NDArray[np.complex128]:
        """Poles in rad/s, the slowest first, shape (n,)."""
        found = np.linalg.eigvals(self._scaled()).astype(np.complex128)
        return found[np.argsort(np.abs(found))]

    def _scaled(self) -> Array:
        """Return A in units that make its entries comparable: Pa are small, metres large."""
        size = np.array(
            [{"Pa": 1e5, "m": 1e-2, "m/s": 1e-1, "V/s": 1e3}.get(s.unit, 1.0) for s in self.states]
        )
        scaled: Array = self.A * size / size[:, None]
        return scaled

    def response(
        self, frequencies: npt.ArrayLike, output: str = "position", source: str = "voltage"
    ) -> npt.NDArray[np.complex128]:
        """Return the frequency response from one input to one output.

        Parameters
        ----------
        frequencies
            In Hz, above 0, shape (k,).
        output, source
            Names from ``outputs`` and ``inputs``.

        Returns
        -------
        numpy.ndarray
            Complex gains, shape (k,), in the output's unit per unit of the input.

        Raises
        ------
        ValueError
            For a name that the model does not have, or frequencies that are none.
        """
        matrices = self._channel(output, source)
        return _gains(*matrices, 2j * np.pi * _hertz(frequencies))

    def sampled_response(
        self,
        frequencies: npt.ArrayLike,
        period: float,
        output: str = "position",
        source: str = "voltage",
    ) -> npt.NDArray[np.complex128]:
        """:meth:`response` of samples ``period`` s apart, each input held until the next.

        Raises ValueError for a period that is not above 0, or over an hour, and for a frequency
        above half that of the samples, too: they show it as a lower one.
        """
        step = single_number(period, "period", "seconds")
        if not 0.0 < step <= LONGEST_STEP:
            raise ValueError(
                f"period {shown(period)} s refused: must be above 0, and {LONGEST_STEP} s at most"
            )
        hertz = _hertz(frequencies)
        # Half that of the samples itself is shown, however it is rounded.
        above = hertz[hertz * step > 0.5 * (1.0 + 1e-9)]
        if above.size:
            raise ValueError(
                f"frequencies refused: {shown(float(above[0]))} Hz, samples {shown(step)} s apart "
                f"show up to {0.5 / step:g} Hz; take a shorter period"
            )
        matrices = signal.cont2discrete(self._channel(output, source), step)[:4]
        return _gains(*matrices, np.exp(2j * np.pi * hertz * step))

    def _channel(self, output: str, source: str) -> tuple[Array, Array, Array, Array]:
        """Return the matrices from one input to one output."""
        row, column = [_index(self.outputs, output)], [_index(self.inputs, source)]
        return self.A, self.B[:, column], self.C[row], self.D[row][:, column]

    def to_scipy(self, output: str = "position", source: str = "voltage") -> signal.StateSpace:
        """Return one channel as :class:`scipy.signal.StateSpace`.

        scipy's methods, such as ``step``, take one input and one output.
        """
        return signal.StateSpace(*self._channel(output, source))

    def to_control(self) -> Any:
        """Return the model as ``control.StateSpace`` of python-control, with all names.

        Raises
        ------
        ModuleNotFoundError
            Where python-control is not installed; the text says how to get it.
        """
        try:
            import control  # noqa: PLC0415  an extra
        except ModuleNotFoundError as error:
            raise missing_extra("to_control()", error.name, "control") from error
        return control.ss(
            self.A,
            self.B,
            self.C,
            self.D,
            states=[state.name for state in self.states],
            inputs=[one.name for one in self.inputs],
            outputs=[one.name for one in self.outputs],
            name="rig",
        )

    def __repr__(self) -> str:
        """Show the operating point and the poles."""
        motion = self.point.motion
        poles = ", ".join(f"{pole:.3g}" for pole in self.poles)
        return (
            f"<LinearModel at {motion.position * 1e3:.3f} mm, {motion.velocity * 1e3:.3f} mm/s, "
            f"{self.point.voltage:g} V: poles {poles} rad/s>"
        )


def _gains(
    a: Array, b: Array, c: Array, d: Array, points: npt.NDArray[np.complexfloating[Any, Any]]
) -> npt.NDArray[np.complex128]:
    """Return C (z I − A)⁻¹ B + D at each z of ``points``, for one input and one output."""
    gains = [(c @ np.linalg.solve(z * np.eye(len(a)) - a, b) + d).item() for z in points]
    return np.array(gains, dtype=np.complex128)


def _hertz(frequencies: npt.ArrayLike) -> Array:
    """Return the frequencies as an array; raises ValueError for what are none."""
    several = isinstance(frequencies, Sequence) and not isinstance(
        frequencies, str | bytes | bytearray
    )
    if isinstance(frequencies, np.ndarray):
        several = frequencies.ndim > 0
    single: Any = frequencies if several else [frequencies]
    try:
        numbers = [single_number(one, "frequency", "hertz") for one in single]
    except TypeError as error:
        raise ValueError(f"frequencies refused: {error}") from error
    hertz = np.array(numbers, dtype=np.float64)
    # 1e12 Hz is no frequency of a rig, and far beyond that a response overflows.
    if not ((hertz > 0.0) & (hertz < HIGHEST_FREQUENCY)).all():
        raise ValueError(
            f"frequencies {shown(frequencies)} refused: must be above 0 and below "
            f"{HIGHEST_FREQUENCY:g} Hz"
        )
    return hertz


def _index(known: tuple[Quantity, ...], name: str) -> int:
    names = [quantity.name for quantity in known]
    if not isinstance(name, str) or name not in names:
        raise ValueError(f"{shown(name)} is unknown: must be one of {', '.join(names)}")
    return names.index(name)
