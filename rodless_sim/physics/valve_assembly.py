# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How the valve's equations are put together: from voltage to openings, from openings to flow.

An assembly is one module of ``valve_assemblies`` with ``NAME``, ``MEANING``, its own
``PARAMETERS``, its constants ``of(parameters)``, and two kernels: the openings ``lands(constants,
air, valve, voltage)``, and the :class:`~rodless_sim.physics.flow.Flow` past each edge beside that
of its orifice, ``gap(constants, air, edge, pressure_1, pressure_2)``. Where it has
``check(parameters)``, that raises ParameterError for values that contradict each other, whichever
assembly is in use.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from rodless_base.kernels import dispatch
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_base.sockets import check_kernel, choices
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.valve import Valve

ASSEMBLIES = choices(
    "rodless_sim.physics.valve_assemblies",
    (
        "reconciled",
        "printed",
    ),
    kernels=("lands", "gap"),
)

PARAMETERS = collect(
    declare(
        Parameter(
            "valve.assembly",
            "reconciled",
            "",
            "how the valve equations are put together: "
            + ", or ".join(assembly.MEANING for assembly in ASSEMBLIES),
            "docs/errata.md",
            choices=tuple(assembly.NAME for assembly in ASSEMBLIES),
        )
    ),
    *(assembly.PARAMETERS for assembly in ASSEMBLIES),
)


class Assembly(NamedTuple):
    """The assembly in use."""

    code: int  # its place in ASSEMBLIES
    own: tuple[Any, ...]  # each assembly's own constants

    @classmethod
    def of(cls, parameters: ParameterSet, air: Air, valve: Valve) -> "Assembly":
        """Return the constants for ``parameters``."""
        own = tuple(assembly.of(parameters) for assembly in ASSEMBLIES)
        edge = Edge(1e-6, 0.0)
        for assembly, constants in zip(ASSEMBLIES, own, strict=True):
            check_kernel(assembly, "lands", Lands(True, edge, edge), constants, air, valve, 6.0)
            check_kernel(assembly, "gap", Flow(0.0, 0.0, 0.0), constants, air, edge, 6e5, 1e5)
        return cls(code=parameters.choice("valve.assembly"), own=own)


lands: Callable[..., Lands] = dispatch([assembly.lands for assembly in ASSEMBLIES])
gap: Callable[..., Flow] = dispatch([assembly.gap for assembly in ASSEMBLIES])
