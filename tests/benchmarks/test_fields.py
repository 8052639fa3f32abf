"""The trial of records with fields in place of the expanded text."""

from types import SimpleNamespace

import numpy as np

from benchmarks.fields import WAYS, compiled, loops, record, texts, ways
from hannes import Hand
from hannes.simulation.hand.model import EQUATIONS


def test_a_field_is_its_slot():
    for layout in (EQUATIONS.parameters, EQUATIONS.states, EQUATIONS.channels, EQUATIONS.outputs):
        numbers = np.arange(float(layout.size))
        fields = numbers.view(record(layout))[0]
        for slot in layout.slots:
            np.testing.assert_array_equal(
                np.atleast_1d(fields[slot.name]), numbers[layout[slot.name]]
            )


def test_the_texts_differ_in_slots_alone():
    expanded, fields, unknown = (texts()[way] for way in WAYS)
    assert "c.spring_torque[joint] = spring_torque(" in fields
    assert "c.spring_torque" not in expanded
    assert "in range(p.rest.size)" in fields and "in range(unknown(p.rest.size))" in unknown
    assert len(expanded.splitlines()) == len(fields.splitlines()) == len(unknown.splitlines())
    assert "out.force" in EQUATIONS.source() and "out.force" not in fields


def test_joints_over_fields_leave_the_same_bits(compiling):
    rng = np.random.default_rng(3)
    states = rng.normal(0.3, 0.2, (20, EQUATIONS.states.size))
    ran = SimpleNamespace(
        time=np.arange(20.0),
        states=states,
        parameters=Hand().vector("cylinder", ()),
        knots=np.zeros((2, 2)),
        memories=np.zeros((1, 10)),
    )
    left = []
    for way in (WAYS[0], WAYS[1]):
        given = ways(ran)[way]
        channels = given[4].view("f8").reshape(2, -1)
        channels[:] = np.random.default_rng(4).normal(0.0, 0.1, channels.shape)
        loops(compiled(texts()[way], way))["joints"](1, *given)
        left.append(channels.copy())
    torque = left[0][:, EQUATIONS.channels["joint_torque"]]
    assert np.isfinite(torque).all() and np.ptp(torque) > 1e-3
    np.testing.assert_array_equal(*left)
