# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A picture of one move: position, pressures and voltage against time."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from rodless_base.atomic_write import atomic_write
from rodless_lab.figures.files import png
from rodless_lab.figures.style import label, panels

Series = tuple[npt.ArrayLike, npt.ArrayLike]


def save_step_picture(
    path: Path,
    title: str,
    position: Series,
    reference: Series,
    pressures: dict[str, Series],
    voltage: Series,
) -> None:
    """Write a PNG to ``path``; every series is (time in s, values in SI)."""

    def draw() -> Figure:
        figure, (top, middle, bottom) = panels(3, height=1.9, share_x=True)
        figure.suptitle(title)
        wanted = np.asarray(reference[1]) * 1e3
        top.plot(reference[0], wanted, "k--", linewidth=0.8, label="set-point")
        top.plot(position[0], np.asarray(position[1]) * 1e3, color="tab:blue", label="carriage")
        for name, (time, values) in pressures.items():
            middle.plot(time, np.asarray(values) * 1e-6, label=name)
        bottom.plot(voltage[0], voltage[1], color="tab:red", linewidth=0.8, label="valve command")
        label(top, "", "position / mm")
        label(middle, "", "pressure, absolute / MPa")
        label(bottom, "plant time / s", "voltage / V")
        return figure

    atomic_write(path, png(draw))
