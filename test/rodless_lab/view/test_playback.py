# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags as pages play them."""

from pathlib import Path

import numpy as np
import pytest
import rig_bag
from extent import extensive

from rodless_control import PidParameters, references
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_lab.session.session import RigSession
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_lab.view import frames
from rodless_lab.view.errors import ViewError
from rodless_lab.view.playback import MOST_ROWS, Playback, Tape, open_tape, rig_namespace
from rodless_lab.view.samples import COLUMNS
from rodless_lab.view.state import ViewState
from rodless_sim import RigParameters

PERIOD = 1e-3


def run(count: int = 4000, speed: float = 0.02) -> MeasuredRun:
    """A carriage at a constant speed (m/s)."""
    time = PERIOD * np.arange(count)
    still = np.full(count, 4e5)
    return MeasuredRun(time, speed * time, still, still + 1e4, still + 2e5, np.full(count, 5.5))


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two bags: the second twice as fast, its set-point 0.2 s later."""
    folder = tmp_path_factory.mktemp("bags")
    rig_bag.write(folder / "slow", run(), setpoint=(0.3, 0.05))
    rig_bag.write(folder / "fast", run(speed=0.04), setpoint=(0.5, 0.05))
    return folder


class Clock:
    """Wall-clock s, as a test sets it."""

    now = 100.0

    def __call__(self) -> float:
        """Return them."""
        return self.now


def test_a_bag_becomes_rows(bags: Path) -> None:
    """Few enough for a page, all columns at their times, in SI; the set-points as reference."""
    tape = open_tape(bags / "slow")
    rows = tape.rows()
    assert MOST_ROWS / 2 <= len(rows) <= MOST_ROWS
    time, position, velocity, a, b, supply, voltage, reference, *others = tape.row_at(2.0)
    assert (time, position) == pytest.approx((2.0, 0.04))
    assert velocity == pytest.approx(0.02)
    assert (a, b, supply, voltage) == pytest.approx((4e5, 4.1e5, 6e5, 5.5))
    assert reference == 0.05
    assert others == [None, None, None]  # where spool and piston are is not in this bag
    assert tape.row_at(0.1)[7] is None
    assert tape.row_at(-1.0) == tape.row_at(0.0)
    assert tape.row_at(99.0)[0] == pytest.approx(3.999)


@extensive
@pytest.mark.ros
@pytest.mark.slow
def test_a_bag_of_a_magnetic_rig_has_its_piston(tmp_path: Path) -> None:
    """Carriage and piston apart by the lag of the magnets, and the spool, as the run had them."""
    magnets = {"coupling.kind": "magnetic"}
    step = {"reference.type": "step", "reference.at": 0.05}
    with RigSession(
        "lockstep",
        plant=magnets,
        controller=step,
        duration=0.5,
        bag=tmp_path / "bag",
        timeout=240.0,
    ) as rig:
        rig.run()
    expected = closed_loop(
        RigParameters(magnets), PidParameters(), references.step(0.0, 0.058, 0.05), 0.5, PERIOD
    )
    tape = open_tape(tmp_path / "bag")
    for k in (0, 120, 300, 500):
        row = dict(zip(COLUMNS, tape.row_at(expected.time[k] + 1e-6), strict=True))
        assert row["position"] == pytest.approx(expected.true_position[k], abs=1e-12)
        assert row["piston_position"] == expected.piston_position[k]
        assert row["piston_velocity"] == expected.piston_velocity[k]
        assert row["voltage"] == row["spool"]
    apart = tape.columns[list(COLUMNS).index("piston_position")] - tape.run.position
    assert 1e-5 < np.abs(apart).max() < 3e-3


def test_the_cursor_follows_the_clock_at_the_speed_chosen(bags: Path) -> None:
    """Play, stop, another speed, a jump, the end, and from there again from the beginning."""
    clock = Clock()
    playback = Playback([open_tape(bags / "slow")], clock)
    assert (playback.cursor, playback.playing) == (0.0, False)
    playback.play(True)
    clock.now += 1.5
    assert playback.cursor == pytest.approx(1.5)
    playback.set_speed(0.5)
    clock.now += 1.0
    assert playback.cursor == pytest.approx(2.0)
    playback.play(False)
    clock.now += 1.0
    assert playback.cursor == pytest.approx(2.0)
    playback.seek(3.5)
    playback.play(True)
    clock.now += 10.0
    assert playback.cursor == pytest.approx(3.999)
    assert not playback.playing
    playback.play(True)
    assert playback.cursor == 0.0
    playback.seek(-5.0)
    assert playback.cursor == 0.0
    with pytest.raises(ViewError, match="speed: 3 refused"):
        playback.set_speed(3.0)


def test_a_bag_that_has_ended_plays_on_only_where_it_is_asked_to(bags: Path) -> None:
    """Put back it stands, at another speed too, as its button says: Play."""
    clock = Clock()
    playback = Playback([open_tape(bags / "slow")], clock)
    playback.play(True)
    clock.now += 10.0
    assert not playback.playing
    playback.set_speed(2.0)
    playback.seek(1.0)
    clock.now += 1.0
    assert (playback.playing, playback.cursor) == (False, 1.0)
    playback.play(True)
    playback.seek(2.0)
    clock.now += 0.5
    assert playback.playing  # what plays goes on playing
    assert playback.cursor == pytest.approx(3.0)


def test_a_bag_of_a_longer_cylinder_is_drawn_as_long_as_it_goes(bags: Path) -> None:
    """0.5 m/s for 1 s, beside a short run; without a rig the cylinder is the paper's, or longer."""
    short, long = open_tape(bags / "slow"), Tape("long", run(), None, np.zeros((len(COLUMNS), 2)))
    assert short.farthest == pytest.approx(0.02 * 3.999)
    long.columns[list(COLUMNS).index("position")] = 0.0, 0.48
    long.columns[list(COLUMNS).index("piston_position")] = np.nan, 0.5
    state = ViewState(live=False)
    for tapes, stroke in (([short], 0.2), ([long], 0.5), ([short, long], 0.5)):
        state.playback = Playback(tapes)
        assert frames.setup(state)["stroke"] == stroke


def test_two_bags_stand_on_one_time_and_say_how_far_they_are_apart(bags: Path) -> None:
    """By their set-points; the distance is worked out by hand."""
    playback = Playback([open_tape(bags / name) for name in ("slow", "fast")])
    slow, _ = playback.tapes
    # The first is moved by 0.2 s, so that both set-points are at 0.5 s.
    assert slow.begin == pytest.approx(0.2)
    assert slow.row_at(1.2)[1] == pytest.approx(0.02)
    assert (playback.begin, playback.end) == pytest.approx((0.0, 4.199))
    apart = {one.label: one for one in playback.apart}
    # At 3.999 s, the last that both have: 40 mm/s · 3.999 s - 20 mm/s · 3.799 s.
    assert apart["position"].largest == pytest.approx(40.0 * 3.999 - 20.0 * 3.799, abs=0.05)
    assert apart["position"].unit == "mm"
    assert apart["valve voltage"].largest == 0.0


def test_samples_that_a_recorder_lost_are_told(bags: Path, tmp_path: Path) -> None:
    """How many, from when on and of which bag, also where the other of two is whole."""
    rig_bag.write(
        tmp_path / "gaps",
        run(),
        lambda topic, k, *message: None if topic == "/joint_states" and k == 1500 else message,
    )
    whole = open_tape(bags / "slow")
    assert Playback([whole]).notes == ()
    (note,) = Playback([whole, open_tape(tmp_path / "gaps")]).notes
    assert note.startswith(
        f"{tmp_path / 'gaps'}: samples are missing, from 1.499 s on: 1 of 4000 of /joint_states"
    )


def test_a_reference_of_arrays_is_refused(tmp_path: Path) -> None:
    """As `replay` does: which of its numbers it should be is not known."""
    own = run(100)
    numbers = [[0.01, 0.02]] * len(own.time)
    bag = rig_bag.with_arrays(tmp_path, own, "/controller/reference", numbers)
    with pytest.raises(ViewError, match=r"^bag: /controller/reference: .* has no data of one"):
        open_tape(bag)


def test_what_is_sent_for_views_alone_makes_no_second_rig(bags: Path) -> None:
    """As `ros2 bag record --include-hidden-topics` has it; several rigs are named."""

    class Topics(dict[str, object]):
        path = bags

    own, thinned, other = (f"/{place}joint_states" for place in ("", "_throttled/", "left/"))
    assert rig_namespace(Topics.fromkeys([own, thinned])) == ""  # type: ignore[arg-type]
    assert rig_namespace(Topics.fromkeys([other])) == "/left"  # type: ignore[arg-type]
    with pytest.raises(ViewError, match=r"holds joint_states of /, /left; one rig can be played$"):
        rig_namespace(Topics.fromkeys([own, thinned, other]))  # type: ignore[arg-type]


def test_what_is_no_bag_of_a_rig_is_refused_in_words(tmp_path: Path) -> None:
    """The name, and what is missing."""
    with pytest.raises(ViewError, match="nothing"):
        open_tape(tmp_path / "nothing")
    rig_bag.write(tmp_path / "half", run(100), without="/supply/pressure")
    with pytest.raises(ViewError, match="supply/pressure"):
        open_tape(tmp_path / "half")
    rig_bag.write(tmp_path / "no-rig", run(100), without="/joint_states")
    with pytest.raises(ViewError, match="joint_states"):
        open_tape(tmp_path / "no-rig")
