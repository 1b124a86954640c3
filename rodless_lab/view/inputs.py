# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What comes from a page, checked before anything is done with it."""

import math
import re
from collections.abc import Mapping
from contextlib import suppress

from rodless_base.one_line import shown
from rodless_lab.session.travel import BY_THEMSELVES, outside_travel
from rodless_lab.view.errors import ViewError

# As many periods as one request may step.
MOST_STEPS = 1000

_BAG_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")


def finite(value: object, what: str) -> float:
    """Return a number; raises :class:`ViewError` for what is none, or is not finite."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ViewError(f"{what}: {shown(value)} refused, must be a number")
    try:
        number = float(value)
    except (ValueError, OverflowError) as error:
        raise ViewError(f"{what}: {shown(value)} refused, must be a number") from error
    if not math.isfinite(number):
        raise ViewError(f"{what}: {shown(value)} refused, must be finite")
    return number


def set_point(value: object, parameters: Mapping[str, object]) -> float:
    """Return a set-point (m) that a controller with these ``parameters`` takes.

    Raises :class:`ViewError`. A controller without such parameters judges for itself.
    """
    target = finite(value, "set-point")
    kind = parameters.get("reference.type")
    if kind in BY_THEMSELVES:
        raise ViewError(f"reference.type is {kind}, which takes no set-points; choose setpoint")
    if refusal := outside_travel(target, parameters):
        raise ViewError(refusal)
    return target


def steps(value: object) -> int:
    """Return a number of periods; raises :class:`ViewError`."""
    number = finite(value, "steps")
    if number != int(number) or not 1 <= number <= MOST_STEPS:
        raise ViewError(f"steps: {shown(value)} refused, must be from 1 to {MOST_STEPS}")
    return int(number)


def bag_name(value: object) -> str:
    """Return the name of a bag in the view's folder; raises :class:`ViewError` for a path."""
    if not isinstance(value, str) or not _BAG_NAME.fullmatch(value):
        raise ViewError(
            f"{shown(value)} refused, must be a name: letters, digits, _, - and ., no folder"
        )
    return value


def parameter_text(value: object) -> str:
    """Return what a page gives for a parameter as `rodless set` takes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float | str):
        with suppress(ValueError):  # Python writes no whole number of more than 4300 digits
            return str(value)
    raise ViewError(f"{shown(value)} refused, must be a number or a text")
