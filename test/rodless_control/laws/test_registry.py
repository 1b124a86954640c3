# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Laws by name: those of the package, and those of a user's own module."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rodless_control import (
    ControllerParameters,
    Law,
    Measurement,
    ParameterError,
    Pid,
    PidParameters,
    ReferencePoint,
)
from rodless_control.laws import LAWS, law_class, law_with, make_law

Write = Callable[[str, str], None]

MINE = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Mine(Law):
    PARAMETERS = declare(Parameter("mine.gain", 200.0, "V/m", "gain", "tuned", 0.0, 1e4))

    def update(self, measurement, reference, interval):
        return 5.08 + self.parameters["mine.gain"] * (reference.position - measurement.position)


class Stubborn(Law):
    def __init__(self):
        super().__init__()


class Namesake(Law):
    PARAMETERS = declare(Parameter("controller.kp", 1.0, "", "of the same name", "none"))


class Twofold(Law):
    TERMS = ("force", "force")


class Shadow(Law):
    TERMS = ("reference",)


class Spaced(Law):
    TERMS = ("a force",)


NOTHING = 3
"""

GREEDY = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Greedy(Law):
    PARAMETERS = declare(Parameter("reference.type", 1.0, "", "clash", "none"))
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Return what writes a module that Python finds."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name: str, text: str) -> None:
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")

    return write


@pytest.mark.parametrize("name", LAWS)
def test_every_law_of_the_package_is_found_and_made(name: str) -> None:
    """Each line of the registry names a Law that its default parameters make."""
    law = law_class(name)
    assert issubclass(law, Law)
    parameters = ControllerParameters.for_law(name)()
    assert type(make_law(law, parameters.of_law())) is law


def test_parameters_know_their_law() -> None:
    """PidParameters make a Pid with them."""
    law = law_with(PidParameters({"controller.kp": 7.0}))
    assert type(law) is Pid
    assert law.gains.kp == 7.0


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("pud", f"must be {', '.join(LAWS)} or package.module:Class"),
        ("", f"must be {', '.join(LAWS)} or package.module:Class"),
        ("nowhere_at_all:Law", "No module named 'nowhere_at_all'"),
        ("broken_laws:Law", "importing broken_laws failed: ZeroDivisionError: division by zero"),
        (
            "empty_laws:Empty",
            "importing empty_laws failed: TypeError: Empty: KERNELS is missing",
        ),
        (
            "needy_laws:Law",
            "importing needy_laws failed: ModuleNotFoundError: No module named 'nowhere_at_all' "
            "(needy_laws.py, line 2)",
        ),
        ("my_laws:Missing", "has no Missing"),
        ("my_laws:NOTHING", "NOTHING is not a subclass of rodless_control.Law"),
        ("my_laws:Twofold", "must be identifiers, each once"),
        ("my_laws:Shadow", "none of them reference"),
        ("my_laws:Spaced", "must be identifiers"),
        ("greedy_laws:Greedy", "its parameter reference.type is the node's own"),
    ],
)
def test_what_is_no_law_is_refused_in_one_line(module: Write, name: str, complaint: str) -> None:
    """The line names controller.law, what was given, and what is wrong with it."""
    module("my_laws", MINE)
    module("broken_laws", "1 / 0\n")
    module("greedy_laws", GREEDY)
    module("needy_laws", "import json\nimport nowhere_at_all\n")
    module(
        "empty_laws",
        "from rodless_control import CompiledLaw\nclass Empty(CompiledLaw):\n    TERMS = ()\n",
    )
    with pytest.raises(ParameterError) as refusal:
        ControllerParameters.for_law(name)
    text = str(refusal.value)
    assert text.startswith(f"controller.law: {name!r} refused: ")
    assert complaint in text
    assert "\n" not in text


def test_a_law_that_cannot_be_made_is_refused_in_one_line(module: Write) -> None:
    """One whose __init__ takes no parameters is named, with Python's own complaint."""
    module("my_laws", MINE)
    law = law_class("my_laws:Stubborn")
    with pytest.raises(ParameterError, match=r"controller\.law: 'my_laws:Stubborn'.*TypeError"):
        make_law(law, law.Parameters())


def test_a_law_that_answers_nothing_is_refused_in_one_line(module: Write) -> None:
    """Before it has a sample to answer: by its name, with the method that is missing."""
    module("my_laws", MINE)
    law = law_class("my_laws:Namesake")
    with pytest.raises(ParameterError, match=r"'my_laws:Namesake' refused: Namesake has no update"):
        make_law(law, law.Parameters())


def test_a_law_without_its_base_is_refused_in_one_line() -> None:
    """By the node as by closed_loop: such a law has no parameters and no limits."""

    class Lonely(Law):
        def __init__(self, _parameters: object = None) -> None:
            pass

    with pytest.raises(
        ParameterError, match=r"law Lonely: __init__ must call super\(\)\.__init__\(\)"
    ):
        make_law(Lonely, Lonely.Parameters())


def test_a_law_of_ones_own_brings_its_parameters(module: Write) -> None:
    """They stand among the node's, those of the PID do not, and the law gets its own alone."""
    module("my_laws", MINE)
    kind = ControllerParameters.for_law("my_laws:Mine")
    values = kind({"mine.gain": 50.0})
    assert values["controller.law"] == "my_laws:Mine"
    assert "controller.kp" not in values
    assert {"controller.joint", "reference.type", "controller.neutral_voltage"} <= values.keys()
    assert dict(values.of_law()) == {
        "mine.gain": 50.0,
        "controller.neutral_voltage": 5.08,
        "controller.minimum_voltage": 0.0,
        "controller.maximum_voltage": 10.0,
    }
    with pytest.raises(ParameterError, match=r"mine\.gain"):
        kind({"mine.gain": -1.0})


def test_presets_and_files_tune_the_laws_of_the_package_only(module: Write, tmp_path: Path) -> None:
    """A law of one's own takes the defaults from a preset, from which the PID has its gains.

    What a law of one's own calls as the PID does stays its own; a misspelt name is still refused.
    """
    module("my_laws", MINE)
    law = law_class("my_laws:Mine")
    assert law.Parameters.preset("paper") == law.Parameters()
    kind = ControllerParameters.for_law("my_laws:Mine")
    assert kind.preset("paper") == kind()
    path = tmp_path / "mine.yaml"
    text = "/**/controller:\n  ros__parameters:\n    controller: {kp: 7.0, ki: 3.0}\n"
    path.write_text(text, encoding="utf-8")
    for chosen in (
        law_class("my_laws:Namesake").Parameters,
        ControllerParameters.for_law("my_laws:Namesake"),
    ):
        assert chosen.from_file(path)["controller.kp"] == 7.0
        assert "controller.ki" not in chosen.from_file(path)
    path.write_text(text.replace("kp", "kP"), encoding="utf-8")
    for refused in (law.Parameters, kind):
        with pytest.raises(ParameterError, match=r"controller\.kP: no such parameter"):
            refused.from_file(path)


def test_a_compiled_law_whose_terms_are_not_its_command_s_cannot_be_made() -> None:
    """The error names the fields there are and those there must be, before anything runs."""
    for terms in ((), ("error", "p", "i", "d"), Pid.TERMS[::-1]):
        wrong = type("Wrong", (Pid,), {"TERMS": terms})
        with pytest.raises(TypeError) as refusal:
            wrong()
        assert str(refusal.value) == (
            "Wrong: the command of KERNELS.update has the fields voltage, error, p, i, d, "
            f"feedforward, but must have voltage and TERMS: {', '.join(('voltage', *terms))}"
        )
        with pytest.raises(ParameterError, match=r"Wrong\(parameters\) failed: TypeError: Wrong"):
            make_law(wrong, PidParameters())


def test_a_subclass_that_updates_in_python_may_have_other_terms() -> None:
    """Its kernel's command is not its answer."""

    class Louder(Pid):
        TERMS = ("volume",)

        def update(self, *sample: object) -> tuple[float, float]:
            return super().update(*sample).voltage, 11.0  # type: ignore[arg-type]

    assert Louder().update(Measurement(0, 0.05), ReferencePoint(0.05), 0.0) == (5.08, 11.0)
