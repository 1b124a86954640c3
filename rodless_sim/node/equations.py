# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a running plant does about equations that it has not had before: they compile elsewhere."""

import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from rodless_base.kernels import keeps
from rodless_base.parameters import ParameterError
from rodless_base.ros.parameters import NotYetError
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.motion import advance_at_voltage
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.settled import load_for
from rodless_sim.precompile import (
    Kind,
    compile_changes,
    compile_elsewhere,
    is_compiled,
    kind_of,
    last_words,
)
from rodless_sim.rig import SWITCHES, Rig


class Compiling(NamedTuple):
    """What another process compiles: for which parameters, and which sets of them."""

    process: "subprocess.Popen[str]"
    names: str
    wanted: Sequence[RigParameters]


class Equations:
    """Sees to it that a change of parameters does not wait for the compiler.

    Compiling takes a minute, in which a plant would stand still. So the change is refused, another
    process compiles, and what is compiled is loaded while the plant goes on.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        """Nothing runs yet; ``say`` is told what becomes of it."""
        self._say = say
        self._compiling: Compiling | None = None
        # Why another process could not do it, and for what, until somebody has been told.
        self._failure, self._failed = "", frozenset[Kind]()
        # What the plant need not wait for, and what it has to wait for after a failure.
        self._done: set[Kind] = set()

    def load(self, before: RigParameters, values: Iterable[RigParameters]) -> None:
        """Load, or compile, what a rig needs to change from one set to any of these ``values``."""
        ahead = list(values)
        _load_for_resets(ahead)
        self._done.add(kind_of(before))
        self._load(before, self._new(ahead))

    def _load(self, before: RigParameters, new: Iterable[RigParameters]) -> None:
        compile_changes(before, new)
        self._done.update(map(kind_of, new))

    def _new(self, values: Iterable[RigParameters]) -> Sequence[RigParameters]:
        """Return one set of each kind that is not done."""
        kinds = {kind_of(one): one for one in values}
        return [one for kind, one in kinds.items() if kind not in self._done]

    def require(self, rig: Rig, changes: Mapping[str, object]) -> None:
        """Load what ``rig`` needs for these ``changes``; raises NotYetError until it is compiled.

        Where nothing is kept of what another process compiles, it is compiled here. Raises
        ParameterError where no other process can do it.
        """
        ahead = list(rig.ahead(rig.parameters.with_values(changes)))
        _load_for_resets(ahead)
        names = ", ".join(name for name in changes if name in SWITCHES)
        if not names:
            return
        new = self._new(ahead)
        lacking = [values for values in new if not self._is_there(values)]
        if lacking and keeps(advance_at_voltage):
            if self._compiling is None:
                self._start(names, rig.parameters, lacking)
            raise NotYetError(
                f"{names} wants other equations of the plant, which another process compiles in "
                "about a minute, once on a machine; set it again then"
            )
        if not self._failed.isdisjoint(map(kind_of, ahead)):
            self._failed = frozenset()
            raise ParameterError(
                f"{names}: refused, another process could not compile the plant's equations for it "
                f"({self._failure}); set again, it makes the plant stand still for about a minute"
            )
        self._load(rig.parameters, new)

    def _is_there(self, values: RigParameters) -> bool:
        """Whether it is compiled, and whoever asked for it has been told so."""
        wanted = self._compiling.wanted if self._compiling is not None else ()
        under_way = kind_of(values) in map(kind_of, wanted)
        return not under_way and is_compiled(values)

    def _start(self, names: str, before: RigParameters, wanted: Sequence[RigParameters]) -> None:
        try:
            process = compile_elsewhere(before, wanted)
        except OSError as error:
            raise ParameterError(
                f"{names}: refused, no process can be started to compile the plant's equations "
                f"for it: {error.strerror}; free some memory and set it again"
            ) from error
        self._compiling = Compiling(process, names, wanted)
        self._say(f"{names}: compiling the plant's equations for it in another process")

    def poll(self) -> None:
        """Look whether compiling is over."""
        if self._compiling is None or self._compiling.process.poll() is None:
            return
        (process, names, wanted), self._compiling = self._compiling, None
        words = last_words(process)  # and no zombie is left of it
        if all(map(is_compiled, wanted)):
            self._say(f"{names}: compiled, and can be set now")
            return
        self._failure, self._failed = words, frozenset(map(kind_of, wanted))
        self._done |= self._failed
        self._say(f"{names}: not compiled: {self._failure}")

    def close(self) -> None:
        """End the other process."""
        if self._compiling is not None:
            self._compiling.process.kill()
            self._compiling.process.communicate()


def _load_for_resets(ahead: Iterable[RigParameters]) -> None:
    for values in ahead:
        load_for(Plant.of(values))
