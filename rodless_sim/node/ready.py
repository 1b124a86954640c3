# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whom the plant waits for, and what it says once it is ready."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Protocol

from rodless_base.parameter_file import preset_names
from rodless_sim.parameters import RigParameters


class Polled(Protocol):
    """A publisher whose subscribers are counted when it is polled."""

    def poll(self) -> int:
        """Count the subscribers."""


def all_listen(samples: Callable[[], int], others: Sequence[Polled], recorders: int) -> bool:
    """Poll ``others``; return whether ``recorders`` hear everything, and one more the samples.

    ``samples`` counts the subscribers of the samples.
    """
    # First: subscriptions that match between two counts must not hide behind an older one.
    listeners = samples()
    fewest = min([publisher.poll() for publisher in others])
    return listeners > recorders and fewest >= recorders


def preset_text(values: RigParameters) -> str:
    """Name the preset that ``values`` are nearest to and what differs from it.

    Time is left out, and so are faults, which have a report of their own. Instruments, which are
    chosen by themselves, do not tell which it is.
    """
    differing = {name: _differing(values, _preset(name)) for name in preset_names()}
    name = min(differing, key=lambda one: sum(not n.startswith("sensors.") for n in differing[one]))
    changed = differing[name]
    if not changed:
        return name
    more = f" and {len(changed) - 2} more" if len(changed) > 2 else ""
    return f"{name} (changed: {', '.join(changed[:2])}{more})"


@cache
def _preset(name: str) -> RigParameters:
    return RigParameters.preset(name)


def _differing(values: RigParameters, preset: RigParameters) -> list[str]:
    own = ("time.", "fault.")
    return [n for n in values if not n.startswith(own) and values[n] != preset[n]]


def ready_line(values: RigParameters, samples: str, commands: str) -> str:
    """Return the line for a plant on the topics ``samples`` and ``commands`` (full names)."""
    gauge = values.number("supply.pressure") - values.number("atmosphere.pressure")
    return (
        f"ready: {_mode(values)}, supply {gauge * 1e-6:.3f} MPa gauge, "
        f"preset {preset_text(values)}; "
        f"waiting for {_wanted(values, samples)} {commands}"
    )


def _mode(values: RigParameters) -> str:
    rate, speed = 1.0 / values.number("time.period"), values.number("time.speed")
    if values.in_lockstep:
        return f"lockstep, {rate:g} samples per second of plant time"
    return f"realtime, {rate:g} Hz" + (f" at speed {speed:g}" if speed != 1.0 else "")


def _wanted(values: RigParameters, samples: str) -> str:
    recorders = int(values.number("time.recorders"))
    lockstep = values.in_lockstep
    commands = "one publisher on" if lockstep else "commands on"
    if not lockstep and not recorders:
        return commands
    subscribers = f"{recorders + 1} subscribers" if recorders else "a subscriber"
    return f"{subscribers} to {samples} and {commands}"
