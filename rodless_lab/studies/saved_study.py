# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A study as it stands beside its results: whole, whatever becomes of its file and presets."""

import json
from pathlib import Path
from typing import Any

from rodless_base.one_line import described
from rodless_base.parameters import ParameterError
from rodless_control import ControllerParameters
from rodless_control.parameters import LAW
from rodless_lab.simulation.design import Axis, Choice, Dimension, Range
from rodless_lab.studies.base import Base
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.own_file import read_own
from rodless_lab.studies.study import Study
from rodless_lab.studies.version import law_digests, rules_digest
from rodless_sim import RigParameters

FILE = "study.json"

ANOTHER_LAW = (
    "made with another version of the law, whose file has changed since; run the study into "
    "another folder"
)


def study_text(study: Study) -> str:
    """Return all that the results depend on: a change of the equations changes the numbers too."""
    base = study.base
    return json.dumps(
        {
            "sources": rules_digest(),
            "laws": law_digests(base.by_law.values()),
            "name": study.name,
            "rig": dict(base.rig),
            "controller": dict(base.controller),
            "controllers": {law: dict(one) for law, one in base.controllers.items()},
            "run": [base.duration, base.period, base.since],
            "vary": [[one.name, _axis(one.axis), one.factor] for one in study.dimensions],
            "method": study.method,
            "count": study.count,
            "seed": study.seed,
            "traces": [study.trace_columns, study.trace_every],
        },
        indent=1,
    )


def _axis(axis: Axis) -> object:
    if isinstance(axis, Range):
        return {"range": [axis.low, axis.high, axis.count, axis.logarithmic]}
    assert isinstance(axis, Choice)
    return {"choice": axis.values}


def read_saved_study(folder: Path) -> Study:
    """Return the study whose results a folder holds.

    Raises StudyError where there is none, or where another version of the package has made it;
    OSError where it cannot be read.
    """
    file = folder / FILE
    try:
        content = read_own(file)
    except FileNotFoundError as error:
        raise StudyError(f"{folder}: no sweep there; give its folder as --output") from error
    try:
        found = json.loads(content)
        if found["sources"] != rules_digest():
            raise StudyError(
                f"{folder}: made by another version of this package, whose numbers may differ"
            )
        study = _study(found)
        if found["laws"] != law_digests(study.base.by_law.values()):
            raise StudyError(f"{folder}: {ANOTHER_LAW}")
        return study
    except StudyError:
        raise
    except ParameterError as error:
        raise StudyError(f"{folder}: {error}; it is not there here, or {ANOTHER_LAW}") from error
    except (KeyError, TypeError, IndexError, RecursionError, ValueError) as error:
        raise StudyError(
            f"{file}: damaged ({described(error)}); run the study into another folder"
        ) from error


def _study(found: dict[str, Any]) -> Study:
    duration, period, since = found["run"]
    controllers = {law: _controller(one) for law, one in found["controllers"].items()}
    rig, controller = RigParameters(found["rig"]), _controller(found["controller"])
    columns, every = found["traces"]
    return Study(
        found["name"],
        Base(rig, controller, duration, period, since, controllers),
        tuple(_dimension(*one) for one in found["vary"]),
        found["method"],
        found["count"],
        found["seed"],
        tuple(columns),
        every,
    )


def _controller(values: dict[str, Any]) -> ControllerParameters:
    return ControllerParameters.for_law(values[LAW])(values)


def _dimension(name: str, axis: dict[str, Any], factor: bool) -> Dimension:
    if "range" in axis:
        return Dimension(name, Range(*axis["range"]), factor)
    values = [tuple(one) if isinstance(one, list) else one for one in axis["choice"]]
    return Dimension(name, Choice(tuple(values)), factor)
