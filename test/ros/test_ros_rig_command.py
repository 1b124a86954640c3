"""`rodless rig`: its options reach the nodes, and Ctrl-C ends both."""

import os
import signal
import sys
from collections.abc import Iterator

import pytest
from node_process import NodeProcess
from observer import Observer

from rodless_lab.domain import own_domain
from rodless_sim import RigParameters
from rodless_sim.sensors import DATA_SHEET

START = "from rodless_lab.main import main; main()"
OPTIONS = "rig --preset calibrated --sensors data-sheet --supply-pressure 600000 --namespace left"

# Both nodes have two seconds to end.
STOP_SECONDS = 4.0


@pytest.fixture
def rig() -> Iterator[tuple[NodeProcess, Observer]]:
    """The running command and an observer in its namespace."""
    with own_domain() as environment:
        observer = Observer(environment, "left")
        command = [sys.executable, "-c", START, *OPTIONS.split()]
        with NodeProcess(command, {**os.environ, **environment}) as process:
            yield process, observer
        observer.close()


def test_options_reach_the_nodes_and_ctrl_c_ends_them(rig: tuple[NodeProcess, Observer]) -> None:
    """Preset, sensors and supply pressure are in force; SIGINT ends all with 0."""
    process, observer = rig
    preset = RigParameters.preset("calibrated")
    expected = {**DATA_SHEET, "supply.pressure": 600000.0}
    expected["friction.form"] = preset["friction.form"]
    assert observer.get("/left/plant", expected) == expected
    assert expected["friction.form"] != RigParameters()["friction.form"]
    process.signal(signal.SIGINT)
    assert process.end(STOP_SECONDS) == 0
