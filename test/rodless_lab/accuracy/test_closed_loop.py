"""Both presets in closed loop, controller and all, against the converged run."""

import numpy as np
import pytest

from rodless_base.parameter_file import preset_names
from rodless_control import PidParameters, references
from rodless_control.references import Reference
from rodless_lab import closed_loop
from rodless_lab.accuracy.judge import CONVERGED, largest_difference
from rodless_sim import RigParameters

STEP = references.step(0.0, 0.058, at=0.5)
SINE = references.sine(0.1, 0.02, 0.381, at=0.2)


@pytest.mark.parametrize("preset", preset_names())
@pytest.mark.parametrize(("reference", "start"), [(STEP, 0.0), (SINE, 0.1)], ids=["step", "sine"])
def test_step_and_sine_in_closed_loop(preset: str, reference: Reference, start: float) -> None:
    """Six seconds at 1 kHz: within 1 µm and 100 Pa, each run with commands of its own."""
    coarse, fine = (
        closed_loop(
            RigParameters.preset(preset).with_values({"time.tolerance": tolerance}),
            PidParameters.preset(preset),
            reference,
            6.0,
            1e-3,
            start,
        )
        for tolerance in (1.0, CONVERGED)
    )
    position, pressure = largest_difference(coarse, fine)
    assert 0.0 < position < 1e-6
    assert pressure < 100.0
    assert np.ptp(fine.position) > 0.03
