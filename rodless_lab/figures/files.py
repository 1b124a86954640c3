# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Figures as files: PNG, PDF, and CSV of what they show."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from rodless_lab.figures.style import STYLE
from rodless_lab.figures.table import table_of

# Dots per inch: for a page on a screen, and for print.
SCREEN = 140
PRINT = 300

# What matplotlib would write into a file besides the figure: its version and the time.
_PNG_METADATA: dict[str, Any] = {"Software": None}
_PDF_METADATA: dict[str, Any] = {"Creator": None, "Producer": None, "CreationDate": None}


def png(draw: Callable[[], Figure]) -> bytes:
    """Return what ``draw`` draws as PNG for a screen; the same figure gives the same bytes."""
    with mpl.rc_context(STYLE):
        return _image(draw(), "png", SCREEN, _PNG_METADATA)


def files_of_figure(folder: Path, name: str) -> tuple[Path, Path, Path]:
    """Return where a figure goes: as PNG, as PDF for print, and as CSV of what it shows."""
    return folder / f"{name}.png", folder / f"{name}.pdf", folder / f"{name}.csv"


def figure_contents(folder: Path, name: str, draw: Callable[[], Figure]) -> dict[Path, bytes]:
    """Return what ``draw`` draws as the contents of :func:`files_of_figure`.

    The same figure gives the same bytes. The CSV holds what :func:`table_of` says.
    """
    with mpl.rc_context(STYLE):
        figure = draw()
        image = _image(figure, "png", PRINT, _PNG_METADATA)
        print_out = _image(figure, "pdf", PRINT, _PDF_METADATA)
    contents = (image, print_out, table_of(figure).encode())
    return dict(zip(files_of_figure(folder, name), contents, strict=True))


def _image(figure: Figure, kind: str, dpi: int, metadata: dict[str, Any]) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, dpi=dpi, metadata=metadata)
    return buffer.getvalue()
