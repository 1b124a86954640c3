# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a running plant does about equations that it has not had before: they compile elsewhere."""

import json
import subprocess
import sys
from collections.abc import Callable, Mapping

from rodless_base.kernels import keeps
from rodless_base.one_line import in_one_line
from rodless_base.parameters import ParameterError
from rodless_base.ros.parameters import NOT_YET
from rodless_sim import precompile
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.motion import advance_at_voltage
from rodless_sim.physics.plant import Plant
from rodless_sim.rig import Rig, kinds_of


class Equations:
    """Sees to it that a change of parameters does not wait for the compiler.

    Compiling takes up to a minute, in which a plant would stand still. So it refuses the change,
    has another process compile, and takes it when that is done.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        """Nothing runs yet; ``say`` is told what becomes of it."""
        self._say = say
        self._process: subprocess.Popen[str] | None = None
        # Of what the process compiles: names, and the kind of plant.
        self._names = ""
        self._kinds: tuple[bool, ...] = ()
        # Kinds that were compiled there: what is not found then is compiled in place.
        self._tried: set[tuple[bool, ...]] = set()

    def require(self, rig: Rig, changes: Mapping[str, object]) -> None:
        """Raise ParameterError where ``rig`` would have to compile for these ``changes``.

        It has to where nothing is kept of what another process compiles.
        """
        values = rig.parameters.with_values(changes)
        kinds = kinds_of(Plant.of(values))
        under_way = self._process is not None and kinds == self._kinds
        if not under_way and (
            kinds in self._tried or rig.has_equations_for(values) or not keeps(advance_at_voltage)
        ):
            return
        names = ", ".join(changes)
        if self._process is None:
            try:
                self._process = _compiling(rig.parameters, values)
            except OSError as error:
                self._say(f"{names}: compiled here, and the plant waits for it: {error}")
                return
            self._names, self._kinds = names, kinds
        raise ParameterError(
            f"{names}: {NOT_YET}, the plant's equations for {self._names} are being compiled, "
            "which takes about a minute, once on a machine; set it again then"
        )

    def poll(self) -> None:
        """Look whether compiling is over."""
        process = self._process
        if process is None or process.poll() is None:
            return
        _, said = process.communicate()
        self._process = None
        self._tried.add(self._kinds)
        if process.returncode == 0:
            self._say(f"{self._names}: compiled, and can be set now")
            return
        *_, last = said.splitlines() or [f"exit code {process.returncode}"]
        self._say(f"{self._names}: can be set now, but not compiled: {in_one_line(last)}")

    def close(self) -> None:
        """End the other process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()


def _compiling(before: RigParameters, after: RigParameters) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-m", precompile.__name__],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    # It stays open: where it ends, so does the process.
    assert process.stdin is not None
    print(json.dumps([dict(before), dict(after)]), file=process.stdin, flush=True)
    return process
