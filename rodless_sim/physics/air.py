# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The air: properties every flow and chamber equation shares, and where it comes from and goes."""

import math
from collections.abc import Collection
from typing import NamedTuple

from rodless_base.constants import STANDARD_ATMOSPHERE, SUPPLY_PRESSURE
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import PAPER

PARAMETERS = declare(
    Parameter(
        "supply.pressure",
        SUPPLY_PRESSURE,
        "Pa",
        "supply pressure P_s, absolute",
        f"{PAPER}, 6.2 (gauge reading assumed)",
        5e4,
        1.2e6,
    ),
    Parameter(
        "supply.temperature",
        297.0,
        "K",
        "supply temperature T_s; the air keeps it everywhere, unless chambers.thermodynamics "
        "gives the chambers temperatures of their own",
        f"{PAPER}, 3.5",
        200.0,
        400.0,
    ),
    Parameter(
        "atmosphere.pressure",
        STANDARD_ATMOSPHERE,
        "Pa",
        "ambient pressure P_e, absolute",
        "standard atmosphere",
        5e4,
        1.2e5,
    ),
    Parameter(
        "atmosphere.temperature",
        293.15,
        "K",
        "ambient temperature: of air that comes from the atmosphere, and at which free-air flow is "
        "stated",
        "ISO 8778 reference atmosphere",
        200.0,
        400.0,
    ),
    Parameter(
        "air.gas_constant",
        287.05,
        "J/(kg·K)",
        "specific gas constant R",
        f"{PAPER}, 3.2, corrected",
        100.0,
        5000.0,
    ),
    Parameter("air.isentropic_index", 1.4, "", "isentropic index κ", f"{PAPER}, 3.2", 1.05, 1.7),
    Parameter(
        "air.critical_ratio",
        0.528,
        "",
        "critical pressure ratio b; must belong to the isentropic index, and follows from it where "
        "it is not given",
        f"{PAPER}, 3.2",
        0.4,
        0.65,
    ),
    Parameter(
        "chambers.thermodynamics",
        "adiabatic",
        "",
        "what becomes of the air in the chambers: adiabatic: eq. (26), all air has the supply's "
        "temperature; polytropic: so too, with chambers.polytropic_index for the isentropic index; "
        "energy_balance: each chamber has a temperature of its own and exchanges heat with its "
        "wall",
        f"{PAPER}, eq. (26); docs/options",
        choices=("adiabatic", "polytropic", "energy_balance"),
        fixed=True,
    ),
    Parameter(
        "chambers.polytropic_index",
        1.2,
        "",
        "exponent n of the chambers' air, from 1 (isothermal) to the isentropic index (polytropic)",
        "Richer and Hurmuzlu 2000: 1.2 for compression and expansion, 1 to 1.4 for flows",
        1.0,
        1.7,
    ),
    Parameter("air.viscosity", 1.83e-5, "Pa·s", "dynamic viscosity μ", f"{PAPER}, 3.3", 1e-6, 1e-4),
)


class Air(NamedTuple):
    """Ideal gas (paper, section 3)."""

    gas_constant: float  # J/(kg·K)
    isentropic_index: float  # -
    critical_ratio: float  # -
    viscosity: float  # Pa·s
    temperature: float  # K
    choked_function: float  # -, choked_nozzle_function of the isentropic index
    chamber_index: float  # -, exponent of the chambers' air

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Air":
        """Return the constants for ``parameters``."""
        index = parameters.number("air.isentropic_index")
        return cls(
            gas_constant=parameters.number("air.gas_constant"),
            isentropic_index=index,
            critical_ratio=parameters.number("air.critical_ratio"),
            viscosity=parameters.number("air.viscosity"),
            temperature=parameters.number("supply.temperature"),
            choked_function=choked_nozzle_function(index),
            chamber_index=chamber_index(parameters),
        )


def chamber_index(parameters: ParameterSet) -> float:
    """Exponent n of the air in the chambers: κ where it exchanges no heat."""
    if parameters.text("chambers.thermodynamics") == "polytropic":
        return parameters.number("chambers.polytropic_index")
    return parameters.number("air.isentropic_index")


# How far the critical ratio may be from that of the isentropic index: the paper rounds.
ROUNDING = 1e-3


def critical_ratio(isentropic_index: float) -> float:
    """Critical pressure ratio of an ideal nozzle (ISO 6358 calls it b): 0.5283 for air."""
    k = isentropic_index
    return float((2.0 / (k + 1.0)) ** (k / (k - 1.0)))


def derived(parameters: ParameterSet, changed: Collection[str]) -> dict[str, float]:
    """Return the critical ratio where only the index has changed, and no longer fits the ratio."""
    if "air.isentropic_index" not in changed or "air.critical_ratio" in changed:
        return {}
    theory = critical_ratio(parameters.number("air.isentropic_index"))
    if abs(parameters.number("air.critical_ratio") - theory) <= ROUNDING:
        return {}
    return {"air.critical_ratio": theory}


def check(parameters: ParameterSet) -> None:
    """Refuse a supply below the atmosphere, and indices that are not the gas's."""
    supply, ambient = parameters.number("supply.pressure"), parameters.number("atmosphere.pressure")
    if supply < ambient:
        raise ParameterError(
            f"supply.pressure: {supply:g} Pa refused, it is absolute and must not be below "
            f"atmosphere.pressure ({ambient:g} Pa)"
        )
    index = parameters.number("air.isentropic_index")
    if chamber_index(parameters) > index:
        raise ParameterError(
            f"chambers.polytropic_index: {chamber_index(parameters):g} refused, above "
            f"air.isentropic_index ({index:g}): air that is compressed would take up heat"
        )
    ratio = parameters.number("air.critical_ratio")
    theory = critical_ratio(index)
    if abs(ratio - theory) > ROUNDING:
        raise ParameterError(
            f"air.critical_ratio: {ratio:g} refused, air.isentropic_index {index:g} "
            f"needs {theory:.4f} within 0.001 or the flow jumps where it chokes"
        )


@kernel
def choked_nozzle_function(isentropic_index: float) -> float:
    """Dimensionless flow of an ideal nozzle when choked, eq. (6): 0.6847 for air."""
    k = isentropic_index
    return math.sqrt(2.0 * k / (k + 1.0) * (2.0 / (k + 1.0)) ** (2.0 / (k - 1.0)))
