# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The page in a real browser, headless, on a rig of two nodes; one of each for the whole module.

The browser is whichever Chromium the machine has; playwright brings the hand that uses it.
"""

import http.client
import json
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import numpy as np
import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page
    from running import StartProcess, StartRig

    from rodless_lab.session.node_process import NodeProcess
    from rodless_lab.session.observer import Observer
    from rodless_lab.session.processes import SessionProcesses

pytestmark = [pytest.mark.ros, pytest.mark.slow]

# Machines are crowded: for whatever must come, in wall-clock s.
TIMEOUT = 180.0

# A fifth of the usual work for the nodes.
PERIOD = 0.005

# The node of `rodless record`.
RECORDER = "recorder"

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def browser() -> "Iterator[Browser]":
    """Start the machine's Chromium; without one these tests have nothing to run in."""
    api = pytest.importorskip("playwright.sync_api", reason="no playwright: make test-tools")
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    with api.sync_playwright() as play:
        # Its sandbox wants rights that a container, or root, does not have.
        options = ["--no-sandbox", "--disable-dev-shm-usage"]
        running = play.chromium.launch(executable_path=program, args=options)
        yield running
        running.close()


@pytest.fixture(scope="module")
def rig(start_rig: "StartRig") -> "Iterator[SessionProcesses]":
    """Run plant and controller."""
    with start_rig(plant={"time.period": PERIOD}) as processes:
        yield processes


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return where the view keeps its bags."""
    return tmp_path_factory.mktemp("bags")


@pytest.fixture(scope="module")
def view(rodless: "StartProcess", rig: "SessionProcesses", folder: Path) -> "Iterator[NodeProcess]":
    """Run `rodless view` on the rig; it has to end well."""
    del rig
    with rodless("view", "--port", "0", "--folder", str(folder)) as process:
        yield process
        process.ask_to_stop()
        assert process.wait(TIMEOUT) == 0
        assert "Traceback" not in process.output


@pytest.fixture(scope="module")
def address(view: "NodeProcess", observer: "Observer") -> str:
    """Return where the pages are."""

    def said() -> "re.Match[str] | None":
        return re.search(r"open (http://\S+) in a browser", view.output)

    found = observer.wait(said, "the view to say where it is", TIMEOUT)
    assert found is not None
    return found[1]


class Tab:
    """A page, and what is looked for on it."""

    def __init__(self, page: "Page", address: str) -> None:
        self.page = page
        self.errors: list[str] = []
        self.strangers: list[str] = []
        page.set_default_timeout(TIMEOUT * 1e3)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self._note(request.url, address))
        page.goto(address)
        self.wait("() => document.querySelector('.carried text')?.textContent.endsWith('mm')")

    def _note(self, url: str, address: str) -> None:
        if urlsplit(url).netloc not in ("", urlsplit(address).netloc):
            self.strangers.append(url)

    def wait(self, script: str, argument: object = None) -> None:
        """Wait until a script on the page is true."""
        self.page.wait_for_function(script, arg=argument, timeout=TIMEOUT * 1e3)

    def text(self, name: str) -> str:
        """Return what an element shows."""
        return str(self.page.get_by_test_id(name).inner_text())

    def wait_text(self, name: str, pattern: str) -> None:
        """Wait until an element shows something."""
        self.wait(
            "([name, pattern]) => new RegExp(pattern).test("
            "document.querySelector(`[data-testid='${name}']`)?.innerText ?? '')",
            [name, pattern],
        )

    def wait_position(self, low: float, high: float) -> None:
        """Wait until the carriage is drawn between two positions in mm."""
        self.wait(
            "([low, high]) => { const at = parseFloat(document.querySelector('.carried text')"
            ".textContent); return at >= low && at <= high; }",
            [low, high],
        )

    def click(self, name: str) -> None:
        """Click a button."""
        self.page.get_by_test_id(name).click()

    def fill(self, name: str, text: str) -> None:
        """Write into a field and press Enter."""
        field = self.page.get_by_test_id(name)
        field.fill(text)
        field.press("Enter")

    def choose(self, name: str, option: str) -> None:
        """Choose from a list."""
        self.page.locator(".q-select", has=self.page.get_by_test_id(name)).click()
        self.page.locator(".q-menu .q-item").get_by_text(option, exact=True).click()

    def open(self, panel: str) -> None:
        """Open a panel that is closed."""
        header = self.page.locator(".q-expansion-item", has_text=panel).first
        if header.get_attribute("class").find("q-expansion-item--expanded") < 0:
            header.locator(".q-item").first.click()

    def drag_target(self, position: float, steps: int = 20, release: bool = True) -> None:
        """Drag the target to a position in mm, in some steps."""
        mouse = self.page.mouse
        box = self.page.locator(".target .pointer").bounding_box()
        assert box is not None
        y = box["y"] + box["height"] / 2.0
        mouse.move(box["x"] + box["width"] / 2.0, y)
        mouse.down()
        mouse.move(self._x(position), y, steps=steps)
        if release:
            mouse.up()

    def _x(self, position: float) -> float:
        return float(
            self.page.evaluate(
                "mm => { const svg = document.querySelector('svg.scene');"
                " const ticks = [...svg.querySelectorAll('.ruler line')];"
                " const ends = ['x1', 'x2'].map(k => Number(ticks[0].getAttribute(k)));"
                " const x = ends[0] + mm / 200 * (ends[1] - ends[0]);"
                " return new DOMPoint(x, 0).matrixTransform(svg.getScreenCTM()).x; }",
                position,
            )
        )


@pytest.fixture(scope="module")
def open_tab(browser: "Browser", address: str) -> Callable[[], Any]:
    """Return a context manager that opens a page."""

    @contextmanager
    def opened() -> Iterator[Tab]:
        context = browser.new_context(viewport={"width": 1600, "height": 900})
        try:
            yield Tab(context.new_page(), address)
        finally:
            context.close()

    return opened


@pytest.fixture(scope="module")
def tab(open_tab: Callable[[], Any]) -> Iterator[Tab]:
    """Open the page that most tests use."""
    with open_tab() as tab:
        tab.wait_text("state-plant", "plant: (running|waiting|plant time|in the last)")
        tab.wait_text("state-controller", "controller: (controlling|in the last|machine)")
        yield tab


def wait_standing(observer: "Observer", samples: list[Any], clocks: list[Any]) -> None:
    """Wait until plant time stands still and its last sample has come."""

    def stands() -> bool:
        # A plant repeats its time only while it is paused.
        return (
            len(clocks) > 1
            and clocks[-1].clock == clocks[-2].clock
            and samples[-1].header.stamp == clocks[-1].clock
        )

    observer.wait(stands, "plant time to stand still", TIMEOUT)


def wait_paused(observer: "Observer", paused: str) -> None:
    """Wait until the plant says that it is, or is not, paused."""

    def says() -> bool:
        said = observer.diagnostics.get("/plant")
        return said is not None and said.values["paused"] == paused

    observer.wait(says, f"paused: {paused}", TIMEOUT)


def test_the_page_shows_the_rig_and_loads_nothing_from_elsewhere(tab: Tab) -> None:
    """Drawing, four plots, fields with the nodes' values; a lecture room may have no network."""
    # The terms of the law, of which one is, come with their publishers.
    tab.wait("() => document.querySelectorAll('canvas').length === 4")
    tab.wait("() => document.querySelector('.pa').textContent.endsWith(' kPa')")
    tab.wait("() => document.querySelector('.in').textContent.endsWith('L/min')")
    tab.page.get_by_test_id("controller.kp").wait_for()
    assert tab.page.get_by_test_id("controller.kp").input_value() == "800"
    assert tab.strangers == []
    assert tab.errors == []


def test_the_carriage_follows_the_target_that_is_dragged(tab: Tab, observer: "Observer") -> None:
    """Set-points go out on the way, the last where it is let go; the rig moves there."""
    from std_msgs.msg import Float64  # noqa: PLC0415

    heard = observer.collect(Float64, "/setpoint")
    tab.drag_target(58.0)
    observer.wait(lambda: heard and abs(heard[-1].data - 0.058) < 5e-4, "the last set-point")
    assert len(heard) > 1
    tab.wait_position(57.0, 59.0)
    # By keys, too: ten steps of a millimetre back.
    tab.page.locator(".target").press("Shift+ArrowLeft")
    tab.wait_position(47.0, 49.0)
    # A zero has no sign, whatever rounds to it.
    observer.publisher(Float64, "/setpoint", 2).publish(Float64(data=-1e-6))
    tab.wait("() => document.querySelector('.target text').textContent === 'target 0.0 mm'")


def test_a_pause_stops_time_and_a_step_advances_it_by_one_period(
    tab: Tab, observer: "Observer"
) -> None:
    """By button and by key; the node says so, and sends one sample."""
    from rosgraph_msgs.msg import Clock  # noqa: PLC0415
    from sensor_msgs.msg import JointState  # noqa: PLC0415

    # Before the pause: a plant that stands still would not say when it has found its listener.
    samples = observer.collect(JointState, "/joint_states")
    clocks = observer.collect(Clock, "/clock")
    observer.wait(lambda: samples and clocks, "a sample", TIMEOUT)
    tab.click("pause")
    tab.wait_text("pause", "Resume")
    wait_paused(observer, "True")
    wait_standing(observer, samples, clocks)
    before = len(samples)
    tab.click("step-1")
    observer.wait(lambda: len(samples) > before, "one sample", TIMEOUT)
    tab.click("step-10")
    observer.wait(lambda: len(samples) > before + 10, "ten samples more", TIMEOUT)
    wait_standing(observer, samples, clocks)
    stamps = [one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec for one in samples]
    assert np.diff(stamps[before - 1 :]) == pytest.approx([PERIOD] * 11)
    tab.page.keyboard.press("Space")
    tab.wait_text("pause", "Pause")
    wait_paused(observer, "False")


def test_gains_that_are_changed_are_the_nodes(tab: Tab, observer: "Observer") -> None:
    """In the node as on the page, whoever changes them; what is refused changes nothing."""

    def gain() -> object:
        return observer.get_parameters("controller", ["controller.kp"])["controller.kp"]

    tab.fill("controller.kp", "500")
    observer.wait(lambda: gain() == 500.0, "the gain to arrive", TIMEOUT)
    observer.set_parameters("controller", {"controller.kp": 650.0})
    field = "() => document.querySelector('[data-testid=\"controller.kp\"]').value"
    tab.wait(f"{field} === '650'")
    tab.fill("controller.kp", "-5")
    tab.page.get_by_text("controller.kp: -5.0 refused").first.wait_for()
    tab.wait(f"{field} === '650'")
    assert gain() == 650.0


def test_another_law_is_chosen_and_has_its_own_gains(tab: Tab, observer: "Observer") -> None:
    """The node has it, its fields come and those of the PID go; and back again."""

    def law() -> object:
        return observer.get_parameters("controller", ["controller.law"])["controller.law"]

    tab.choose("controller.law", "adrc")
    observer.wait(lambda: law() == "adrc", "the law", TIMEOUT)
    tab.page.get_by_test_id("adrc.bandwidth").wait_for()
    tab.page.get_by_test_id("controller.kp").wait_for(state="hidden")
    tab.fill("set-point", "90")
    tab.wait_position(89.0, 91.0)
    tab.choose("controller.law", "PID")
    observer.wait(lambda: law() == "pid", "the law", TIMEOUT)
    tab.page.get_by_test_id("controller.kp").wait_for()
    assert tab.errors == []


def test_a_fault_is_chosen_from_a_list(tab: Tab, observer: "Observer") -> None:
    """The plant has it, and is rid of it again."""

    def spool() -> object:
        return observer.get_parameters("plant", ["fault.valve.spool"])["fault.valve.spool"]

    tab.open("Faults")
    tab.choose("fault.valve.spool", "stuck where it is")
    observer.wait(lambda: spool() == "stuck", "the fault", TIMEOUT)
    tab.choose("fault.valve.spool", "free")
    observer.wait(lambda: spool() == "free", "the end of the fault", TIMEOUT)


def test_the_supply_can_be_cut(tab: Tab, observer: "Observer") -> None:
    """The instruments read the atmosphere's pressure then, and afterwards the one before."""
    from sensor_msgs.msg import FluidPressure  # noqa: PLC0415

    before = observer.get_parameters("plant", ["supply.pressure"])["supply.pressure"]
    readings = observer.collect(FluidPressure, "/supply/pressure")
    try:
        tab.click("supply")
        tab.wait_text("supply", "Restore")
        observer.wait(lambda: readings[-1:] and readings[-1].fluid_pressure < 1.1e5, "the cut")
        tab.click("supply")
        tab.wait_text("supply", "Cut")
        observer.wait(lambda: readings[-1].fluid_pressure == before, "the supply to be back")
    finally:
        # A further try, or another test, finds the supply as it was.
        observer.set_parameters("plant", {"supply.pressure": before})


def test_the_colours_begin_at_the_atmosphere_of_the_rig(tab: Tab, observer: "Observer") -> None:
    """Their lower end is written beside them, in kPa, and goes with the parameter."""
    shows = "low => document.querySelector('svg.scene .low').textContent === low"
    before = observer.get_parameters("plant", ["atmosphere.pressure"])["atmosphere.pressure"]
    tab.wait(shows, "101")
    try:
        observer.set_parameters("plant", {"atmosphere.pressure": 9e4})
        tab.wait(shows, "90")
    finally:
        observer.set_parameters("plant", {"atmosphere.pressure": before})


def listeners(observer: "Observer", topic: str) -> set[str]:
    """Return the names of the nodes that listen to a topic."""
    return {one.node_name for one in observer.node.get_subscriptions_info_by_topic(topic)}


def test_a_bag_is_recorded_and_played_back(tab: Tab, folder: Path, observer: "Observer") -> None:
    """A move into a bag, the bag on the page: played, scrubbed, and back to the rig."""
    tab.click("record")
    tab.wait_text("record", "Stop")
    name = tab.text("record").removeprefix("Stop ")
    topic = "/joint_states"
    observer.wait(lambda: RECORDER in listeners(observer, topic), "the recorder", TIMEOUT)
    tab.fill("set-point", "80")
    tab.wait_position(79.0, 81.0)
    tab.fill("set-point", "40")
    tab.wait_position(39.0, 41.0)
    tab.click("record")
    tab.page.get_by_text("messages in").first.wait_for()
    assert (folder / name / "metadata.yaml").is_file()
    tab.open("Bags")
    tab.page.locator(".q-select", has_text="One bag").click()
    tab.page.locator(".q-menu .q-item", has_text=name).click()
    tab.page.keyboard.press("Escape")
    tab.click("open")
    tab.wait_text("cursor", "^0.00 of")
    tab.click("play")
    tab.wait_text("cursor", "^[1-9]")
    tab.click("play")
    tab.wait_text("play", "Play")
    track = tab.page.get_by_test_id("scrub").bounding_box()
    assert track is not None
    tab.page.mouse.click(track["x"] + track["width"] - 2.0, track["y"] + track["height"] / 2.0)
    tab.wait(
        "() => { const [now, , end] = document.querySelector('[data-testid=cursor]').innerText"
        ".split(' ').map(parseFloat); return now > 0.9 * end; }"
    )
    tab.wait_position(38.0, 42.0)
    tab.click("live")
    tab.page.get_by_test_id("pause").wait_for()


def test_pages_agree_and_one_that_closes_stops_nothing(
    tab: Tab, open_tab: Callable[[], Any], observer: "Observer"
) -> None:
    """The state is the view's; a page that goes in the middle of a move leaves the rig to it."""
    with open_tab() as other:
        other.click("pause")
        tab.wait_text("pause", "Resume")
        tab.click("pause")
        other.wait_text("pause", "Pause")
        other.fill("controller.kd", "55")
        field = "() => document.querySelector('[data-testid=\"controller.kd\"]').value"
        tab.wait(f"{field} === '55'")
        other.drag_target(150.0, release=False)
        tab.wait("() => document.querySelector('.target text').textContent.includes('150')")
    tab.wait_position(149.0, 151.0)
    assert tab.errors == []
    assert observer.get_parameters("controller", ["controller.kd"])["controller.kd"] == 55.0


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {"Host": "rebound.example"}),
        ("/", {"Origin": "http://elsewhere.example"}),
        ("/_nicegui_ws/socket.io/?EIO=4&transport=polling", {"Origin": "http://a.example"}),
        (
            "/_nicegui_ws/socket.io/?EIO=4&transport=websocket",
            {
                "Origin": "http://a.example",
                "Connection": "Upgrade",
                "Upgrade": "websocket",
                "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
            },
        ),
    ],
    ids=["another name", "a foreign page", "its polling", "its socket"],
)
def test_foreign_pages_are_not_answered(address: str, path: str, headers: dict[str, str]) -> None:
    """The running server refuses them, sockets too."""
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname or "", place.port, timeout=TIMEOUT)
    own = {"Host": place.netloc}
    connection.request("GET", path, headers={**own, **headers})
    assert connection.getresponse().status == 403
    connection.close()
    connection.request("GET", path.replace("websocket", "polling"), headers=own)
    assert connection.getresponse().status == 200
    connection.close()


def test_a_node_that_is_killed_is_missed_and_welcome_back(
    tab: Tab, rig: "SessionProcesses"
) -> None:
    """The page says so in words, goes on, and shows the rig again once it is there."""
    rig["plant"].kill()
    tab.wait_text("state-plant", "silent")
    rig["plant"].start()
    tab.wait_text("state-plant", "plant: (running|waiting|plant time|in the last|2 nodes)")
    tab.wait("() => parseFloat(document.querySelector('[data-testid=time]').innerText) > 0.5")
    assert tab.errors == []


def test_a_lost_carriage_is_drawn_apart_from_its_piston(tab: Tab) -> None:
    """Each where it is, joined by a line, with a word on the piston and another outline."""
    shown = tab.page.evaluate(
        "() => { const svg = document.querySelector('svg.scene');"
        " const view = getElement(document.querySelector('.rig-view').id.slice(1));"
        " const row = [9, 0.05, 0, 3e5, 4e5, 6e5, 5, null, 6, 0.15, 0.1];"
        " const at = name => new DOMMatrix(getComputedStyle(svg.querySelector(name)).transform).e;"
        " const display = () => getComputedStyle(svg.querySelector('.alone')).display;"
        " const drawn = { spool: 6, motion: 'moves', valve: 'opens', flows: null };"
        " view.scene.update(row, { ...drawn, lost: false }); const before = display();"
        " view.scene.update(row, { ...drawn, lost: true });"
        " return [before, display(), at('.carried'), at('.moving'), view.scene.x(0.05),"
        " view.scene.x(0.15), svg.querySelector('.motion').textContent]; }"
    )
    before, lost, carriage, piston, *expected, motion = shown
    assert (before, motion) == ("none", "moves")
    assert lost != "none"
    assert [carriage, piston] == pytest.approx(expected, abs=0.01)
    assert piston - carriage > 100.0
    assert tab.errors == []


def test_the_frames_are_small(tab: Tab) -> None:
    """What a page is sent 20 times a second: a few rows of numbers."""
    element = "getElement(document.querySelector('.rig-view').id.slice(1))"
    tab.wait(f"() => {element}.rows.length > 5")
    rows = tab.page.evaluate(f"() => {element}.rows.slice(-5)")
    assert all(len(row) == 15 for row in rows)
    assert len(json.dumps(rows[0])) < 400
