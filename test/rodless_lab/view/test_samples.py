# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The ring of rows that pages are sent."""

import numpy as np
import pytest

from rodless_lab.view.frames import WINDOW
from rodless_lab.view.samples import SPACING, History, Mark


def times(rows: list[tuple[float | None, ...]]) -> list[float | None]:
    return [row[0] for row in rows]


def test_a_page_gets_each_row_once() -> None:
    """Whoever asks with the mark of the last answer gets what has come since, in order."""
    history = History()
    assert history.since(Mark()).anew
    for time in (0.1, 0.2):
        history.add((time, 1.0))
    anew, rows, mark = history.since(Mark())
    assert anew
    assert times(rows) == [0.1, 0.2]
    history.add((0.3, None))
    anew, rows, mark = history.since(mark)
    assert (anew, rows) == (False, [(0.3, None)])
    assert history.since(mark).rows == []


def test_a_repeated_sample_is_no_news() -> None:
    """A paused plant says the same over and over: the plots stand still with it."""
    history = History()
    assert history.add((0.1, 1.0))
    assert not history.add((0.1, 2.0))
    assert not history.add((None, 2.0))
    assert history.since(Mark()).rows == [(0.1, 1.0)]


def test_time_that_runs_backwards_begins_a_new_run() -> None:
    """After a reset pages drop what they have."""
    history = History()
    history.add((5.0, 1.0))
    mark = history.since(Mark()).end
    history.add((0.0, 2.0))
    assert history.since(mark) == (True, [(0.0, 2.0)], Mark(history.run, 1))


@pytest.mark.parametrize("speed", [0.1, 1.0, 3.0])
@pytest.mark.parametrize("at_once", [1, 7])
def test_plots_show_as_much_plant_time_at_any_speed(speed: float, at_once: int) -> None:
    """Looked up 40 times a second; a page that stays open has the rows of one that is opened.

    The newest row is always the last that came, and a page does with rows what rig_view.js does.
    """
    history, mark, page = History(), Mark(), []
    for k in range(round(30.0 / speed * 40.0)):
        history.add((k * speed / 40.0, float(k)))
        if k % at_once:
            continue
        anew, rows, mark = history.since(mark)
        page = [] if anew else page
        for row in rows:
            if len(page) > 1 and page[-1][0] - page[-2][0] < SPACING:
                page.pop()
            page.append(row)
        assert page[-1][1] == k
    opened = history.since(Mark()).rows
    assert opened[-1][0] - opened[0][0] > WINDOW
    apart = np.diff(times(opened[:-1]))
    assert SPACING <= apart.min() <= apart.max() < SPACING + max(speed / 40.0, 0.01)
    known = history.since(mark).rows
    assert page[-400:] == opened[: len(opened) - len(known)][-400:]


def test_the_oldest_rows_make_room_and_a_page_that_missed_them_begins_anew() -> None:
    """Memory is bounded; nobody is sent rows with a hole in them unawares."""
    history = History(length=3)
    history.add((0.0,))
    mark = history.since(Mark()).end
    for time in (1.0, 2.0, 3.0):
        history.add((time,))
    anew, rows, _ = history.since(mark)
    assert (anew, times(rows)) == (False, [1.0, 2.0, 3.0])
    history.add((4.0,))
    anew, rows, _ = history.since(mark)
    assert (anew, times(rows)) == (True, [2.0, 3.0, 4.0])
    history.clear()
    assert history.last is None
    assert history.since(mark).anew
