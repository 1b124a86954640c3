"""A lock-step plant that is stopped for seconds is missed, and its run stays the same."""

import numpy as np
from running import StartSession

STEP = {"reference.type": "step", "reference.at": 0.02, "reference.target": 0.02}


def test_a_lock_step_plant_that_is_stopped_changes_no_number(rig_session: StartSession) -> None:
    """The loss is said and counted; a command that nobody has asked for would shift the loop."""
    runs = []
    for frozen in (False, True):
        rig = rig_session("lockstep", controller=STEP, duration=0.2, paused=True)
        if frozen:
            rig.freeze("plant")
            rig.wait_until(lambda rig=rig: rig.counter("controller", "positions lost") == 1, "loss")
            text = "no position: plant stands still"
            assert rig.diagnostics("controller")["message"] == text
            rig.thaw("plant")
        rig.resume()
        runs.append(rig.run())
        if frozen:
            rig.wait_until(
                lambda rig=rig: (
                    rig.diagnostics("controller")["message"] == "in the last 10 s: positions lost"
                ),
                "the plant to be followed",
            )
    for name in ("time", "position", "pressure_a", "voltage"):
        before, after = (getattr(run, name) for run in runs)
        assert np.array_equal(before, after, equal_nan=True), name
    assert len(runs[0]) == 201
    assert np.ptp(runs[0].position) > 1e-3
