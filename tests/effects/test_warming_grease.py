"""warming_grease: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from effect_contract import SIZES, check_equations, parameter, runs, sign


def friction(w, dry, viscous, ws, heat, fall):
    """What is missing of the cold friction, and the power of what is left."""
    cold, left = dry * sign(w / ws) + viscous * w, math.exp(-fall * heat)
    return cold * (left - 1.0), cold * left * w


def test_equation():
    check_equations("warming_grease", {"thinned": friction}, {**SIZES, "grease_heat": 0.3})


def test_signature():
    """What friction has done in all, by the cold friction's work E: log(1 + fall E) / fall."""
    fall = 0.5
    bare, run = runs("warming_grease", "void", fall=fall)
    speed = run["motor_speed"]
    cold = parameter("motor.dry_friction") * sign(speed / parameter("motor.friction_speed"))
    cold += parameter("motor.viscous_friction") * speed
    step = np.diff(run.time, prepend=run.time[0])
    work, spent = np.sum(cold * speed * step), np.sum(run["power_gear_friction"] * step)
    assert spent == pytest.approx(math.log(1.0 + fall * work) / fall, rel=0.01)
    assert spent < 0.99 * np.sum(bare["power_gear_friction"] * step)
