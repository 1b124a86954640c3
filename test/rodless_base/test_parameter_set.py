# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A set of parameters: always complete, always valid, changed as a whole or not at all."""

import math
from typing import ClassVar

import pytest

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_control import PidParameters
from rodless_sim import RigParameters


class Toy(ParameterSet):
    """Two bounds and a few other values."""

    DECLARATIONS: ClassVar[dict[str, Parameter]] = declare(
        Parameter("range.low", 0.0, "m", "lower end", "test", -1.0, 1.0),
        Parameter("range.high", 0.5, "m", "upper end", "test", -1.0, 1.0),
        Parameter("name", "toy", "", "a name", "test"),
        Parameter("on", True, "", "a switch", "test"),
        Parameter("count", 2, "", "a count", "test", 0, 9),
        Parameter("curve", (1.0, 2.0), "", "a curve", "test"),
    )
    NODE: ClassVar[str] = "toy"

    def check_together(self) -> None:
        """Refuse an empty range."""
        if self.number("range.low") >= self.number("range.high"):
            raise ParameterError("range.low: not below range.high")


def test_a_default_out_of_its_own_range_is_refused() -> None:
    """A set of one's own cannot begin with a value that nobody could give it."""

    class Wrong(ParameterSet):
        DECLARATIONS: ClassVar = declare(Parameter("gain", 5.0, "", "a gain", "test", 0.0, 1.0))

    with pytest.raises(ParameterError, match=r"gain: 5\.0 refused, must be from 0 to 1"):
        Wrong()


def test_defaults_are_the_declared_ones() -> None:
    """Without values a set holds every declared default, in the order of the declarations."""
    toy = Toy()
    assert dict(toy) == {name: p.default for name, p in Toy.DECLARATIONS.items()}
    assert list(toy) == list(Toy.DECLARATIONS)
    assert len(toy) == len(Toy.DECLARATIONS) == 6


def test_values_come_in_their_type() -> None:
    """Numbers, texts and tuples are asked for as such; asking for the wrong kind is a TypeError."""
    toy = Toy({"range.high": 1, "curve": [3, 4]})
    assert (toy.number("range.high"), toy.number("on"), toy.number("count")) == (1.0, 1.0, 2.0)
    assert toy.text("name") == "toy"
    assert toy.numbers("curve") == (3.0, 4.0)
    for wrong in ("name", "curve"):
        with pytest.raises(TypeError, match=wrong):
            toy.number(wrong)
    with pytest.raises(TypeError, match=r"range\.low"):
        toy.numbers("range.low")
    with pytest.raises(KeyError):
        toy["range.middle"]


@pytest.mark.parametrize(
    ("kind", "name", "meant"),
    [
        (Toy, "range.lo", "range.low"),
        (RigParameters, "suply.pressure", "supply.pressure"),
        (RigParameters, "friction.forward.statik", "friction.forward.static"),
        (PidParameters, "controller.kP", "controller.kp"),
        (PidParameters, "kp", None),
        (Toy, "zzzzzzzzzz", None),
    ],
)
def test_an_unknown_name_is_refused(kind: type[ParameterSet], name: str, meant: str | None) -> None:
    """The message names it, and the known name nearest to it where there is one."""
    hint = f"; did you mean {meant}?" if meant else ""
    for attempt in (lambda: kind({name: 1.0}), lambda: kind().with_values({name: 1.0})):
        with pytest.raises(ParameterError) as refusal:
            attempt()
        assert str(refusal.value) == f"{name}: no such parameter{hint}"


def test_blanks_about_a_name_are_seen() -> None:
    """Without the quotes it would be its own remedy."""
    with pytest.raises(ParameterError) as refusal:
        RigParameters({"supply.pressure ": 6e5})
    said = "'supply.pressure ': no such parameter; did you mean supply.pressure?"
    assert str(refusal.value) == said


def test_a_limit_is_stated_to_the_digit() -> None:
    """That of the tilt is half pi: rounded up, it would name a value that is refused."""
    with pytest.raises(ParameterError, match=f"from -{math.pi / 2} to {math.pi / 2} ") as refusal:
        RigParameters({"rail.tilt": 1.5708})
    stated = float(str(refusal.value).split()[-2])
    assert RigParameters({"rail.tilt": stated}).number("rail.tilt") == stated


def test_changes_make_a_new_set_and_leave_the_old() -> None:
    """with_values keeps everything that it is not told to change, and the set it came from."""
    old = Toy({"name": "old", "range.low": -0.5})
    new = old.with_values({"name": "new", "on": False})
    assert type(new) is Toy
    assert (new.text("name"), new["on"], new.number("range.low")) == ("new", False, -0.5)
    assert (old.text("name"), old["on"]) == ("old", True)


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "new", "count": 10},
        {"name": "new", "no.such": 1.0},
        {"name": "new", "range.low": 0.6},
        {"name": "new", "range.high": float("nan")},
    ],
)
def test_changes_are_all_made_or_none(changes: dict[str, object]) -> None:
    """One bad value, name or pair among good ones refuses all; the set stays as it was."""
    toy = Toy({"name": "old"})
    before = dict(toy)
    with pytest.raises(ParameterError):
        toy.with_values(changes)
    assert dict(toy) == before


def test_values_are_checked_together_after_all_are_changed() -> None:
    """A pair that would contradict itself halfway through is moved in one change."""
    moved = Toy().with_values({"range.low": 0.6, "range.high": 0.9})
    assert (moved.number("range.low"), moved.number("range.high")) == (0.6, 0.9)


def test_a_set_cannot_be_written_to() -> None:
    """There is no way to change a value in place."""
    toy = Toy()
    with pytest.raises(TypeError):
        toy["name"] = "other"  # type: ignore[index]
    with pytest.raises(TypeError):
        del toy["name"]  # type: ignore[attr-defined]


def test_what_was_given_may_change_afterwards() -> None:
    """A set keeps copies: dictionaries and lists it was made from have no hold on it."""
    curve = [5.0, 6.0]
    given: dict[str, object] = {"curve": curve}
    toy = Toy(given)
    curve[0] = 7.0
    given["name"] = "other"
    assert (toy.numbers("curve"), toy.text("name")) == ((5.0, 6.0), "toy")


def test_equal_sets_are_equal_and_hash_alike() -> None:
    """However they came about; another value makes another set."""
    one, two = Toy({"count": 3}), Toy().with_values({"count": 3.0})
    assert one == two
    assert hash(one) == hash(two)
    assert one != Toy()
    assert len({one, two, Toy()}) == 2


def test_it_shows_what_differs_from_the_defaults() -> None:
    """A set in a log is short."""
    assert repr(Toy({"count": 3, "name": "toy"})) == "Toy({'count': 3})"


@pytest.mark.parametrize("kind", [RigParameters, PidParameters])
def test_every_declaration_of_the_product_is_sound(kind: type[ParameterSet]) -> None:
    """Names are indexed by themselves, defaults lie within their own bounds and choices."""
    for name, declared in kind.DECLARATIONS.items():
        assert declared.name == name
        assert declared.check(declared.default) == declared.default
        assert declared.minimum < declared.maximum
        assert declared.meaning
        assert declared.source


@pytest.mark.parametrize("kind", [RigParameters, PidParameters])
def test_every_number_of_the_product_refuses_nan_and_infinity(kind: type[ParameterSet]) -> None:
    """Whatever its range, no parameter lets through what is no number."""
    for name, declared in kind.DECLARATIONS.items():
        if type(declared.default) in (int, float):
            for value in (float("nan"), float("inf"), float("-inf")):
                with pytest.raises(ParameterError, match=f"^{name}: "):
                    kind({name: value})
