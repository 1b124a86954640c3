# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One page of the docs per experiment, with its pictures, written from what the code gives."""

from pathlib import Path

from rodless_base.atomic_write import make_folder, write_together
from rodless_lab.experiments.experiment import Experiment
from rodless_lab.experiments.result import Result
from rodless_lab.figures.files import png
from rodless_lab.reports.table import markdown_table


def page(experiment: Experiment, result: Result) -> str:
    """Return the page in Markdown; pictures stand beside it."""
    pictures = [f"![{shown.caption}]({shown.name}.png)" for shown in result.pictures]
    captions = [f"*{shown.caption}.*" for shown in result.pictures]
    shown = [line for pair in zip(pictures, captions, strict=True) for line in pair]
    parts = [
        f"# {experiment.title}",
        f"Zhang et al., *Actuators* 2022, 11(2), 50: {experiment.source}.",
        experiment.summary,
        f"```sh\nrodless experiment {experiment.name}\n```",
        *over_ros(experiment),
        *shown,
        markdown_table(result.comparisons),
        "\n".join(f"- {remark}" for remark in result.remarks),
        "This page is written by `rodless docs`; pressures named 0.4 to 0.6 MPa are gauge.",
    ]
    return "\n\n".join(parts) + "\n"


def over_ros(experiment: Experiment) -> tuple[str, ...]:
    """Say that the nodes can do it too, where there is a rig to drive."""
    if not experiment.moves:
        return ()
    return (
        "With `--ros` the running nodes do the same over topics, in lock-step, each run in a ROS "
        "domain of its own; every number is the same.",
    )


def write_page(folder: Path, experiment: Experiment, result: Result) -> None:
    """Write the page and its pictures into ``folder``."""
    make_folder(folder)
    pictures = {folder / f"{one.name}.png": png(one.draw) for one in result.pictures}
    write_together({**pictures, folder / f"{experiment.name}.md": page(experiment, result)})
