"""The air: properties every flow and chamber equation shares."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel


class Air(NamedTuple):
    """Ideal gas (paper, section 3): J/(kg·K), -, -, Pa·s, K.

    ``choked_function`` is :func:`choked_nozzle_function` of the isentropic index.
    """

    gas_constant: float
    isentropic_index: float
    critical_ratio: float
    viscosity: float
    temperature: float
    choked_function: float


@kernel
def choked_nozzle_function(isentropic_index: float) -> float:
    """Dimensionless flow of an ideal nozzle when choked, eq. (6): 0.6847 for air."""
    k = isentropic_index
    return math.sqrt(2.0 * k / (k + 1.0) * (2.0 / (k + 1.0)) ** (2.0 / (k - 1.0)))
