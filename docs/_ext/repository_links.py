# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Links from pages to files of the repository: in the site, to pages that show these files.

On GitHub `[flow.py](../rodless_sim/physics/flow.py)` leads to the file. The site has the file as a
page of its own, `source/rodless_sim/physics/flow.py.html`, with its lines numbered; a folder is a
list of what is in it. `…/flow.py#nozzle` leads to the line that defines `nozzle`.
"""

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urldefrag

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging

SCHEME = "repository:"
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)\s]+)\)")
LOGGER = logging.getLogger(__name__)


def definitions(file: Path) -> dict[str, int]:
    """Return the line of each function, class and constant of a module, or heading of a page."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        lines = enumerate(text.splitlines(), 1)
        return {github_slug(line): k for k, line in lines if line.startswith("#")}
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node.lineno
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            found[node.targets[0].id] = node.lineno
    return found


def github_slug(heading: str) -> str:
    """Return the anchor that GitHub gives a heading."""
    return re.sub(r"[^\w -]", "", heading.lstrip("# ").lower()).replace(" ", "-")


def rewrite_links(app: Sphinx, docname: str, content: list[str]) -> None:
    """Mark links that leave the docs, before the page is parsed."""
    root = Path(app.config.repository_root)
    # Where the page stands in the repository: rosdoc2 has a copy of the docs elsewhere.
    home = (root / "docs" / docname).parent

    def replaced(match: re.Match[str]) -> str:
        text, (target, name) = match[1], urldefrag(match[2])
        if text.startswith("!") or "://" in target or not target:
            return match[0]
        path = Path(os.path.normpath(home / target))
        inside = os.path.relpath(path, root / "docs")
        if not inside.startswith("..") and not path.is_dir():
            return match[0]
        if path.is_dir() and path.with_suffix(".md").is_file():
            return f"{text}({os.path.relpath(path, home)}.md)"
        return f"{text}({SCHEME}{os.path.relpath(path, root)}{'#' * bool(name)}{name})"

    if app.env.doc2path(docname).suffix == ".md":
        content[0] = LINK.sub(replaced, content[0])


def resolve_links(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Point marked links to the pages of their files; a wrong one is a warning."""
    root = Path(app.config.repository_root)
    for reference in doctree.findall(nodes.reference):
        uri = reference.get("refuri", "")
        if not uri.startswith(SCHEME):
            continue
        path, name = urldefrag(uri.removeprefix(SCHEME))
        line, page = "", path.removesuffix(".ipynb")
        if page in app.env.found_docs:  # docs/examples is the folder examples
            reference["refuri"] = app.builder.get_relative_uri(docname, page)
            continue
        if not (root / path).exists():
            LOGGER.warning("%s: not in the repository", path, location=reference)
            continue
        if name:
            known = definitions(root / path)
            if name not in known:
                LOGGER.warning("%s: no %s in it", path, name, location=reference)
                continue
            line = f"#line-{known[name]}"
        app.env.repository_files.add(path)
        reference["refuri"] = app.builder.get_relative_uri(docname, f"source/{path}") + line
        reference["classes"] = [*reference.get("classes", []), "internal"]


def pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yield a page for each file and folder that is linked to."""
    root = Path(app.config.repository_root)
    waiting = sorted(app.env.repository_files)
    shown: set[str] = set()
    while waiting:
        path = waiting.pop()
        if path in shown:
            continue
        shown.add(path)
        if (root / path).is_dir():
            names = [entry for entry in sorted((root / path).iterdir()) if listed(entry)]
            waiting += [str(entry.relative_to(root)) for entry in names]
            body = listing(app, root, path, names)
        else:
            body = highlighted(app, root / path)
        yield f"source/{path}", {"title": path, "body": f"<h1>{path}</h1>{body}"}, "page.html"


def listed(entry: Path) -> bool:
    """Whether a folder's page shows an entry."""
    return entry.name[0] not in "._" and entry.suffix not in (".pyc", ".png")


def listing(app: Sphinx, root: Path, path: str, names: list[Path]) -> str:
    """Return a folder's entries as HTML, each with its first line of documentation."""
    rows = []
    for entry in names:
        inside = str(entry.relative_to(root))
        uri = app.builder.get_relative_uri(f"source/{path}", f"source/{inside}")
        rows.append(f'<li><a href="{uri}">{entry.name}</a> {summary(entry)}</li>')
    return f"<ul>{''.join(rows)}</ul>"


def summary(entry: Path) -> str:
    """Return the first line of a module's docstring."""
    module = entry / "__init__.py" if entry.is_dir() else entry
    if module.suffix != ".py" or not module.is_file():
        return ""
    text = ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or ""
    return text.partition("\n")[0].replace("&", "&amp;").replace("<", "&lt;")


def highlighted(app: Sphinx, file: Path) -> str:
    """Return a file's text as HTML, with lines to link to."""
    kinds = {".py": "python", ".yaml": "yaml", ".c": "c", ".xml": "xml", ".json": "json"}
    return app.builder.highlighter.highlight_block(
        file.read_text(encoding="utf-8"),
        kinds.get(file.suffix, "text"),
        linenos="inline",
        lineanchors="line",
        anchorlinenos=True,
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Join the build."""
    app.add_config_value("repository_root", "", "env")
    app.connect("builder-inited", lambda app: setattr(app.env, "repository_files", set()))
    app.connect("source-read", rewrite_links)
    app.connect("doctree-resolved", resolve_links)
    app.connect("html-collect-pages", pages)
    return {"parallel_read_safe": True, "parallel_write_safe": False}
