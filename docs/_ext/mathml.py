# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Formulas as MathML, which browsers draw by themselves: a page loads nothing for them."""

from html import escape

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

LOGGER = logging.getLogger(__name__)


def visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write a formula into its line."""
    translator.body.append(mathml(node))
    raise nodes.SkipNode


def visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula on a line of its own."""
    text = mathml(node).replace("<math ", '<math display="block" ', 1)
    translator.body.append(f'<div class="math">{text}</div>\n')
    raise nodes.SkipNode


def mathml(node: nodes.Element) -> str:
    """Return a formula as MathML; one that docutils cannot read is a warning."""
    text = node.astext()
    try:
        return str(tex2mathml(text))
    except (ValueError, SyntaxError) as error:  # the latter from docutils before 0.21
        LOGGER.warning("%s: %s", text, error, location=node)
        return escape(text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Join the build."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
