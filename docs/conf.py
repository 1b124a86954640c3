# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The site: `make docs` builds it into build/docs."""

import shlex
import sys
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

HERE = Path(__file__).resolve().parent
# rosdoc2 builds from a copy of this folder, with the package on sys.path.
ROOT = next(
    folder
    for folder in (HERE.parent, *map(Path, sys.path))
    if (folder / "package.xml").is_file() and (folder / "rodless_sim").is_dir()
)
sys.path.insert(0, str(HERE / "_ext"))

MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()

project = MANIFEST.findtext("name", "")
author = MANIFEST.findtext("maintainer", "")
project_copyright = f"2026, {project} contributors"
release = version = MANIFEST.findtext("version", "")

# On the ROS build farm there is nothing but what has a rosdep key, Markdown among it: pages are
# without the notebooks there, and diagrams are text. `make docs` brings all of them.
NOTEBOOKS = find_spec("myst_nb") is not None

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "myst_nb" if NOTEBOOKS else "myst_parser",
    *filter(find_spec, ("sphinxcontrib.mermaid", "sphinx_copybutton")),
    "mathml",
    "repository_links",
    "remaining_pages",
    "verb_pages",
]
repository_root = str(ROOT)

source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"} if NOTEBOOKS else {".md": "markdown"}
exclude_patterns = [
    *("_build", "_ext", "**/.ipynb_checkpoints", "examples/*.md"),
    # What rosdoc2 puts beside these pages: the site has links to these files.
    *("README.md", "CONTRIBUTING.md", "QUALITY_DECLARATION.md"),
]

html_theme = "furo"
html_title = f"{project} {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
# myst_nb reads Markdown; a second reader would be refused.
rosdoc2_settings = {
    "override_theme": False,
    "allow_other_extensions": True,
    "support_markdown": False,
}

# Pages are Markdown as GitHub reads it: formulas between dollars, diagrams in Mermaid.
myst_url_schemes = ["http", "https", "mailto", "repository"]
myst_enable_extensions = ["dollarmath"]
myst_dmath_double_inline = True
myst_heading_anchors = 3
myst_fence_as_directive = ["mermaid"] if "sphinxcontrib.mermaid" in extensions else []

# Nothing is drawn in the reader's browser, and nothing loaded from elsewhere: formulas are MathML,
# diagrams pictures that are drawn here, by Mermaid inside of Python.
html_math_renderer = "mathml"
mermaid_output_format = "svg"
mermaid_cmd = shlex.join([sys.executable, "-m", "mermaidx"])
mermaid_params = ["--quiet", "--theme", "neutral", "--config", str(HERE / "_ext/mermaid.json")]

# The notebooks are run at each build; one that fails, fails the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # s, for a cell: the first compiles
nb_render_markdown_format = "myst"

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
napoleon_numpy_docstring = True
python_use_unqualified_type_names = True

# make docs-links: what needs an address that is reserved until the first release is no dead link.
linkcheck_ignore = [r".*\.example(/.*)?$"]
linkcheck_timeout = 20
