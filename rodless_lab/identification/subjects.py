# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What can be identified from a bag, and what is taken as known for it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from matplotlib.figure import Figure

from rodless_base.parameter_file import preset_names, read_parameter_file
from rodless_base.parameters import errors_of_file
from rodless_lab.figures.identification import draw_bristles, draw_friction, draw_pressures
from rodless_lab.identification.bristles.fit import bristle_findings, identify_bristles
from rodless_lab.identification.friction.causes import with_form
from rodless_lab.identification.friction.findings import friction_findings
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.causes import trials, with_cause
from rodless_lab.identification.pressures.chambers import (
    chambers_findings,
    identify_chambers,
)
from rodless_lab.identification.pressures.fit import PressureFit
from rodless_lab.identification.pressures.heat import heat_findings, identify_heat
from rodless_lab.identification.pressures.leaks import identify_leaks, leak_findings
from rodless_lab.identification.pressures.spool import identify_spool, spool_findings
from rodless_lab.identification.pressures.validation import Validation, validated
from rodless_lab.identification.pressures.valve import (
    identify_valve,
    valve_findings,
)
from rodless_lab.identification.verdict import Verdict
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import ParameterError, RigParameters
from rodless_sim.instruments.instruments import sensors_of


@dataclass(frozen=True)
class Identified:
    """What a run says of the parameters, whether the model fits it, and the picture of both.

    ``validate`` predicts a second run, where the subject can.
    """

    findings: list[Finding]
    verdict: Verdict
    draw: Callable[[], Figure]
    validate: Callable[[MeasuredRun], Validation] | None = None


Identify = Callable[[MeasuredRun, RigParameters], Identified]


def _friction(run: MeasuredRun, parameters: RigParameters) -> Identified:
    fit = identify_friction(run, parameters)
    return Identified(
        friction_findings(fit, parameters),
        with_form(fit, run, parameters),
        lambda: draw_friction(fit),
    )


def _bristles(run: MeasuredRun, parameters: RigParameters) -> Identified:
    fit = identify_bristles(run, parameters)
    return Identified(bristle_findings(fit), fit.verdict, lambda: draw_bristles(run, fit))


def _of_pressures(
    identify: Callable[[MeasuredRun, RigParameters], PressureFit],
    findings: Callable[[PressureFit], list[Finding]],
) -> Identify:
    def found(run: MeasuredRun, parameters: RigParameters) -> Identified:
        judged = identify(run, parameters)
        # Cause and validation want the same trials, which take long.
        try_effects = cache(lambda: trials(run, judged.solution))
        fit = with_cause(run, judged, try_effects)
        return Identified(
            findings(fit),
            fit.verdict,
            lambda: draw_pressures(run, fit),
            lambda second: validated(fit.solution, second, try_effects),
        )

    return found


SUBJECTS: dict[str, Identify] = {
    "bristles": _bristles,
    "chambers": _of_pressures(identify_chambers, chambers_findings),
    "friction": _friction,
    "heat": _of_pressures(identify_heat, heat_findings),
    "leak": _of_pressures(identify_leaks, leak_findings),
    "spool": _of_pressures(identify_spool, spool_findings),
    "valve": _of_pressures(identify_valve, valve_findings),
}


# What predicts no second run, and why.
UNVALIDATED = {
    "bristles": "whose fit holds the bias and the start of its own run",
    "friction": "whose fit is of points of uniform motion",
}


def assumed_parameters(base: str, sensors: str, namespace: str = "") -> RigParameters:
    """Return what is taken as known: a preset or file, and how accurate the sensors are.

    Of a file it is what is for the rig in ``namespace``. ``sensors`` is ``data-sheet``, ``base``
    (as ``base`` says) or ``ideal``. Raises :class:`ParameterError` that names the file or the
    value.
    """
    if base in preset_names():
        parameters = RigParameters.preset(base)
    else:
        with errors_of_file(base):
            parameters = RigParameters(_plant_of_file(base, namespace))
    try:
        values = sensors_of(sensors)
    except ValueError as error:
        raise ParameterError(f"sensors: {error}") from error
    return parameters.with_values(values)


def _plant_of_file(base: str, namespace: str) -> dict[str, object]:
    try:
        return read_parameter_file(base, RigParameters.NODE, RigParameters.foreign, namespace)
    except OSError as error:
        raise ValueError(
            f"neither a preset ({', '.join(preset_names())}) nor a file that can be read: "
            f"{error.strerror}"
        ) from error
