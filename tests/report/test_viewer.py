"""The page of `hannes view`: its geometry, its numbers, and how it answers in a real browser."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import browser, opened, until

from hannes import Hand, Recording, load_experiment, observe, simulate
from hannes.commands.view import view
from hannes.core.errors import BadInput
from hannes.report.viewer.packing import exact, unpacked, whole
from hannes.report.viewer.replay import replay
from hannes.simulation.hand.hand_file import hand_toml

FINGERS = ("index", "middle", "ring", "little", "thumb")
TENTH = 1e-4  # m: 0.1 mm


@pytest.fixture(scope="module")
def ran():
    """Trajectories of a grasp and of a free closure, with their hands."""
    asked = [load_experiment(name)[0] for name in ("dynamometer", "void-closure")]
    return {
        name: (each.hand, simulate(each.hand, each.experiment))
        for name, each in zip(("grasp", "void"), asked, strict=True)
    }


@pytest.fixture(scope="module")
def folder(ran, tmp_path_factory):
    """Their recordings, one without what it was simulated from, and the page of two."""
    place = tmp_path_factory.mktemp("view")
    for name, (hand, trajectory) in ran.items():
        observe(hand, trajectory).to_hdf5(place / f"{name}.h5")
    grasp = Recording.read(place / "void.h5")
    grasp.to_csv(place / "bare.csv")
    view([place / "grasp.h5", place / "void.h5"], place / "both.html")
    return place


def data(path):
    """What the page carries, as it stands there."""
    text = path.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    return json.loads(found[1])


@pytest.mark.parametrize(("number", "name"), [(0, "grasp"), (1, "void")])
def test_fingers_are_where_the_angles_put_them(ran, folder, number, name):
    """Independent: complex numbers, from the states and the phalanges' lengths alone."""
    hand, trajectory = ran[name]
    points = unpacked(data(folder / "both.html")["scenes"][number]["points"]).reshape(-1, 5, 4)
    angles = trajectory["joint_angle"]
    for f, finger in enumerate(FINGERS):
        lengths = [hand.parameters[f"{finger}.{link}_length"] for link in ("second", "third")]
        pip = lengths[0] * np.exp(-1j * angles[:, 2 * f])
        tip = pip + lengths[1] * np.exp(-1j * (angles[:, 2 * f] + angles[:, 2 * f + 1]))
        wanted = np.stack([pip.real, pip.imag, tip.real, tip.imag], axis=1)
        assert np.abs(points[:, f] - wanted).max() < TENTH


def test_carts_wires_and_contacts_are_those_of_the_states(ran, folder):
    hand, trajectory = ran["grasp"]
    scene = data(folder / "both.html")["scenes"][0]
    assert np.abs(unpacked(scene["carts"]) - trajectory["cart_position"]).max() < TENTH
    tension = unpacked(scene["tension"])
    assert np.abs(tension[:, 0] - trajectory["leader_tension"]).max() < 0.05
    assert np.abs(tension[:, 1:] - trajectory["follower_tension"]).max() < 0.05
    slack = unpacked(scene["stretch"])[:, 1:] < 0.0
    assert (trajectory["follower_tension"][slack] == 0.0).all()
    pushes = unpacked(scene["pushes"]).reshape(-1, 10, 2)
    assert np.abs(np.hypot(*pushes.T).T - trajectory["phalanx_force"]).max() < 0.05
    places = unpacked(scene["contacts"]).reshape(-1, 10, 2)
    pressed = trajectory["phalanx_force"] > 0.5
    radius = hand.parameters["object.radius"]
    for f, finger in enumerate(FINGERS):
        away = np.array(
            [hand.parameters[f"object.{x}"] - hand.parameters[f"{finger}.mount_{x}"] for x in "xy"]
        )
        away *= (1.0, hand.parameters[f"{finger}.facing"])
        for link in range(2):
            row = pressed[:, 2 * f + link]
            depth = radius - np.linalg.norm(places[row, 2 * f + link] - away, axis=1)
            force = trajectory["phalanx_force"][row, 2 * f + link]
            # each phalanx touches where the object is as deep as its law asks for that force
            assert (depth > -TENTH).all() and (
                depth < force / hand.parameters["object.stiffness"] + TENTH
            ).all()


def test_recorded_channels_are_carried_with_all_their_bits(folder):
    scene, recording = data(folder / "both.html")["scenes"][0], Recording.read(folder / "grasp.h5")
    for name in recording.names:
        assert np.array_equal(unpacked(scene["recorded"][name]), recording[name])


@pytest.mark.parametrize("shape", ["sphere", "prism"])
def test_other_objects_touch_phalanges_on_their_outline(shape):
    """The drawn outline and the arrows' feet come from different formulas; here they meet."""
    from hannes.report.viewer.scene import scene
    from hannes.simulation.experiment.experiment import Experiment, Reference, Target

    size = {"object.half_x": 0.02, "object.half_y": 0.02, "object.radius": 4e-3, "object.turn": 0.3}
    values = size if shape == "prism" else {"object.radius": 0.03}
    reference = Reference(np.array([[0.0, 0.5], [0.0, 8.0]]))
    experiment = Experiment(shape, 0.5, reference, Target(shape, values), sampling=200.0)
    hand = Hand()
    made = scene(replay(observe(hand, simulate(hand, experiment))), shape)
    pressed = np.argwhere(made.forces > 1.0)
    assert len(pressed)
    for row, phalanx in pressed[:: max(1, len(pressed) // 40)]:
        f = phalanx // 2
        mount = np.array([hand.parameters[f"{FINGERS[f]}.mount_{x}"] for x in "xy"])
        outline = made.sections.points[f] + made.pose[row, :2] - mount
        outline = outline * (1.0, hand.parameters[f"{FINGERS[f]}.facing"])
        ends = np.roll(outline, -1, axis=0) - outline
        place = made.contacts[row, phalanx, :2]
        share = np.clip(((place - outline) * ends).sum(1) / ((ends**2).sum(1) + 1e-30), 0.0, 1.0)
        gap = np.linalg.norm(place - outline - share[:, np.newaxis] * ends, axis=1).min()
        depth = made.forces[row, phalanx] / made.hand.parameters["object.stiffness"]
        assert gap < depth + 4 * TENTH  # a flat side is arched by a hundredth of itself


def test_a_measured_recording_is_drawn_by_a_simulation_and_says_so(folder, tmp_path):
    made = view([folder / "bare.csv"], tmp_path / "bare.html", stills=[0.3])
    (shown,) = made["recordings"]
    assert "measured" in shown["note"] and "a simulation draws it" in shown["note"]
    assert "position within" in shown["note"] and "current within" in shown["note"]
    svg, png = made["stills"]
    assert Path(svg).read_text(encoding="utf-8").startswith("<?xml")
    assert Path(png).read_bytes().startswith(b"\x89PNG")
    scene = data(tmp_path / "bare.html")["scenes"][0]
    recording = Recording.read(folder / "bare.csv")
    assert np.array_equal(unpacked(scene["recorded"]["current"]), recording["current"])
    assert scene["simulated"].keys() >= {"position", "current", "leader_tension"}
    assert "nothing fitted" in shown["note"]
    assert "free closure without an object, which is assumed" in shown["note"]
    assert "--experiment NAME" in shown["note"]
    assert "FAR" not in shown["note"]


def test_long_recordings_are_thinned_and_it_is_said(tmp_path):
    reference = np.linspace(0.0, 3.0, 6001)
    time = np.linspace(0.0, 6.0, 6001)
    Recording(
        {"time": time, "reference": reference, "position": reference},
        {"time": "s", "reference": "rad", "position": "rad"},
    ).to_csv(tmp_path / "slow.csv")
    made = view([tmp_path / "slow.csv"], tmp_path / "slow.html")
    assert "one of 3 samples of 6001 is shown" in made["recordings"][0]["note"]
    assert made["bytes"] < 1e6
    scene = data(tmp_path / "slow.html")["scenes"][0]
    assert np.array_equal(unpacked(scene["recorded"]["position"]), reference[::3])


def test_thinning_keeps_the_end_and_the_moments_of_stills():
    from hannes.report.viewer.scene import kept_rows

    times = np.linspace(0.0, 60.0, 60002)
    rows, every = kept_rows(times, [59.9991])
    assert every == 26
    assert rows[-1] == 60001
    assert np.abs(times[rows] - 59.9991).min() < 6e-4


def test_stills_at_near_times_have_names_of_their_own(folder, tmp_path):
    made = view([folder / "bare.csv"], tmp_path / "v.html", stills=[0.30001, 0.300013, 0.30001])
    names = [Path(each).name for each in made["stills"]]
    assert names[::2] == ["v-0.30001s.svg", "v-0.300013s.svg"]


def test_two_results_of_one_name_are_refused_as_what_they_are(tmp_path):
    from hannes.core.io.outputs import reserved

    same = [tmp_path / "a.html", tmp_path / "." / "a.html"]
    with pytest.raises(BadInput, match="two results"), reserved("view", same):
        pass


def test_what_was_gripped_is_taken_from_the_experiment_that_is_named(folder, tmp_path):
    Recording.read(folder / "grasp.h5").to_csv(tmp_path / "grasp.csv")
    out = tmp_path / "grasp.html"
    (assumed,) = view([tmp_path / "grasp.csv"], out)["recordings"]
    assert "CURRENT IS FAR FROM THE RECORDED: what was gripped?" in assumed["note"]
    made = view([tmp_path / "grasp.csv"], out, experiments=["dynamometer"])
    (named,) = made["recordings"]
    assert '"Dynamometer grasp" (a cylinder)' in named["note"]
    assert "assumed" not in named["note"] and "FAR" not in named["note"]
    assert data(out)["scenes"][0]["slices"]
    assert "<h1>Dynamometer grasp (grasp)</h1>" in out.read_text(encoding="utf-8")
    with pytest.raises(BadInput, match="stands for"):
        view([tmp_path / "grasp.csv"], out, experiments=["stiffness-sweep"])


def test_the_start_is_found_where_no_reference_says_it(folder, tmp_path):
    recording = Recording.read(folder / "grasp.h5")
    channels = {name: recording[name] for name in ("time", "position", "current")}
    channels["time"] = channels["time"] + 700.25
    units = {"time": "s", "position": "rad", "current": "A"}
    Recording(channels, units).to_csv(tmp_path / "late.csv")
    made = view([tmp_path / "late.csv"], tmp_path / "late.html", experiments=["dynamometer"])
    note = made["recordings"][0]["note"]
    assert "begun at 700 s, where the positions agree best" in note
    assert "FAR" not in note


def test_a_misfit_as_of_a_wrong_unit_leads_to_check(folder, tmp_path):
    recording = Recording.read(folder / "void.h5")
    degrees = recording.with_channels({"position": np.degrees(recording["position"])}, {})
    degrees.to_csv(tmp_path / "degrees.csv")
    with pytest.raises(BadInput, match="hannes check"):
        view([tmp_path / "degrees.csv"], tmp_path / "v.html")
    turns = recording.with_channels({"position": recording["position"] / 6.2832}, {})
    turns.to_csv(tmp_path / "turns.csv")
    (shown,) = view([tmp_path / "turns.csv"], tmp_path / "v.html")["recordings"]
    assert "POSITION IS FAR FROM THE RECORDED" in shown["note"]
    assert "hannes check" in shown["note"]


def test_channels_keep_their_units_where_only_the_reference_was_recorded(folder, tmp_path):
    recording = Recording.read(folder / "void.h5")
    channels = {name: recording[name] for name in ("time", "reference")}
    Recording(channels, {"time": "s", "reference": "rad"}).to_csv(tmp_path / "command.csv")
    (shown,) = view([tmp_path / "command.csv"], tmp_path / "v.html")["recordings"]
    assert "()" not in shown["note"] and "no position or current to compare" in shown["note"]
    units = data(tmp_path / "v.html")["scenes"][0]["units"]
    assert (units["position"], units["current"]) == ("rad", "A")


def test_metres_are_no_angles(tmp_path):
    lines = [f"{k * 1e-3},{k * 1e-4},{k * 1e-4},{k * 1e-2}" for k in range(100)]
    text = "\n".join(["time_s,reference_m,position_m,drive_V", *lines, ""])
    (tmp_path / "axis.csv").write_text(text)
    with pytest.raises(BadInput, match="comes in m, expected rad, of the output shaft"):
        view([tmp_path / "axis.csv"], tmp_path / "v.html")


@pytest.fixture(scope="module")
def loose(folder):
    """A hand with a slack leader."""
    hand = Hand(["leader_slack"]).with_values({"leader_slack.length": 3e-3})
    (folder / "loose.toml").write_text(hand_toml(hand), encoding="utf-8")
    return folder / "loose.toml"


def test_what_was_simulated_by_another_hand_is_named(folder, loose, tmp_path):
    view([folder / "void.h5"], tmp_path / "v.html", hands=[loose])
    scene = data(tmp_path / "v.html")["scenes"][0]
    assert scene["drawnBy"] == "loose.toml" and not scene["own"]
    assert scene["simulated"].keys() >= {"current", "leader_tension"}


def test_stills_hold_wires_carts_and_traces(folder, loose):
    from hannes.report.viewer.scene import scene
    from hannes.report.viewer.still import still
    from hannes.simulation.hand.hand_file import load_hand

    made = scene(replay(Recording.read(folder / "bare.csv"), load_hand(loose)), "bare")
    figure = still([made], 0.02)
    words = [each.get_text() for axes in figure.axes for each in axes.texts]
    assert any(each.startswith("leader slack 2.9") for each in words)
    assert any(each.startswith("cart A") for each in words)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[-3:] == ["position [rad]", "current [A]", "leader tension [N]"]
    drive = figure.axes[6]
    straight, waves = (
        max(len(line.get_xdata()) for line in axes.lines)
        for axes in (still([made], 0.4).axes[6], drive)
    )
    assert waves > straight  # the slack leader


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"plant": "axis"}, "only the hand can be drawn"),
        ({}, "neither a channel reference_rad nor an experiment"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, given, words):
    time = np.linspace(0.0, 1.0, 50)
    channels = {"time": time, "position": time}
    recording = Recording(channels, {"time": "s", "position": "rad"}, **given)
    recording.to_hdf5(tmp_path / "strange.h5")
    with pytest.raises(BadInput, match=words):
        view([tmp_path / "strange.h5"], tmp_path / "strange.html")
    assert not (tmp_path / "strange.html").exists()


def test_looking_at_a_recording_runs_no_code_that_came_with_it(tmp_path):
    time = np.linspace(0.0, 1.0, 50)
    hand = f'base = "hannes"\neffects = ["{tmp_path}/own.py:EFFECT"]\n'
    (tmp_path / "own.py").write_text("raise SystemExit('ran')")
    recording = Recording(
        {"time": time, "position": time}, {"time": "s", "position": "rad"}, hand=hand
    )
    with pytest.raises(BadInput, match="--hand"):
        replay(recording)


def test_arrays_come_back_as_they_were_packed():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(50, 7))
    assert np.array_equal(unpacked(exact(values[:, 0])), values[:, 0])
    assert np.abs(unpacked(whole(values, 1e-4)) - values).max() <= 0.51e-4


@pytest.fixture(scope="module")
def chromium():
    with browser() as running:
        yield running


def test_page_of_two_grasps_answers_in_a_browser(chromium, folder, capsys):
    path = folder / "both.html"
    assert path.stat().st_size < 1e6
    page, messages = opened(chromium, path)
    until(page, "Boolean(window.viewer && viewer.ready)")
    state = lambda name: page.evaluate(f"viewer.{name}")  # noqa: E731
    page.keyboard.press("ArrowRight")
    assert state("index") == 1
    page.keyboard.press("Shift+ArrowRight")
    assert state("index") == 11
    page.keyboard.press("ArrowLeft")
    assert state("index") == 10
    page.keyboard.press("End")
    assert state("index") == len(Recording.read(folder / "grasp.h5")) - 1
    page.keyboard.press("Home")
    page.locator("#speed").select_option("1")
    page.locator("#play").click()
    until(page, "viewer.index > 50")
    assert state("playing")
    page.keyboard.press("Space")
    assert not state("playing")
    page.locator("#scrub").fill("640")
    assert state("index") == 640
    page.keyboard.press("g")
    assert not state("ghost")
    page.keyboard.press("g")
    assert_numbers(page, folder)
    box = page.locator(".u-over").first.bounding_box()
    page.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 10)
    assert abs(state("time") - 0.25 * 1.15) < 0.02
    page.locator("#view").focus()
    page.keyboard.press("Space")  # presses the button that has the focus
    assert not state("playing")
    turned = page.evaluate("viewer.turn()")
    page.keyboard.press("d")
    assert page.evaluate("viewer.turn()")["y"] > turned["y"]
    box = page.locator("#space").bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 120, steps=4)
    page.mouse.up()
    assert page.evaluate("viewer.turn()")["y"] != turned["y"] + 0.12
    assert messages == []
    page.close()


def assert_numbers(page, folder):
    """The page's numbers at its cursor are the recordings', to the bit, and are written there."""
    first, second = page.evaluate("viewer.values()")
    for shown, name in ((first, "grasp"), (second, "void")):
        recording = Recording.read(folder / f"{name}.h5")
        for channel in recording.names:
            assert shown["recorded"][channel] == recording[channel][640]
    cell = page.locator("#readout tbody tr").nth(1).locator("td").first.inner_text()
    assert float(cell) == pytest.approx(first["recorded"]["current"], rel=1e-5)


def test_recordings_of_other_clocks_and_lengths_share_one_time(chromium, folder, tmp_path):
    """The second begins by a clock of its own, is sampled slower, and is the longer one."""
    recording = Recording.read(folder / "void.h5")
    rows = np.arange(0, len(recording), 7)
    channels = {name: each[rows] for name, each in recording.items()}
    channels["time"] = channels["time"] + 1500.0
    Recording(channels, dict(recording.units)).to_csv(tmp_path / "late.csv")
    Recording.read(folder / "grasp.h5").between(0.0, 0.6).to_hdf5(tmp_path / "short.h5")
    out = tmp_path / "pair.html"
    made = view([tmp_path / "short.h5", tmp_path / "late.csv"], out, stills=[1.1])
    assert (
        "its clock begins at 1500 s, here it begins with the first"
        in (made["recordings"][1]["note"])
    )
    assert "over since 0.6 s" in Path(made["stills"][0]).read_text(encoding="utf-8")
    page, messages = opened(chromium, out)
    until(page, "Boolean(window.viewer && viewer.ready)")
    page.keyboard.press("End")
    last = recording.time[rows[-1]]
    assert page.evaluate("viewer.time") == pytest.approx(last, abs=1e-6)
    spans = page.evaluate(
        "viewer.plots.charts.map((each) => [each.scales.x.min, each.scales.x.max])"
    )
    assert len(spans) > 4
    assert {tuple(each) for each in spans} == {(0.0, page.evaluate("viewer.time"))}
    first, second = page.evaluate("viewer.values()")
    assert first["row"] is None and second["recorded"]["position"] == channels["position"][-1]
    cells = page.locator("#readout tbody tr").first.locator("td")
    assert cells.nth(0).inner_text() == "–" and cells.nth(1).inner_text() != "–"
    assert "short (over: recorded from 0.000 to 0.600 s)" in page.locator("#drawn").inner_text()
    assert messages == []
    page.close()


def test_effect_switch_shows_the_hand_without_it(chromium, folder, loose, tmp_path):
    made = view([folder / "bare.csv"], tmp_path / "slack.html", hands=[loose])
    assert [each["name"] for each in made["recordings"]] == ["bare", "bare without"]
    page, messages = opened(chromium, tmp_path / "slack.html", 600, 900)
    until(page, "Boolean(window.viewer && viewer.ready)")
    assert page.evaluate("viewer.ghost")  # the hand without is drawn, and its switch says so
    assert page.locator("#ghost").is_checked()
    assert "without leader_slack" in page.locator("#ghost-label").inner_text()
    assert not page.locator("#effect-label").is_visible()
    drawn = page.locator("#drawn").inner_text
    assert "solid: bare, with leader_slack · dashed: bare without" in drawn()
    page.keyboard.press("e")
    assert not page.evaluate("viewer.ghost") and "dashed" not in drawn()
    page.keyboard.press("e")
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 600
    slack = page.evaluate("viewer.scenes.map((each) => each.stretch.at(20, 0))")
    assert slack[0] < -2e-3 < slack[1]
    assert messages == []
    page.close()
