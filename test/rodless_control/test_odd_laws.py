# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Laws that cannot be: refused in one line; laws that can: copied, pickled, shown."""

import copy
import importlib
import math
import pickle
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from rodless_base.parameters import Parameter, ParameterError, declare
from rodless_control import (
    CompiledLaw,
    ControllerParameters,
    Law,
    Measurement,
    Pid,
    PidParameters,
    ReferencePoint,
)
from rodless_control.controller import FunctionLaw, LawError, checked_answer
from rodless_control.laws import law_with
from rodless_control.loop import ControlLoop
from rodless_lab.simulation.closed_loop import as_law
from rodless_sim import RigParameters

LAWS = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class First(Law):
    PARAMETERS = declare(Parameter("mine.gain", 60.0, "V/m", "gain", "tuned", 0.0, 1e4))

    def update(self, measurement, reference, interval):
        return 5.08 + self.parameters["mine.gain"] * (reference.position - measurement.position)


class Second(First):
    def update(self, measurement, reference, interval):
        return 5.5


class Outer:
    class Inner(First):
        pass


class Exiting(Law):
    def update(self, measurement, reference, interval):
        raise SystemExit(3)
"""


Write = Callable[[str], None]


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Write]:
    """Write the module `odd_laws`, which Python then finds."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(text: str) -> None:
        (tmp_path / "odd_laws.py").write_text(text, encoding="utf-8")
        importlib.invalidate_caches()

    yield write
    sys.modules.pop("odd_laws", None)


@pytest.fixture
def laws(written: Write) -> ModuleType:
    """Return a module with laws that can be."""
    written(LAWS)
    return importlib.import_module("odd_laws")


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        (
            "class E(Exception):\n    def __str__(self): raise ValueError\nraise E",
            "E: (its text cannot be shown)",
        ),
        ("raise ValueError('x\\n' * 1_000_000)", "ValueError: x x x"),
    ],
)
def test_a_module_that_cannot_be_imported_is_one_short_line(
    written: Write, text: str, cause: str
) -> None:
    """Whatever it raises, the process goes on."""
    written(text)
    with pytest.raises(ParameterError) as refusal:
        ControllerParameters.for_law("odd_laws:First")
    assert f"'odd_laws:First' refused: importing odd_laws failed: {cause}" in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 700


def test_an_interrupt_on_the_way_to_a_law_that_is_loaded_is_one(
    laws: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its import cannot fail any more: what comes then is Ctrl-C, and no fault of the law."""

    def interrupted(_name: str) -> ModuleType:
        raise KeyboardInterrupt

    monkeypatch.setattr(importlib, "import_module", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ControllerParameters.for_law(f"{laws.__name__}:First")


@pytest.mark.parametrize("name", [5, None, "x" * 3_000_000, "a:b:c"])
def test_a_name_that_no_law_can_have_is_one_short_line(name: object) -> None:
    """Numbers, long texts, and one colon too many."""
    with pytest.raises(ParameterError, match=r"^controller\.law: ") as refusal:
        ControllerParameters.for_law(name)  # type: ignore[arg-type]
    assert len(str(refusal.value)) < 300


@pytest.mark.parametrize("terms", ["force", (1,), ("größe",), None, ("voltage",), ("a", "a")])
def test_terms_that_cannot_be_topics_are_refused(laws: ModuleType, terms: object) -> None:
    """A text would be taken letter by letter; ROS has no umlauts."""
    laws.First.TERMS = terms
    with pytest.raises(ParameterError, match=r"its TERMS .* must be identifiers"):
        ControllerParameters.for_law.__wrapped__("odd_laws:First")


@pytest.mark.parametrize(
    "declared",
    [
        [1],
        {"x": 1},
        {1: Parameter(1, 1.0, "", "", "")},  # type: ignore[arg-type]
        {"other": Parameter("mine.gain", 1.0, "", "", "")},
        declare(Parameter("a b", 1.0, "", "", "")),
        declare(Parameter("mine..gain", 1.0, "", "", "")),
        declare(Parameter("", 1.0, "", "", "")),
        declare(Parameter("controller.neutral_voltage", 1.0, "V", "", "")),
        declare(Parameter("reference.type", "x", "", "", "")),
        declare(Parameter("frame_prefix", "x", "", "", "")),
        declare(Parameter("use_sim_time", True, "", "", "")),
    ],
    ids=str,
)
def test_parameters_that_cannot_be_declared_are_refused(declared: object) -> None:
    """Where the class is written, by name."""
    with pytest.raises(TypeError, match=r"^Odd: ") as refusal:
        type("Odd", (Law,), {"PARAMETERS": declared})
    assert "\n" not in str(refusal.value)


def test_a_subclass_has_parameters_of_its_own(laws: ModuleType) -> None:
    """Its set stands for it and not for its base class; the names are the base's."""
    assert laws.Second.Parameters.DECLARATIONS == laws.First.Parameters.DECLARATIONS
    found = law_with(laws.Second.Parameters({"mine.gain": 7.0}))
    assert type(found) is laws.Second
    assert found.parameters["mine.gain"] == 7.0
    assert type(law_with(laws.Outer.Inner.Parameters())) is laws.Outer.Inner

    class Mine(Pid):
        """A PID of one's own."""

    assert isinstance(Mine.Parameters(), PidParameters)
    assert Mine.Parameters.LAW_NAME.endswith("Mine")


def test_a_law_is_not_given_the_parameters_of_something_else() -> None:
    """The text names one that is missing and the set to give."""
    with pytest.raises(ParameterError, match=r"^Pid: RigParameters\(\) refused, it has no contro"):
        Pid(RigParameters())


def test_sets_of_own_laws_can_be_pickled_copied_and_typed_in_again(laws: ModuleType) -> None:
    """The class of for_law and that of the law's own set stand in no module."""
    scope = {**vars(laws), "ControllerParameters": ControllerParameters}
    kinds = (laws.First.Parameters, ControllerParameters.for_law("odd_laws:First"))
    for given in (kind({"mine.gain": 4.0}) for kind in kinds):
        for found in (
            pickle.loads(pickle.dumps(given)),
            copy.copy(given),
            copy.deepcopy(given),
            eval(repr(given), scope),
        ):
            assert type(found) is type(given)
            assert found == given
            assert repr(found) == repr(given)


def test_laws_can_be_pickled_and_copied_in_the_midst_of_a_run(laws: ModuleType) -> None:
    """The copy goes on where the law was; repr makes a law of the same parameters."""
    first = Measurement(0, 0.05), ReferencePoint(0.0505), 0.0
    second = Measurement(1_000_000, 0.0502), ReferencePoint(0.0505), 1e-3
    scope = {**vars(laws), "Pid": Pid, "PidParameters": PidParameters}
    for law in (Pid({"controller.kp": 300.0}), laws.First({"mine.gain": 5.0})):
        law.reset()
        law.update(*first)
        copies = [pickle.loads(pickle.dumps(law)), copy.deepcopy(law)]
        assert eval(repr(law), scope).parameters == law.parameters
        expected = law.update(*second)
        assert [found.update(*second) for found in copies] == [expected] * 2


@pytest.mark.parametrize(
    "sample",
    [
        (Measurement(0, math.nan), ReferencePoint(0.06), 1e-3),
        (Measurement(0, 0.05), ReferencePoint(math.nan), 1e-3),
        (Measurement(0, 0.05), ReferencePoint(0.06, math.nan), 1e-3),
    ],
)
def test_one_nan_does_not_poison_the_pid(
    sample: tuple[Measurement, ReferencePoint, float],
) -> None:
    """It is answered with NaN, and the next sample as if it had never been."""
    good = Measurement(0, 0.05), ReferencePoint(0.051), 1e-3
    poisoned, sound = Pid(), Pid()
    for law in (poisoned, sound):
        law.update(*good)
    assert math.isnan(poisoned.update(*sample).voltage)
    assert poisoned.update(*good) == sound.update(*good)
    fresh = Pid()
    assert math.isnan(fresh.update(*sample).voltage)
    assert fresh.update(*good) == Pid().update(*good)


@pytest.mark.parametrize("interval", [-1e-3, math.nan, math.inf, -math.inf])
def test_a_time_that_cannot_pass_is_refused_and_changes_nothing(interval: float) -> None:
    """Time that runs backwards would let the filter and the integral grow."""
    law = Pid()
    law.update(Measurement(0, 0.05), ReferencePoint(0.051), 0.0)
    before = law.memory
    with pytest.raises(ValueError, match=r"^interval .* s refused: must be the time since"):
        law.update(Measurement(0, 0.05), ReferencePoint(0.051), interval)
    assert law.memory == before


@pytest.mark.parametrize(("answer", "terms"), [(10**400, ()), ((5.08, -(10**400)), ("force",))])
def test_a_whole_number_beyond_floats_is_no_command(answer: object, terms: tuple[str, ...]) -> None:
    """It is refused as any other answer, and not by Python's own error."""
    law = type("Huge", (Law,), {"TERMS": terms})()
    with pytest.raises(LawError, match=r"^law Huge answered .*1000.* finite number") as refusal:
        checked_answer(law, answer)
    assert len(str(refusal.value)) < 300


def test_a_parameter_that_a_law_has_not_is_named() -> None:
    """A subclass that replaces PARAMETERS no longer has its base's."""
    parameters = Law().parameters
    assert "mine.gain" not in parameters
    assert parameters.get("mine.gain") is None
    for ask in (parameters.__getitem__, parameters.number, parameters.text):
        with pytest.raises(KeyError, match=r"mine\.gain: no such parameter"):
            ask("mine.gain")


def test_a_law_that_exits_is_a_failure_and_not_the_end(laws: ModuleType) -> None:
    """The loop stays safe and names it."""
    loop = ControlLoop(ControllerParameters.for_law("odd_laws:Exiting")())
    assert loop.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5)) is None
    assert loop.failure is not None
    assert loop.failure.startswith("law Exiting failed: SystemExit: 3 (odd_laws.py, line")
    del laws


COMPILED = """
from typing import NamedTuple
from rodless_base.kernels import kernel
from rodless_control import CompiledLaw
from rodless_control.controller import Kernels

class Memory(NamedTuple):
    x: float

class Command(NamedTuple):
    voltage: float
    term: float

def gains_of(parameters):
    return Memory(1.0)

@kernel
def begin(gains, measurement):
    return BEGIN

@kernel
def update(gains, memory, measurement, reference, interval):
    return Memory(memory.x + 1.0), COMMAND

class Odd(CompiledLaw):
    TERMS = ("term",)
    KERNELS = Kernels(gains_of, begin, update)
"""


@pytest.mark.parametrize(
    ("begin", "command", "complaint"),
    [
        ("Memory(0)", "Command(5.5, 1.0)", "the memory of KERNELS.update"),
        ("Memory(0.0)", "Command(5.5, 1)", "term in the command of KERNELS.update is 1"),
        ("gains.nothing", "Command(5.5, 1.0)", "KERNELS.begin does not compile: Unknown attribute"),
        ("Memory(0.0)", "Memory(5.5)", "has the fields x, but must have voltage and TERMS"),
    ],
)
def test_a_compiled_law_that_cannot_run_is_one_line(
    written: Write, begin: str, command: str, complaint: str
) -> None:
    """Before it runs, instead of pages of the compiler."""
    written(COMPILED.replace("BEGIN", begin).replace("COMMAND", command))
    law: type[CompiledLaw] = importlib.import_module("odd_laws").Odd
    with pytest.raises(TypeError, match=r"^Odd: ") as refusal:
        law()
    assert complaint in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 600


@pytest.mark.parametrize("function", [math.sin, lambda: 5.0, lambda _a, _b, _c: 5.0])
def test_a_function_that_takes_other_arguments_is_no_law(
    function: Callable[..., float],
) -> None:
    """Refused before the run, with what it should be."""
    with pytest.raises(TypeError, match=r"no control law, .*\(measurement, reference\) -> voltage"):
        FunctionLaw(function)


def test_a_function_that_takes_both_is_a_law() -> None:
    """By position, with or without defaults, bound to an object or not."""
    for function in (lambda _m, _r: 5.0, lambda *_both: 5.0, lambda _m, _r, scale=5.0: scale):
        assert FunctionLaw(function).update(Measurement(0, 0.1), ReferencePoint(0.1), 0.0) == 5.0


def test_the_base_of_compiled_laws_is_no_law() -> None:
    """It has no functions of its own; the line says what to give."""
    for take in (CompiledLaw, lambda: as_law(CompiledLaw)):
        with pytest.raises(TypeError, match=r"^CompiledLaw has no KERNELS: give a subclass of it$"):
            take()
