# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The voltages that show what is to be identified, also where the valve is closed elsewhere."""

import numpy as np
import pytest
from quiet_stop import Quiet

from rodless_lab.cli import drive
from rodless_lab.identification.coverage import measured_run
from rodless_lab.identification.excitation import EXCITATIONS, PERIOD, excitation
from rodless_lab.identification.friction.fit import FrictionFit
from rodless_lab.identification.friction.run import identify_friction
from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET


@pytest.mark.parametrize("subject", EXCITATIONS)
def test_a_valve_that_is_closed_elsewhere_moves_the_carriage_alike(subject: str) -> None:
    """Its areas follow the distance from where it is closed: within 1 µm and 10 Pa all along."""
    paths = []
    for closed in (5.08, 5.18):
        rig = RigParameters({"valve.closed_voltage": closed})
        paths.append(simulate(rig, excitation(subject, closed), PERIOD, position=0.06))
    one, other = paths
    assert np.ptp(one.pressure_a) > 1e4
    assert other.position == pytest.approx(one.position, abs=1e-6)
    assert other.pressure_a == pytest.approx(one.pressure_a, abs=10.0)


def test_a_voltage_at_which_no_valve_is_closed_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One line with the range, exit code 2, and nothing is sent."""
    assert drive.main(["spool", "--closed-voltage", "7"], Quiet()) == 2
    assert capsys.readouterr() == (
        "",
        "valve.closed_voltage: 7.0 refused, must be from 4 to 6 (V)\n",
    )


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["friction", "--creep", "0.5"], "--creep: 0.5 refused, must be from 0.2 to 0.4 (V)\n"),
        (["friction", "--creep", "nan"], "--creep: nan refused, must be from 0.2 to 0.4 (V)\n"),
        (["heat", "--creep", "0.3"], "--creep: refused, heat does not creep, only friction does\n"),
    ],
)
def test_a_creep_that_no_run_has_is_refused(
    options: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line that says why, exit code 2, and nothing is sent."""
    assert drive.main(options, Quiet()) == 2
    assert capsys.readouterr() == ("", said)


def test_the_usual_creep_gives_the_usual_voltages() -> None:
    """A run is what it was where nobody says how far to creep, or says 0.25 V."""
    usual = excitation("friction")
    assert usual == pytest.approx(excitation("friction", creep=0.25), abs=1e-12)
    assert usual[: round(8.0 / PERIOD)].max() == pytest.approx(5.33)


@pytest.mark.slow
def test_friction_behind_hysteresis_is_told_from_a_longer_creep() -> None:
    """The preset `calibrated`, its valve 20 mV late either way: each value is told, and covered.

    With the usual creep the carriage stands through it in reverse: then nothing is told there, and
    no verdict is against a form that is the rig's own.
    """
    rig = RigParameters.preset("calibrated").with_values(DATA_SHEET)

    def fit(creep: float) -> FrictionFit:
        voltages = excitation("friction", creep=creep)
        return identify_friction(measured_run(rig, voltages, np.random.default_rng(1)), rig)

    longer, usual = fit(0.29), fit(0.25)
    assert longer.verdict.fits
    for side in ("forward", "reverse"):
        for name in ("static", "coulomb", "stribeck_velocity", "viscous"):
            found = getattr(getattr(longer, side), name)
            assert found.informed
            assert found.covers(rig.number(f"friction.{side}.{name}"))
    assert usual.verdict.fits
    assert not usual.reverse.static.informed
