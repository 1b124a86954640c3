# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The site builds without a warning, and what it is made of arrives in it."""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from unmeasured import unmeasured

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as `make docs` builds it; a warning fails."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", ROOT / "docs", folder],
        cwd=folder,
        env=unmeasured(),
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_every_page_is_in_the_site(site: Path) -> None:
    """Each Markdown page of docs/, and both notebooks."""
    pages = [path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")]
    notebooks = [path.relative_to(ROOT) for path in (ROOT / "examples").glob("*.ipynb")]
    assert len(pages) > 40
    assert len(notebooks) == 2
    for page in (*pages, *notebooks):
        assert (site / page.with_suffix(".html")).is_file(), page


def test_links_to_functions_lead_to_their_lines(site: Path) -> None:
    """From the model to the line of the file's page that defines the function."""
    page = (site / "model.html").read_text(encoding="utf-8")
    links = re.findall(r'href="(source/[\w/.]+\.html)#(line-\d+)"><code[^>]*>.*?>(\w+)<', page)
    assert len(links) > 20
    for file, line, name in links:
        shown = (site / file).read_text(encoding="utf-8")
        (found,) = re.findall(rf'name="{line}"[^\n]*', shown)
        assert re.search(rf"\b{name}\b", re.sub("<[^>]*>", "", found)), (file, line, name)


def test_the_notebooks_are_run(site: Path) -> None:
    """Each shows pictures that it has drawn."""
    for name in ("friction_and_stick_slip", "pid_tuning"):
        page = (site / "examples" / f"{name}.html").read_text(encoding="utf-8")
        assert page.count("cell_output") >= 4
        assert len(re.findall(r'<img[^>]*src="[^"]*_images/', page)) >= 4


def test_the_reference_is_made_from_the_code(site: Path) -> None:
    """Signatures and docstrings of the API, and the help of each verb."""
    page = (site / "api.html").read_text(encoding="utf-8")
    for name in (
        "rodless_sim.Rig.advance",
        "rodless_lab.closed_loop",
        "rodless_control.Law.update",
    ):
        assert f'id="{name}"' in page, name
    verbs = (site / "verbs.html").read_text(encoding="utf-8")
    assert verbs.count("usage: rodless ") > 20


class Loads(HTMLParser):
    """What a page loads without a click: addresses of scripts, styles, pictures and the like."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take the addresses of a tag; a link that is clicked loads nothing before."""
        if tag != "a":
            self.found += [value or "" for name, value in attrs if name in ADDRESSES]


ADDRESSES = ("src", "srcset", "href", "data", "poster", "action")
ELSEWHERE = re.compile(r"^\s*(?:https?:)?//", re.IGNORECASE)


def test_the_site_loads_nothing_from_elsewhere(site: Path) -> None:
    """A lecture room may have no network: no page, style or script asks for another address."""
    pages = list(site.rglob("*.html"))
    styles = [*site.rglob("*.css"), *site.rglob("*.svg")]
    assert len(pages) > 60
    assert styles
    found = 0
    for page in pages:
        text = page.read_text(encoding="utf-8")
        loads = Loads()
        loads.feed(text)
        found += len(loads.found)
        assert [one for one in loads.found if ELSEWHERE.match(one)] == [], page
        for script in re.findall(r"<script[^>]*>(.*?)</script>", text, re.DOTALL):
            assert not re.search(r"(?:import|from|fetch\()\s*[\"'](?:https?:)?//", script), page
    assert found > 10 * len(pages)
    for style in styles:
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//", text), style


def test_formulas_and_diagrams_are_drawn_when_the_site_is_built(site: Path) -> None:
    """As MathML and as a picture; no source of one is left on a page."""
    model = (site / "model.html").read_text(encoding="utf-8")
    assert model.count("<math ") > 80
    assert r"\frac" not in model
    page = (site / "architecture.html").read_text(encoding="utf-8")
    (file,) = re.findall(r'<object data="([^"]+)" type="image/svg\+xml">', page)
    drawn = ElementTree.parse(site / file).getroot()
    shown = " ".join("".join(drawn.itertext()).split())
    for words in ("ControlLoop.sample(measurement)", "rodless_sim: the plant", "topics"):
        assert words in shown


# Sphinx where these are not installed: they have no rosdep key, and the ROS build farm has none.
WITHOUT_EXTRAS = """
import sys
from importlib import metadata

WITHOUT = "furo", "mermaidx", "myst_nb", "sphinx_copybutton", "sphinxcontrib.mermaid"
every = metadata.Distribution.entry_points.fget
metadata.Distribution.entry_points = property(
    lambda self: [one for one in every(self) if not one.value.startswith(WITHOUT)]
)
sys.modules |= dict.fromkeys(WITHOUT)

from sphinx.cmd.build import main

sys.exit(main(sys.argv[1:]))
"""


def test_pages_are_built_where_only_packages_with_rosdep_keys_are(tmp_path: Path) -> None:
    """A page of formulas and one with a diagram, in the theme that rosdoc2 puts in."""
    pages = tmp_path / "docs"
    for folder in ("_ext", "_static"):
        shutil.copytree(ROOT / "docs" / folder, pages / folder)
    for page in ("conf.py", "model.md", "architecture.md"):
        shutil.copy(ROOT / "docs" / page, pages)
    (pages / "index.md").write_text("# Two pages\n\n```{toctree}\nmodel\narchitecture\n```\n")
    out = tmp_path / "site"
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRAS, "-q", "-D", "html_theme=alabaster", pages, out],
        cwd=ROOT,  # as of rosdoc2, which puts the package's folder on sys.path
        env=unmeasured() | {"PYTHONSAFEPATH": "", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (out / "model.html").read_text(encoding="utf-8").count("<math ") > 80
    assert "flowchart" in (out / "architecture.html").read_text(encoding="utf-8")


def test_rosdoc2_is_told_where_the_site_is() -> None:
    """package.xml exports a configuration that names the folder of conf.py."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    file = ROOT / str(manifest.findtext("export/rosdoc2"))
    kind, settings = yaml.safe_load_all(file.read_text(encoding="utf-8"))
    assert kind == {"type": "rosdoc2 config", "version": 1}
    (builder,) = settings["builders"]
    assert (ROOT / builder["sphinx"]["sphinx_sourcedir"] / "conf.py").is_file()
