# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Several nodes that command the valve are named, and nobody is blamed by mistake."""

from types import SimpleNamespace

from rodless_base.ros.rivals import Rivals


def rivals(found: dict[bytes, str], said: list[str]) -> Rivals:
    """Look among ``found``; what is logged is added to ``said``."""

    def publishers(_topic: str) -> list[SimpleNamespace]:
        return [
            SimpleNamespace(endpoint_gid=gid, node_namespace="/", node_name=name)
            for gid, name in found.items()
        ]

    node = SimpleNamespace(
        count_publishers=lambda _topic: len(found),
        get_publishers_info_by_topic=publishers,
        get_logger=lambda: SimpleNamespace(warning=said.append),
    )
    return Rivals(node, "/valve/voltage")  # type: ignore[arg-type]


def test_two_that_stay_are_named_once_in_the_log() -> None:
    """With the second report that finds them, until one is left."""
    found, said = {b"1": "controller", b"2": "mine"}, list[str]()
    looked = rivals(found, said)
    looked.check()
    assert looked.problem is None
    for _ in range(3):
        looked.check()
        assert looked.problem is not None
        assert looked.problem.startswith("2 nodes publish on valve/voltage (/controller, /mine),")
    assert said == [looked.problem], "once"
    found[b"3"] = "another"
    looked.check()
    assert looked.problem is not None
    assert looked.problem.startswith("3 nodes publish on valve/voltage (/another, /controller, ")
    assert len(said) == 1
    del found[b"2"], found[b"3"]
    looked.check()
    assert looked.problem is None


def test_a_node_that_is_known_late_or_was_started_again_is_no_rival() -> None:
    """Its name comes after its publisher, and its dead predecessor goes after 20 s."""
    found, said = {b"1": "controller", b"2": "_NODE_NAME_UNKNOWN_"}, list[str]()
    looked = rivals(found, said)
    looked.check()
    found[b"2"] = "controller"
    for _ in range(3):
        looked.check()
        assert looked.problem is None
    assert said == []
