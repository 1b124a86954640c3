# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The layout of PlotJuggler holds together, and what docs/layouts.md does to layouts works.

Whether PlotJuggler and Foxglove show them can be seen in these alone.
"""

import json
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def layouts(tmp_path: Path) -> Path:
    """Return a folder with copies of both layouts."""
    for name in ("plotjuggler.xml", "foxglove.json"):
        shutil.copy(ROOT / "description" / name, tmp_path)
    return tmp_path


def run_from_the_page(first: str, folder: Path) -> None:
    """Run the lines of docs/layouts.md from the one that begins with ``first`` to the next call."""
    page = (ROOT / "docs" / "layouts.md").read_text(encoding="utf-8")
    (block,) = re.findall(rf"```sh\n({first}.*?)```", page, re.DOTALL)
    commands = [line for line in block.splitlines() if not line.startswith("plotjuggler ")]
    subprocess.run(["bash", "-euc", "\n".join(commands)], cwd=folder, check=True, timeout=60)


def sources(layout: Path) -> list[str]:
    """Return the topic and field of each curve."""
    root = ElementTree.parse(layout).getroot()
    return [str(one.text) for one in root.iter("linked_source")]


def selected(layout: Path) -> list[list[str]]:
    """Return the topics that are chosen, wherever the layout says so."""
    root = ElementTree.parse(layout).getroot()
    chosen = [one.get("value") for one in root.iter("selected_topics")]
    chosen += [one.get("selected_topics") for one in root.iter("parameters")]
    return [str(topics).split(";") for topics in chosen]


def test_each_curve_has_a_source_among_the_topics_that_are_chosen(layouts: Path) -> None:
    """An alias for each: of a curve whose topic is missing PlotJuggler would ask, and drop it."""
    layout = layouts / "plotjuggler.xml"
    root = ElementTree.parse(layout).getroot()
    aliases = [one.get("name") for one in root.iter("snippet")]
    assert sorted(aliases) == sorted({one.get("name") for one in root.iter("curve")})
    (topics,) = selected(layout)
    for source in sources(layout):
        assert any(source.startswith(f"{topic}/") for topic in topics), source
    assert all(any(one.startswith(f"{topic}/") for one in sources(layout)) for topic in topics)


def test_layouts_are_put_into_a_namespace(layouts: Path) -> None:
    """Every topic is below it but /diagnostics, which all rigs share."""
    run_from_the_page("left=", layouts)
    before, after = sources(layouts / "plotjuggler.xml"), sources(layouts / "left.xml")
    assert after == [f"/left{source}" for source in before]
    (topics,) = selected(layouts / "plotjuggler.xml")
    assert selected(layouts / "left.xml") == [[f"/left{topic}" for topic in topics]]
    texts = [
        (layouts / name).read_text(encoding="utf-8") for name in ("foxglove.json", "left.json")
    ]
    here, left = (sorted(set(re.findall(r'"(/[\w/]+)', text))) for text in texts)
    json.loads(texts[1])
    assert left == sorted(one if one == "/diagnostics" else f"/left{one}" for one in here)
    assert len(here) > 8


def test_a_layout_names_a_bag(layouts: Path) -> None:
    """With the topics that PlotJuggler would ask for, so that it opens without a click."""
    run_from_the_page("topics=", layouts)
    root = ElementTree.parse(layouts / "run1.xml").getroot()
    (file,) = root.iter("fileInfo")
    assert file.get("filename") == str(layouts / "run1" / "run1_0.mcap")
    (live,) = selected(layouts / "plotjuggler.xml")
    assert selected(layouts / "run1.xml") == [live, live]
