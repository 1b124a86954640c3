# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The directive `verbs`: what `rodless VERB --help` says, under a heading for each verb.

It asks the installed package, so that the page cannot fall behind.
"""

import contextlib
import importlib
import io
import os

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from rodless_lab.cli.main import VERBS

COLUMNS = "88"


def help_of(module: str) -> str:
    """Return what a verb prints for --help."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
        importlib.import_module(module).main(["--help"], None)  # which ends there
    return printed.getvalue().strip()


class Verbs(SphinxDirective):
    """A section for each verb of `rodless`."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        os.environ["COLUMNS"] = COLUMNS
        return [self.section(verb, *VERBS[verb]) for verb in VERBS]

    def section(self, verb: str, module: str, says: str) -> nodes.section:
        """Return the section of one verb."""
        found = nodes.section(ids=[f"rodless-{verb}"], names=[f"rodless {verb}"])
        found += nodes.title("", "", nodes.literal("", f"rodless {verb}"))
        found += nodes.paragraph("", f"{says[0].upper()}{says[1:]}.")
        text = help_of(module)
        found += nodes.literal_block(text, text, language="text")
        return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Join the build."""
    app.add_directive("verbs", Verbs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
