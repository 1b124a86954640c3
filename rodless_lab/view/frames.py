# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a page is sent: once how it is set up, then 20 times a second what is new; SI units."""

from typing import Any

from rodless_lab.view import words
from rodless_lab.view.samples import COLUMNS, SPACING, Mark, Row, spool_of
from rodless_lab.view.state import ViewState

# Frames a page gets per s: 20 at least, as timers are late by a millisecond or two.
RATE = 22.0

# What plots of a running rig show, in s.
WINDOW = 20.0


def setup(state: ViewState) -> dict[str, Any]:
    """Return what a page must know before its first frame."""
    playback = state.playback
    common = {
        "stroke": state.stroke,
        "atmosphere": state.atmosphere,
        "closed": state.closed_voltage,
        "first_term": len(COLUMNS),
    }
    if playback is None:
        live = {"window": WINDOW, "spacing": SPACING, "terms": list(state.terms)}
        return {**common, "mode": "live", **live}
    return {
        **common,
        # A bag says nothing of the cylinder: it is drawn as far as its run goes, at least.
        "stroke": max(state.stroke, *(tape.farthest for tape in playback.tapes)),
        "mode": "bag",
        "terms": [],
        "begin": playback.begin,
        "end": playback.end,
        "names": [tape.name for tape in playback.tapes],
        "tapes": [tape.rows() for tape in playback.tapes],
    }


def frame(state: ViewState, mark: Mark) -> tuple[dict[str, Any], Mark]:
    """Return what is new to a page that has the rows up to ``mark``, and its next mark."""
    playback = state.playback
    if playback is not None:
        when = playback.cursor
        now, *others = (tape.row_at(when) for tape in playback.tapes)
        return {
            "cursor": when,
            "row": now,
            "drawn": _drawn(now, words.is_lost(now), state.closed_voltage),
            "ghost": others[0][1] if others else None,
        }, Mark()
    anew, rows, end = state.history.since(mark)
    return {
        "anew": anew,
        "rows": rows,
        "drawn": _drawn_live(state, rows[-1]) if rows else None,
        "target": state.target,
        "locked": not state.takes_set_points,
    }, end


def _drawn_live(state: ViewState, row: Row) -> dict[str, Any]:
    """Return how the running rig is drawn, with the faults that it has."""
    flows = state.flows()
    parted = state.parameter("fault.carriage.decoupled") is True
    return {
        **_drawn(
            row,
            parted or words.is_lost(row, state.slip_distance),
            state.closed_voltage,
            seized=state.parameter("fault.carriage.seized") is True,
            stuck=state.parameter("fault.valve.spool") not in (None, "free"),
        ),
        "flows": flows and [round(flow, 3) for flow in flows],
    }


def _drawn(
    row: Row, lost: bool, closed: float, seized: bool = False, stuck: bool = False
) -> dict[str, Any]:
    """Return what is drawn beside the numbers of a row: where the spool is, and words."""
    return {
        "spool": spool_of(row),
        "lost": lost,
        "motion": words.motion(row, lost, seized),
        "valve": words.valve(row, closed, stuck),
        "flows": None,
    }
