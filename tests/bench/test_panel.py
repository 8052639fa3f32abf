"""The panel: who may speak with it, what its buttons do, and what stops the hand."""

import http.client
import socket
import threading
import time
from itertools import pairwise
from urllib.parse import urlsplit

import pytest
from browser import browser, until
from drawn_model import drawn_model
from toy_machine import Lag

from hannes.bench.adapters.framed import Framed
from hannes.bench.adapters.text_lines import TextLines
from hannes.bench.board_file import read_board
from hannes.bench.board_logic import HOST_LENGTHS, Limits, Settings
from hannes.bench.events import About, Reply, Restarted, Row, Status
from hannes.bench.frames import Splitter
from hannes.bench.messages import Kind, Reason, SetPoint, State
from hannes.bench.misbehaviour import Misbehaviour
from hannes.bench.panel.drive import PATIENCE, SILENCE, Drive, Range
from hannes.bench.panel.run import Panel, Profiles, run_panel
from hannes.bench.panel.server import PanelServer
from hannes.bench.panel.traces import Traces
from hannes.bench.reader import Link
from hannes.bench.virtual_board import Terminal, VirtualBoard
from hannes.core.errors import BadInput
from hannes.recognition.known_hand import unknown_hand

pytest.importorskip("websockets", reason="the extra `panel`")


# ---- what the buttons do -------------------------------------------------------------


class Driven:
    """A drive whose bytes are read as the board would, at moments of the test's own."""

    def __init__(self) -> None:
        self._splitter, self.frames = Splitter(HOST_LENGTHS), []
        self.limit, self.checked, self.silent = None, True, False
        self.drive = Drive(
            Framed(), self._take, self._profile, Range(0.0, 9.84, 15.4), self._limited
        )
        self.drive.policy = False
        self.drive.channels(["reference", "position"])

    def _limited(self):
        return self.limit

    def _take(self, data) -> None:
        self.frames += self._splitter.feed(data)

    def _profile(self, name):
        if name != "known":
            raise BadInput("no such experiment")
        return [(0.0, 0.0), (0.5, 3.0)] if self.checked else None

    @property
    def kinds(self):
        return [Kind(each.kind) for each in self.frames]

    def set_points(self):
        return [SetPoint.unpack(f.payload).reference * 1e-6 for f in self.frames if f.kind == 6]

    def go(self, begin, end, state=None):
        for k in range(round((end - begin) / 0.005)):
            now = begin + 0.005 * k
            self.drive.ask({"do": "beat"}, now)
            if not self.silent:
                self.drive.see(Row(k, now, (0.0, 2.0)), now)
            if state is not None:
                self.drive.see(Status(now, state, 0, 0, 0), now)
            self.drive.go_on(now)


def test_closing_starts_where_the_hand_is_and_keeps_its_speed():
    panel = Driven()
    panel.drive.see(Row(1, 0.0, (0.0, 2.0)), 0.0)
    panel.drive.ask({"do": "close"}, 0.0)
    panel.go(0.0, 1.0)
    sent = panel.set_points()
    assert sent[0] == pytest.approx(2.0, abs=0.16) and sent[-1] == pytest.approx(9.84)
    assert max(b - a for a, b in pairwise(sent)) <= 15.4 * 0.02 + 1e-6
    panel.drive.ask({"do": "open"}, 1.0)
    panel.go(1.0, 2.0)
    assert panel.set_points()[-1] == 0.0


def test_a_silent_page_stops_the_hand():
    panel = Driven()
    panel.drive.ask({"do": "close"}, 0.0)
    panel.drive.go_on(SILENCE - 0.01)
    assert Kind.STOP not in panel.kinds
    panel.drive.go_on(SILENCE + 0.01)
    assert panel.kinds[-1] == Kind.STOP and "silent" in panel.drive.said
    panel.drive.go_on(SILENCE + 0.1)
    assert panel.kinds.count(Kind.STOP) == 1 and panel.kinds[-1] == Kind.STOP


def test_a_silent_board_is_stopped_and_named():
    panel = Driven()
    panel.drive.ask({"do": "close"}, 0.0)
    panel.go(0.0, 0.2, State.FOLLOWING)
    panel.silent = True
    panel.go(0.2, 0.2 + SILENCE - 0.02)
    assert Kind.STOP not in panel.kinds and panel.drive.doing
    panel.go(0.2 + SILENCE - 0.02, 0.2 + SILENCE + 0.3)
    assert "the board was silent" in panel.drive.said and not panel.drive.doing
    assert panel.kinds.count(Kind.STOP) > 2  # again and again: it was last seen to move
    assert panel.drive.state(2.0) == "silent"


def test_a_board_that_begins_anew_ends_what_is_done():
    panel = Driven()
    panel.drive.ask({"do": "close"}, 0.0)
    panel.go(0.0, 0.2, State.FOLLOWING)
    panel.drive.see(Restarted(0.0), 0.2)
    assert panel.drive.doing == "" and "began anew" in panel.drive.said
    panel.drive.ask({"do": "close"}, 0.3)
    panel.go(0.3, 0.6, State.FOLLOWING)
    assert panel.drive.doing == "closing"


def test_an_experiment_waits_for_its_simulation_and_a_stop_ends_the_waiting():
    panel = Driven()
    panel.checked = False
    for ends_in in ("stop", "start"):
        panel.drive.ask({"do": "experiment", "value": "known"}, 0.0)
        panel.go(0.0, 0.1)
        assert Kind.START not in panel.kinds and "against the limits" in panel.drive.said
        if ends_in == "stop":
            panel.drive.ask({"do": "stop"}, 0.1)
            panel.checked = True
            panel.go(0.1, 0.2)
            assert Kind.START not in panel.kinds
            panel.checked = False
    panel.checked = True
    panel.go(0.1, 0.2)
    assert Kind.START in panel.kinds and panel.drive.doing == "profile"


def test_an_experiment_beyond_the_limits_is_refused():
    with Profiles(Limits(current=0.01)) as profiles:
        with pytest.raises(BadInput, match=r"current reaches .* Nothing was sent"):
            while profiles("void-closure") is None:
                time.sleep(0.02)
        with pytest.raises(BadInput, match="no experiment"):
            profiles("/etc/passwd")


def test_the_policy_limits_until_it_is_switched_off_and_then_without_a_jump():
    panel = Driven()
    panel.limit = 5.0
    panel.drive.ask({"do": "policy", "value": True}, 0.0)
    panel.drive.ask({"do": "close"}, 0.0)
    panel.go(0.0, 1.0, State.FOLLOWING)
    assert max(panel.set_points()) == 5.0
    panel.drive.ask({"do": "policy", "value": False}, 1.0)
    panel.go(1.0, 2.0, State.FOLLOWING)
    sent = panel.set_points()
    assert sent[-1] == pytest.approx(9.84)
    assert max(b - a for a, b in pairwise(sent)) <= 15.4 * 0.02 + 1e-6
    panel.drive.ask({"do": "policy", "value": True}, 2.0)
    panel.drive.ask({"do": "experiment", "value": "known"}, 2.0)
    assert panel.drive.doing == "experiment"  # followed by set points, which the policy limits


def test_the_model_goes_on_beside_a_board_that_says_neither_state_nor_reference():
    drive = Drive(TextLines(), lambda data: None, lambda name: (), Range())
    assert drive.state(0.0) == "says no state"
    drive.ask({"do": "close"}, 0.0)
    assert drive.is_moving
    variant = read_board("void-closure").variant
    traces = Traces(variant.hand, variant.experiment, None)
    traces.see(About("text board", {"position": "rad", "current": "A"}, 0.0, 0.0), False, 0.0, 0.0)
    for k in range(600):
        traces.see(Row(k, 1e-3 * k, (0.0, 0.0)), drive.is_moving, 6.0, 6.0)
    model_position = [row[4] for row in traces.take()["rows"]]
    assert model_position[-1] > 3.0


def test_a_grasp_by_a_closed_hand_begins_where_it_is():
    variant = read_board("void-closure").variant
    traces = Traces(variant.hand, variant.experiment, drawn_model())
    units = {"reference": "rad", "position": "rad", "current": "A"}
    traces.see(About("x", units, 1000.0, 0.2), False, 0.0, 0.0)
    for k in range(20):
        traces.see(Row(k, 1e-3 * k, (0.0, 8.0, 0.0)), False, 0.0, 0.0)
    traces.begin()
    assert traces.set_point == 8.0
    traces.see(Row(20, 0.02, (8.0, 8.0, 0.0)), True, 9.0, 8.0)
    assert 8.0 < traces.set_point < 8.1


def test_samples_after_a_reset_are_drawn():
    variant = read_board("void-closure").variant
    traces = Traces(variant.hand, variant.experiment, drawn_model())
    units = {"reference": "rad", "position": "rad", "current": "A"}
    traces.see(About("x", units, 1000.0, 0.2), False, 0.0, 0.0)
    for k in range(3000, 3010):
        traces.see(Row(k, 1e-3 * k, (0.0, 0.0, 0.0)), False, 0.0, 0.0)
    traces.take()
    traces.see(Restarted(0.0), False, 0.0, 0.0)
    for k in range(10):
        traces.see(Row(k, 1e-3 * k, (0.0, 0.0, 0.0)), False, 0.0, 0.0)
    assert [row[0] for row in traces.take()["rows"]] == pytest.approx([0.004, 0.009], abs=2e-3)


@pytest.mark.parametrize("value", [-0.1, 9.9, float("nan"), "3", None, True, [1]])
def test_a_reference_out_of_range_is_refused(value):
    panel = Driven()
    panel.drive.ask({"do": "reference", "value": value}, 0.0)
    panel.go(0.0, 0.1)
    assert panel.frames == [] and "from 0 to 9.84 rad" in panel.drive.said


def test_an_experiment_is_sent_whole_and_ends_with_the_board():
    panel = Driven()
    panel.drive.ask({"do": "experiment", "value": "known"}, 0.0)
    assert panel.kinds == [Kind.PROFILE, Kind.POINTS, Kind.START]
    panel.go(0.0, 0.2, State.IDLE)  # said before the start reached the board
    assert panel.drive.doing == "profile"
    panel.go(0.2, 0.5, State.RUNNING)
    panel.go(0.5, 0.6, State.IDLE)
    assert panel.drive.doing == "" and panel.drive.said == ""
    panel.drive.ask({"do": "experiment", "value": "unknown"}, 1.0)
    assert panel.drive.said == "no such experiment" and panel.drive.doing == ""


def test_what_a_board_said_before_a_stop_does_not_end_what_comes_next():
    panel = Driven()
    panel.drive.ask({"do": "close"}, 0.0)
    panel.go(0.0, 0.3, State.FOLLOWING)
    panel.drive.ask({"do": "experiment", "value": "known"}, 0.3)
    panel.drive.see(Status(0.3, State.FOLLOWING, 0, 0, 0), 0.31)
    panel.drive.see(Status(0.3, State.STOPPED, 0, 0, 0), 0.32)
    assert panel.drive.doing == "profile"
    panel.drive.see(Reply(0.3, 1, Kind.STOP, Reason.DONE), 0.33)
    panel.drive.see(Status(0.4, State.RUNNING, 0, 0, 0), 0.4)
    panel.drive.see(Status(0.5, State.OVER_CURRENT, 0, 0, 0), 0.5)
    assert panel.drive.said == "the board stopped: over current"


def test_a_board_that_refuses_or_does_not_move_ends_it():
    panel = Driven()
    panel.drive.ask({"do": "experiment", "value": "known"}, 0.0)
    panel.drive.see(Reply(0.0, 3, Kind.START, Reason.BEYOND_LIMITS), 0.1)
    assert panel.drive.doing == "" and "beyond limits" in panel.drive.said
    still = Driven()
    still.drive.ask({"do": "close"}, 0.0)
    still.go(0.0, PATIENCE + 0.1, State.IDLE)
    assert still.kinds[-1] == Kind.STOP and "did not move" in still.drive.said


# ---- who may speak with it -----------------------------------------------------------


@pytest.fixture(scope="module")
def server():
    with PanelServer("<p>a page</p>", lambda: {"x": 1}) as running:
        yield running


def answer(server, path, **headers):
    """Status and text of a request."""
    connection = http.client.HTTPConnection(server.host, timeout=5.0)
    connection.request("GET", path, headers=headers)
    said = connection.getresponse()
    text = said.read().decode()
    connection.close()
    return said.status, text, said.headers


def token(server):
    return urlsplit(server.address).query


def shake(server, query, **headers):
    """Status of a handshake of a conversation."""
    asked = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
             "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}  # fmt: skip
    connection = http.client.HTTPConnection(server.host, timeout=5.0)
    connection.request("GET", f"/ws?{query}", headers=asked | headers)
    status = connection.getresponse().status
    connection.close()
    return status


def test_the_page_comes_with_its_token_alone(server):
    status, text, headers = answer(server, f"/?{token(server)}")
    assert (status, text) == (200, "<p>a page</p>")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
    for wrong in ("/", "/?token=", "/?token=x", f"/?{token(server)}x", "/?token=%ff"):
        assert answer(server, wrong)[0] == 403, wrong
    assert answer(server, f"/other?{token(server)}")[0] == 404


def test_another_name_of_this_machine_is_refused(server):
    for host in ("localhost:1", "evil.example", f"evil.example:{server.host.split(':')[1]}"):
        assert answer(server, f"/?{token(server)}", Host=host)[0] == 421


def test_a_request_of_another_page_is_refused(server):
    own = f"http://{server.host}"
    assert answer(server, f"/?{token(server)}", Origin=own)[0] == 200
    for other in ("http://evil.example", "null", own.replace("http", "https"), f"{own}.evil", ""):
        status, text, _ = answer(server, f"/?{token(server)}", Origin=other)
        assert status == 403 and "another page" in text, other


def test_a_conversation_needs_token_and_origin(server):
    own = f"http://{server.host}"
    assert shake(server, token(server), Origin=own) == 101
    assert shake(server, "token=wrong", Origin=own) == 403
    for other in ("http://evil.example", "null", own.replace("http", "https"), f"{own}.evil"):
        assert shake(server, token(server), Origin=other) == 403, other
    assert shake(server, token(server)) == 403  # no origin: no page of a browser


def test_another_address_does_not_reach_it(server):
    assert server.host.startswith("127.0.0.1:")
    port = int(server.host.split(":")[1])
    others = {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), None)}
    for address in {"127.0.0.2", *others} - {"127.0.0.1"}:
        with pytest.raises(OSError):
            socket.create_connection((address, port), timeout=2.0)


def test_a_port_that_is_taken_is_one_line(server):
    with pytest.raises(BadInput, match=r"cannot serve on 127\.0\.0\.1"):
        PanelServer("", dict, int(server.host.split(":")[1]))


def test_ctrl_c_ends_the_panel_in_words(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("hannes.bench.panel.run._loop", interrupted)
    monkeypatch.setattr("hannes.bench.panel.run._experiments", list)
    said, over, far = [], threading.Event(), Terminal()
    board = VirtualBoard(Lag, far, Settings(), Misbehaviour())
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    thread.start()
    try:
        run_panel(Panel(Link(far.address), read_board("void-closure").variant), said.append)
    finally:
        over.set()
        thread.join()
        far.close()
    assert said[-1] == "the panel has ended; the hand was stopped, as the board's telemetry shows"


# ---- in a browser --------------------------------------------------------------------


class Bench:
    """A virtual board and a panel on it, each in a thread; `logic` is the board's."""

    def __init__(self, model=None) -> None:
        self.far = Terminal()
        self.board = VirtualBoard(Lag, self.far, Settings(), Misbehaviour())
        self.over, self.gone, self.said = threading.Event(), threading.Event(), []
        panel = Panel(
            Link(self.far.address), read_board("void-closure").variant, model, policy=False
        )
        self.threads = [
            threading.Thread(target=self.board.run, args=(self.gone.is_set,)),
            threading.Thread(target=run_panel, args=(panel, self.said.append, self.over.is_set)),
        ]

    def __enter__(self):
        for each in self.threads:
            each.start()
        end = time.monotonic() + 120.0
        while not any(each.startswith("open ") for each in self.said):
            assert time.monotonic() < end and self.threads[1].is_alive()
            time.sleep(0.02)
        self.address = self.said[-1].removeprefix("open ")
        return self

    def __exit__(self, *_):
        """The panel first: it waits until the board is seen to stop."""
        for thread, ends in zip(reversed(self.threads), (self.over, self.gone), strict=True):
            ends.set()
            thread.join()
        self.far.close()

    def reaches(self, *states):
        """Wait until the board is in one of the states."""
        end = time.monotonic() + 20.0
        while self.board.logic.state not in states:
            assert time.monotonic() < end, self.board.logic.state
            time.sleep(0.01)


@pytest.fixture(scope="module")
def bench():
    with Bench(drawn_model()) as running:
        yield running


@pytest.fixture(scope="module")
def chromium():
    with browser() as running:
        yield running


@pytest.fixture
def page(bench, chromium):
    """The panel's page, and nothing amiss in it."""
    opened, messages = chromium.new_page(), []
    opened.on("console", lambda each: messages.append(each.text))
    opened.on("pageerror", lambda each: messages.append(str(each)))
    known = (f"http://{urlsplit(bench.address).netloc}", "data:")
    opened.on("request", lambda each: each.url.startswith(known) or messages.append(each.url))
    opened.goto(bench.address)
    until(opened, "document.body.dataset.board !== undefined")
    yield opened
    opened.close()
    assert messages == []
    bench.reaches(State.IDLE, State.STOPPED)


def test_close_open_stop_and_a_reference(bench, page):
    page.click("#close")
    bench.reaches(State.FOLLOWING)
    until(page, "data[2].length > 0 && data[2][data[2].length - 1] > 9.0")  # measured position
    until(page, "data[4][data[4].length - 1] > 5.0")  # the model beside it
    page.click("#open")
    until(page, "data[2][data[2].length - 1] < 1.0")
    page.fill("#reference", "4")
    page.click("#go")
    until(page, "Math.abs(data[2][data[2].length - 1] - 4) < 0.1")
    assert page.inner_text("#angle") == "4.00 rad"
    page.keyboard.press("Escape")
    bench.reaches(State.STOPPED)
    until(page, "document.body.dataset.state === 'still'")


def test_the_limit_on_the_grip_is_switched(bench, page):
    until(page, "!document.getElementById('policy').checked")
    page.check("#policy")
    page.click("#health")  # out of focus: the page shows what the panel does
    until(page, "document.getElementById('policy').checked")
    page.uncheck("#policy")
    page.click("#health")
    until(page, "!document.getElementById('policy').checked")


def test_a_hand_that_is_not_known_is_named_on_the_page_and_in_the_terminal(bench):
    address, notice = urlsplit(bench.address), unknown_hand(drawn_model())
    connection = http.client.HTTPConnection(address.netloc)
    connection.request("GET", f"{address.path}?{address.query}")
    page = connection.getresponse().read().decode()
    connection.close()
    assert page.count(notice) == 1 == bench.said.count(notice)


def test_an_experiment_runs_to_its_end(bench, page):
    page.select_option("#experiment", "dynamometer")
    page.click("#run")
    bench.reaches(State.RUNNING)
    until(page, "Math.max(...data[1]) > 9.5")
    until(page, "document.body.dataset.state === 'still'")
    page.click("#stop")


def test_a_page_that_freezes_stops_the_hand(bench, page):
    page.click("#close")
    bench.reaches(State.FOLLOWING)
    page.evaluate("() => { const began = Date.now(); while (Date.now() - began < 2500); }")
    assert bench.board.logic.state is State.STOPPED
    until(page, "document.getElementById('health').textContent.includes('silent')")


def test_a_page_that_is_closed_stops_the_hand(bench, page, chromium):
    page.click("#close")
    bench.reaches(State.FOLLOWING)
    page.goto("about:blank")
    bench.reaches(State.STOPPED)


def test_a_second_page_is_turned_away(bench, page, chromium):
    second = chromium.new_page()
    second.goto(bench.address)
    until(second, "document.getElementById('health').textContent.includes('another page')")
    assert second.is_disabled("#close")
    second.close()
    until(page, "document.body.dataset.state === 'still'")
