# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A scenario as it happens to one rig: what has been changed, and what is due."""

from collections.abc import Iterator
from contextlib import suppress

from rodless_base.parameters import ParameterError
from rodless_sim.cylinder_series import GIVEN, MODEL, OTHER, values_of
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.scenario import Entry, Scenario, ScenarioStateError


class ScenarioPlayer:
    """Hands out the entries of a scenario when they are due."""

    def __init__(self, scenario: Scenario, parameters: RigParameters) -> None:
        """Begin with these parameters; raises ScenarioError where their rig refuses an entry."""
        # By name in the entries, and what follows from those.
        changed = {name for entry in scenario.entries for name in entry.changes}
        for stage in scenario.stages(parameters):
            changed.update(stage.differences(parameters))
        model = parameters.text(MODEL)
        if MODEL in changed:
            changed.update(GIVEN)
        self._before = {name: parameters[name] for name in changed}
        # What a model that a user has named meanwhile takes with it as this one comes back.
        self._of_model = (
            {} if model == OTHER else {one: parameters[one] for one in values_of(model)}
        )
        self._scenario = scenario
        self._at_start = [entry for entry in scenario.entries if entry.stamp == 0]
        self.restart()

    @property
    def played(self) -> tuple[Entry, ...]:
        """The entries that have taken effect since the start."""
        return self._scenario.entries[: self._count]

    def at_start(self, parameters: RigParameters) -> RigParameters:
        """Return ``parameters`` as before the scenario, with what is due at 0."""
        # With all named, nothing follows from a model that comes back: the rest stays as it is.
        named_anew = parameters[MODEL] not in (OTHER, self._before.get(MODEL, parameters[MODEL]))
        others = self._of_model if named_anew else {}
        parameters = parameters.with_values({**parameters, **others, **self._before})
        for entry in self._at_start:
            parameters = parameters.with_values(entry.changes)
        return parameters

    def ahead(self, parameters: RigParameters) -> Iterator[RigParameters]:
        """Yield what ``parameters`` become with each entry, from now on and after a new start."""
        # What a rig refuses is said when it comes.
        with suppress(ParameterError):
            yield from self._scenario.stages(parameters)
        with suppress(ParameterError):
            start = self.at_start(parameters)
            yield start
            yield from self._scenario.stages(start)

    def restart(self) -> None:
        """Take what is due at 0 for played, and nothing else."""
        self._count = len(self._at_start)

    def due(self, nanoseconds: int) -> Iterator[Entry]:
        """Yield each entry that is due by now (ns) and has not been played; then it has."""
        entries = self._scenario.entries
        while self._count < len(entries) and entries[self._count].stamp <= nanoseconds:
            yield entries[self._count]
            self._count += 1

    def refusal(self, error: ParameterError | SimulationError) -> ScenarioStateError:
        """Return what to raise where the rig's state does not allow the entry that is due."""
        return ScenarioStateError(f"{self._scenario.name}: entry {self._count + 1}: {error}")
