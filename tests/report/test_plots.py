"""`plot()` and what a notebook shows, of every class that a user holds."""

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from hannes import Hand, Recording, load_experiment, observe, simulate
from hannes.core.errors import BadInput
from hannes.report.schematic import schematic


@pytest.fixture(scope="module")
def ran():
    asked = load_experiment("dynamometer")[0]
    return asked.hand, simulate(asked.hand, asked.experiment)


@pytest.fixture(autouse=True)
def closed():
    import matplotlib.pyplot as plt

    yield
    plt.close("all")


def test_recording_plots_its_channels_with_units(ran):
    recording = observe(*ran)
    axes = recording.plot()
    assert len(axes) == len(recording.names) - 1  # the reference stands with the position
    assert [each.get_ylabel() for each in axes][:2] == ["position [rad]", "current [A]"]
    assert np.array_equal(axes[1].lines[0].get_ydata(), recording["current"])
    assert len(recording.plot(["force"])) == len(recording.plot("force")) == 1
    with pytest.raises(BadInput, match="force"):
        recording.plot(["forse"])


def test_trajectory_plots_outputs_and_states(ran):
    _, trajectory = ran
    axes = trajectory.plot(["leader_tension", "joint_angle"])
    assert np.array_equal(axes[0].lines[0].get_ydata(), trajectory["leader_tension"])
    assert len(axes[1].lines) == 10
    assert len(trajectory.plot()) == 5
    assert trajectory.plot("current")[0].get_ylabel() == "current [A]"
    with pytest.raises(BadInput, match="leader_tension"):
        trajectory.plot(["leader_tensoin"])


def test_notebooks_show_tables_and_the_schematic(ran):
    hand, trajectory = ran
    assert "<td>current</td><td>A</td>" in observe(hand, trajectory)._repr_html_()
    assert "completed" in trajectory._repr_html_()
    loose = hand.with_effects("leader_slack").with_values({"leader_slack.length": 2e-3})
    assert 'class="leader marked"' in loose._repr_html_()
    assert "marked" not in hand._repr_html_().replace(".marked", "")


def test_a_trajectory_is_a_mapping_as_a_recording_is(ran):
    _, trajectory = ran
    assert "time" in trajectory and "current" in trajectory and "joint_angle" in trajectory
    assert "curent" not in trajectory and 3 not in trajectory
    names = list(trajectory)
    assert names[0] == "time" and len(set(names)) == len(names)
    assert len(trajectory) == len(trajectory.time)
    assert np.array_equal(dict(trajectory)["current"], trajectory["current"])
    assert trajectory.get("curent") is None
    assert trajectory == trajectory


def test_notebooks_show_experiments(ran):
    _, trajectory = ran
    shown = trajectory.experiment._repr_html_()
    assert "Experiment: Dynamometer grasp" in shown
    assert "<td>object</td><td>cylinder</td>" in shown


def test_names_in_a_table_are_escaped(tmp_path):
    recording = Recording({"time": [0, 1], "a": [0, 1]}, {"time": "s", "a": "1"}, plant="<b>")
    assert "&lt;b&gt;" in recording._repr_html_()


def test_importing_hannes_draws_nothing():
    code = "import hannes, sys; hannes.Recording; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_schematic_names_every_part_and_every_effect():
    from xml.etree import ElementTree

    from hannes.report.schematic import schematic
    from hannes.report.schematic_layout import PARAMETERS, parts_of
    from hannes.simulation.catalogue import effects

    hand = Hand().with_values({"leader.stiffness": 12345.0})
    root = ElementTree.fromstring(schematic(hand))
    space = "{http://www.w3.org/2000/svg}"
    titles = {}
    for group in root.iter(f"{space}g"):
        if part := group.get("data-part"):
            titles.setdefault(part, "")
            titles[part] += group.find(f"{space}title").text
    assert titles.keys() == PARAMETERS.keys()
    assert "leader.stiffness = 1.234e+04 N/m" in titles["leader"] or "1.235e+04" in titles["leader"]
    declared = {name.split(".")[0] for name in hand.parameters.declared} - {"gravity"}
    assert declared == {prefix for each in PARAMETERS.values() for prefix in each}
    shown = "\n".join(titles.values())
    for name, effect in effects().items():
        assert parts_of(effect), name
        assert name in shown


def test_a_finger_with_a_fault_is_marked_in_the_drawing():
    drawing = schematic(None, ["thumb_weak_spring"])
    assert 'class="thumb marked"' in drawing and "Marked: thumb" in drawing
    assert 'class="index marked"' not in drawing
