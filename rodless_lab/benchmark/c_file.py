# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig in C, ``benchmarks/rig.c``: compiled with the machine's compiler and called as it is."""

import ctypes
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import in_one_line
from rodless_control.laws.pid import Command, Gains
from rodless_sim import RigParameters
from rodless_sim.physics import forces
from rodless_sim.physics.faults import simulation_error
from rodless_sim.physics.flow_law import LAWS
from rodless_sim.physics.flow_laws import nozzle
from rodless_sim.physics.friction import FORMS
from rodless_sim.physics.friction_forms import saturating
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, Motion
from rodless_sim.physics.valve_assemblies import reconciled
from rodless_sim.physics.valve_assembly import ASSEMBLIES
from rodless_sim.trace import COLUMNS

Array = npt.NDArray[np.float64]

# Rounding as the package's: no fused multiplications. With them, -march=native, the file is no
# quicker; -ffast-math would gain 5 %, and give other numbers on other machines.
FLAGS = ("-std=gnu11", "-O3", "-ffp-contract=off")


class NoCompilerError(RuntimeError):
    """There is no C compiler, or it refuses the file."""


def source() -> Path:
    """Return ``benchmarks/rig.c`` of the source tree, or its copy in the installed package."""
    installed = Path(__file__).parent / "c" / "rig.c"
    return installed if installed.is_file() else Path(__file__).parents[2] / "benchmarks" / "rig.c"


def compiler() -> list[str]:
    """Return the command of the C compiler: ``CC``, or else ``cc``; raises NoCompilerError."""
    given = os.environ.get("CC", "").strip() or "cc"
    try:
        command = shlex.split(given)
    except ValueError as error:
        raise NoCompilerError(f"CC={given}: {error}; set CC to a command") from error
    if shutil.which(command[0]) is None:
        raise NoCompilerError(f"no C compiler {command[0]!r}: install gcc or set CC")
    return command


def _numbers(*names: str) -> list[tuple[str, Any]]:
    return [(name, ctypes.c_double) for name in names]


class _Direction(ctypes.Structure):
    _fields_ = _numbers("static_force", "coulomb", "stribeck_velocity", "viscous")


class _Plant(ctypes.Structure):
    _fields_ = [
        *_numbers("gas_constant", "isentropic_index", "critical_ratio", "viscosity"),
        *_numbers("temperature", "choked_function", "closed_voltage", "curve_centre"),
        ("area_coefficients", ctypes.c_double * 9),
        ("flow_coefficients", ctypes.c_double * 6),
        *_numbers("spool_diameter", "gap_length", "gap_height", "gap_fade_voltage"),
        *_numbers("piston_area", "stroke", "moving_mass", "dead_volume_a", "dead_volume_b"),
        *_numbers("saturating", "high_speed_viscous", "saturation_velocity"),
        ("forward", _Direction),
        ("reverse", _Direction),
        *_numbers("capture_velocity", "restitution", "supply_pressure", "ambient_pressure"),
    ]


class _Gains(ctypes.Structure):
    _fields_ = _numbers(*(name for name in Gains._fields if name != "options"))


class _Motion(ctypes.Structure):
    _fields_ = _numbers(*Motion._fields)


def _plant(plant: Plant) -> _Plant:
    """Return the constants as C has them; raises ValueError for a rig that it does not know."""
    if ASSEMBLIES[plant.assembly.code] is not reconciled or plant.cylinder.locked:
        raise ValueError("the C file knows the reconciled valve and a free carriage only")
    # Nor what the paper leaves out.
    beyond = (
        LAWS[plant.flow_law.code] is not nozzle
        or plant.leak.open
        or plant.heat
        or plant.drive
        or plant.full
        or plant.tubes
        or plant.ripple
        or plant.air.chamber_index != plant.air.isentropic_index
        or plant.forces != forces.of(RigParameters())
    )
    if beyond:
        raise ValueError(
            "the C file knows no flow law, leak, tilt, exponent, heat, drive, bristles, magnets, "
            "drift, tubes or unsteady supply beyond the paper"
        )
    known = {
        **plant.air._asdict(),
        **plant.valve._asdict(),
        **plant.assembly.own[ASSEMBLIES.index(reconciled)]._asdict(),
        **plant.cylinder._asdict(),
        **plant.friction.own[FORMS.index(saturating)]._asdict(),
        **plant.end_stop._asdict(),
        **plant._asdict(),
        "saturating": FORMS[plant.friction.form] is saturating,
        "forward": _Direction(*plant.friction.forward),
        "reverse": _Direction(*plant.friction.reverse),
        "capture_velocity": plant.friction.capture_velocity,
    }
    found = _Plant()
    for name, kind in (one[:2] for one in _Plant._fields_):
        value = known[name]
        setattr(found, name, kind(*value) if isinstance(value, tuple) else value)
    return found


def _gains(gains: Gains) -> _Gains:
    """Return the PID's constants as C has them; raises ValueError for options it does not know."""
    known = gains._asdict()
    options = known.pop("options")
    if (
        options.fading_memory
        or options.gain_boost
        or options.acceleration_feedforward
        or options.parking.error
    ):
        raise ValueError("the C file knows none of the options of the PID")
    return _Gains(**known)


def _address(values: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(values.ctypes.data)


class CFile:
    """The compiled file; its runs are shaped as those of the package's compiled loops.

    Raises
    ------
    NoCompilerError
        Where there is no compiler, or it refuses the file.
    """

    def __init__(self) -> None:
        """Compile."""
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder) / "rig.so"
            command = [
                *compiler(),
                *FLAGS,
                "-shared",
                "-fPIC",
                "-o",
                str(library),
                str(source()),
                "-lm",
            ]
            try:
                run = subprocess.run(command, capture_output=True, text=True, check=False)
            except OSError as error:  # a file that may be run, and is no program
                raise NoCompilerError(f"{command[0]} does not run: {error.strerror}") from error
            if run.returncode != 0:
                cause = in_one_line(run.stderr)
                raise NoCompilerError(f"the C compiler refuses {source().name}: {cause}")
            self._library = ctypes.CDLL(str(library))

    def closed_loop(
        self,
        plant: Plant,
        gains: Gains,
        references: Array,
        state: AnyMotion,
        period: float,
        tolerance: float,
    ) -> tuple[Array, Array]:
        """Follow ``references``, shape (n, 2): rows and commands, a row of each per sample.

        Raises SimulationError.
        """
        count = len(references)
        rows, commands = np.empty((count, len(COLUMNS))), np.empty((count, len(Command._fields)))
        fault = self._library.closed_loop(
            ctypes.byref(_plant(plant)),
            ctypes.byref(_gains(gains)),
            _address(references),
            ctypes.c_long(count),
            _Motion(*state),
            ctypes.c_double(period),
            ctypes.c_double(tolerance),
            _address(rows),
            _address(commands),
        )
        if fault:
            raise simulation_error(fault, 0.0, state)
        return rows, commands

    def open_loop(
        self, plant: Plant, voltages: Array, state: AnyMotion, period: float, tolerance: float
    ) -> Array:
        """Apply ``voltages``, shape (n,): n + 1 rows. Raises SimulationError."""
        rows = np.empty((len(voltages) + 1, len(COLUMNS)))
        fault = self._library.open_loop(
            ctypes.byref(_plant(plant)),
            _address(voltages),
            ctypes.c_long(len(voltages)),
            _Motion(*state),
            ctypes.c_double(period),
            ctypes.c_double(tolerance),
            _address(rows),
        )
        if fault:
            raise simulation_error(fault, 0.0, state)
        return rows
