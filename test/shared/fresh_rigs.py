# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs of a study that no search has seen: for what is claimed of gains."""

from dataclasses import replace

import pytest
from extent import draws

from rodless_control import PidParameters
from rodless_control.controller import Law
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.studies.study import Study
from rodless_sim import RigParameters

RIGS = 100
SEEDS = (20261122, 77)[: draws(2, 1)]

fresh = pytest.mark.parametrize("seed", SEEDS)


def fresh_rigs(study: Study, seed: int) -> list[RigParameters]:
    """A hundred rigs, drawn as the study draws but by another seed."""
    assert seed not in {study.seed, study.seed + 1}
    rows = replace(study, seed=seed, count=RIGS)
    return [rows.row(number).base.rig for number in range(RIGS)]


def controlled(
    study: Study, seed: int, law: Law | PidParameters, duration: float | None = None
) -> Ensemble:
    """A study's runs on fresh rigs, by default as long as the study has them; none fails."""
    base = study.base
    rigs, seconds = fresh_rigs(study, seed), base.duration if duration is None else duration
    found = ensemble(rigs, law, base.reference, seconds, base.period, since=base.since)
    assert not found.failures
    return found
