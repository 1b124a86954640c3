# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The demo: plant and controller over DDS in lock-step, one step, its bag, numbers and picture.

In lock-step the numbers are the same on every machine, however busy it is.
"""

import json
import math
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.atomic_write import atomic_write
from rodless_base.constants import SUPPLY_PRESSURE
from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, PRESSURES, REFERENCE, VALVE_VOLTAGE
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.figures.step import save_step_picture
from rodless_lab.runs.step_metrics import StepMetrics, step_metrics
from rodless_lab.session.errors import HarnessError, InterruptedRunError
from rodless_lab.session.session import RigSession

Array = npt.NDArray[np.float64]

TARGET = 0.058  # m

# Plant time in s: of one sample, at rest before the step, and of the whole run.
PERIOD = 1e-3
LEAD = 0.5
DURATION = 6.0

# What a demo leaves in its folder, and where that is while another one begins.
BAG, METRICS, PICTURE = RESULTS = ("bag", "metrics.json", "step.png")
ASIDE = ".earlier"

# How often the progress is shown, in wall-clock s.
PROGRESS_PERIOD = 0.1

# For the nodes, in wall-clock s: a crowded machine may compile for minutes.
PATIENCE = 300.0


class Progress:
    """Called all the while: shows how far the run is, and ends it when asked to stop."""

    def __init__(self, stop: Stop, show: Callable[[float, float], None]) -> None:
        """``show`` is given the share of the run, from 0 to 1, and the carriage's position (m)."""
        self._stop = stop
        self._show = show
        self._due = 0.0
        self.rig: RigSession | None = None

    def __call__(self) -> None:
        """Raise InterruptedRunError once the user has asked to stop."""
        if self._stop.requested:
            raise InterruptedRunError
        if self.rig is not None and time.monotonic() > self._due:
            self._due = time.monotonic() + PROGRESS_PERIOD
            sample = self.rig.latest
            self._show(min(sample.time / DURATION, 0.999), sample.position)


@contextmanager
def earlier_results(folder: Path) -> Iterator[bool]:
    """Make room for the results in ``folder``; yield whether there are earlier ones.

    What an earlier demo has left goes once there is a new bag; where none comes, it stands as it
    was. Raises HarnessError for anything else at the place of the bag.
    """
    bag, aside = folder / BAG, folder / ASIDE
    _settle(folder)  # after a demo that was killed
    if bag.exists() and (
        not bag.is_dir()
        or any(file.suffix != ".mcap" and file.name != "metadata.yaml" for file in bag.iterdir())
    ):
        raise HarnessError(f"{bag}: not the bag of a demo; choose another --output")
    earlier = any((folder / name).exists() for name in RESULTS)
    if bag.exists() or (folder / PICTURE).exists():  # figures alone may be another verb's
        aside.mkdir(exist_ok=True)
        _move(folder, aside)
    try:
        yield earlier
    finally:
        _settle(folder)


def _settle(folder: Path) -> None:
    """Take the earlier results back where there is no other bag."""
    aside = folder / ASIDE
    if not aside.exists():
        return
    if not (folder / BAG).exists():
        _move(aside, folder)
    shutil.rmtree(aside / BAG, ignore_errors=True)
    for name in (METRICS, PICTURE):
        (aside / name).unlink(missing_ok=True)
    with suppress(OSError):  # somebody else has something there
        aside.rmdir()


def _move(source: Path, to: Path) -> None:
    for name in RESULTS:
        if (source / name).exists():
            (source / name).rename(to / name)


def move(
    preset: str,
    bag: Path,
    stop: Stop,
    on_move: Callable[[float], None],
    show: Callable[[float, float], None],
) -> None:
    """Run the rig from rest at 0 to ``TARGET`` and record it into ``bag``, which is new.

    ``on_move`` is called with the set-point (m) when it is sent; for ``show`` see
    :class:`Progress`. Raises InterruptedRunError where ``stop`` is requested, HarnessError where a
    node fails, and BagError where the bag cannot be written.
    """
    progress = Progress(stop, show)
    with RigSession(
        "lockstep",
        preset=preset,
        plant={"supply.pressure": SUPPLY_PRESSURE, "time.period": PERIOD},
        duration=DURATION,
        paused=True,
        timeout=PATIENCE,
        check=progress,
        bag=bag,
        bag_topics=[REFERENCE],
    ) as rig:
        progress.rig = rig
        # Step by step, so that the set-point always comes at the same sample.
        rig.step(round(LEAD / PERIOD))
        on_move(TARGET)
        rig.setpoint(TARGET)
        rig.resume()
        run = rig.run()
        show(1.0, float(run.position[-1]))


@dataclass(frozen=True)
class Outcome:
    """What the bag says of the run."""

    metrics: StepMetrics
    supply_pressure: float  # Pa, absolute


def measure(bag: Bag) -> Outcome:
    """Measure the move from what the topics carried."""
    joint = bag[f"/{JOINT_STATES}"]
    metrics = step_metrics(
        joint.stamp,
        joint.fields["position"][:, 0],
        bag[f"/{VALVE_VOLTAGE}"].fields["data"],
        start=0.0,
        target=TARGET,
        at=step_time(bag),
    )
    _, supply = pressure(bag, "supply_pressure")
    return Outcome(metrics, float(supply[-1]))


def pressure(bag: Bag, field: str) -> tuple[Array, Array]:
    """Return stamps (s) and values (Pa, absolute) of a field of ``Measurement``."""
    messages = bag[f"/{PRESSURES[field]}"]
    return messages.stamp, messages.fields["fluid_pressure"]


def step_time(bag: Bag) -> float:
    """Return the stamp (s) of the first sample that the controller answered with the new target.

    That is when the step begins for the controller; the message with the set-point was sent
    before. The controller publishes one reference per sample, from sample 0 on. A sample that was
    not answered for a while is in the bag as often as it was offered, with one answer or as many.
    Raises RuntimeError where the target or a reference before it is missing.
    """
    stamps, reference = bag[f"/{JOINT_STATES}"].stamp, bag[f"/{REFERENCE}"]
    if len(stamps) != len(reference):
        stamps = np.unique(stamps)
    (answered,) = np.nonzero(reference.fields["data"] == TARGET)
    if not len(answered):
        raise RuntimeError("the controller has not taken the set-point")
    first = int(answered[0])
    # The plant may have begun its next sample before the reference of this one was sent.
    if not (
        first < len(stamps) and 0 <= round((reference.time[first] - stamps[first]) / PERIOD) <= 1
    ):
        raise RuntimeError(f"{REFERENCE} is incomplete: it cannot be told when the step began")
    return float(stamps[first])


def write_results(preset: str, path: Path, folder: Path) -> Outcome:
    """Measure the bag at ``path``; write metrics.json and step.png into ``folder``."""
    bag = read_bag(path)
    outcome = measure(bag)
    values = {
        **vars(outcome.metrics),
        "supply_pressure": outcome.supply_pressure,
        "preset": preset,
    }
    # JSON has no NaN: what there is not is null.
    numbers = {
        name: None if isinstance(value, float) and math.isnan(value) else value
        for name, value in values.items()
    }
    atomic_write(folder / METRICS, json.dumps(numbers, indent=2) + "\n")
    draw(preset, bag, folder / PICTURE)
    return outcome


def draw(preset: str, bag: Bag, path: Path) -> None:
    """Draw position, pressures and voltage of the run."""
    joint, command = (bag[f"/{topic}"] for topic in (JOINT_STATES, VALVE_VOLTAGE))
    at = step_time(bag)
    save_step_picture(
        path,
        f"0 to {TARGET * 1e3:g} mm over ROS topics, preset {preset}",
        position=(joint.stamp, joint.fields["position"][:, 0]),
        reference=([joint.stamp[0], at, at, joint.stamp[-1]], [0.0, 0.0, TARGET, TARGET]),
        pressures={
            "chamber A": pressure(bag, "pressure_a"),
            "chamber B": pressure(bag, "pressure_b"),
        },
        voltage=(command.time, command.fields["data"]),
    )
