# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The limit for the nodes: rclpy alone hands messages on, and costs something."""

import sys

import pytest
from extent import extensive

from rodless_lab.benchmark.ros import bare
from rodless_lab.benchmark.ros.bare import bench_bare

pytestmark = pytest.mark.ros


def test_two_nodes_that_do_nothing_answer_each_other() -> None:
    """More than a hundred times a second, whatever else runs."""
    figures = bench_bare(0.0, lambda: None)
    assert list(figures) == ["rclpy alone, two processes: answers per wall-clock ms"]
    assert 0.1 < next(iter(figures.values())) < 1e3


@extensive
def test_a_paced_node_and_the_one_that_answers_it_use_some_of_a_core() -> None:
    """Most samples are answered, and both shares lie between nothing and all of it."""
    answers, plant, controller = bench_bare(100.0, lambda: None).values()
    assert 50.0 < answers < 110.0
    assert 0.0 < plant < 1.0
    assert 0.0 < controller < 1.0


def test_one_that_fails_is_named_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not the other, which waits for it."""
    monkeypatch.setattr(bare, "ROLES", ("plant", "nobody"))
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(RuntimeError, match="the plant ended with code 1"):
        bench_bare(0.0, lambda: None)
