"""The directive `verbs`: what `rodless VERB --help` says, for each verb, under a heading of its own.

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
