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


def test_effect_switch_shows_the_hand_without_it(chromium, folder, tmp_path):
    hand = Hand(["leader_slack"]).with_values({"leader_slack.length": 3e-3})
    (tmp_path / "loose.toml").write_text(hand_toml(hand), encoding="utf-8")
    made = view([folder / "bare.csv"], tmp_path / "slack.html", hands=[tmp_path / "loose.toml"])
    assert [each["name"] for each in made["recordings"]] == ["bare", "bare without"]
    page, messages = opened(chromium, tmp_path / "slack.html", 600, 900)
    until(page, "Boolean(window.viewer && viewer.ready)")
    assert not page.evaluate("viewer.effect")
    assert page.locator("#effect-label").is_visible()
    page.keyboard.press("e")
    assert page.evaluate("viewer.effect")
    page.keyboard.press("e")
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 600
    slack = page.evaluate("viewer.scenes.map((each) => each.stretch.at(20, 0))")
    assert slack[0] < -2e-3 < slack[1]
    assert messages == []
    page.close()
