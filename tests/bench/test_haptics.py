"""The tactor's command, tick by tick."""

import itertools

import pytest

from hannes.bench.haptics import HapticMemory, HapticSample, HapticSettings, haptic, line

SETTINGS = HapticSettings()


def commands(samples):
    """Commands by tick, None where none was due."""
    memory, found = HapticMemory(), []
    for sample in samples:
        memory, command = haptic(SETTINGS, memory, sample)
        found.append(command)
    return found


def test_commands_come_at_the_stated_rate():
    found = commands([HapticSample(1e-3, False, 0.5, 0.0)] * 1000)
    due = [k for k, each in enumerate(found) if each]
    assert len(due) == SETTINGS.rate
    assert {b - a for a, b in itertools.pairwise(due)} == {round(1e3 * SETTINGS.delay)}


def test_an_empty_hand_is_silent():
    (first,) = commands([HapticSample(1e-3, False, 0.9, 50.0)])
    assert first == (0.0, 0.0, 0.0)


def test_a_contact_is_a_pulse_then_the_force():
    found = [c for c in commands([HapticSample(1e-3, True, 0.9, 50.0)] * 500) if c]
    assert found[0].amplitude == 1.0
    assert found[-1].amplitude == pytest.approx(0.55)
    assert found[-1].frequency == SETTINGS.rigid_frequency


def test_doubt_stands_between_the_classes():
    last = [commands([HapticSample(0.02, True, p, 1.0)])[0].frequency for p in (0.1, 0.5, 0.9)]
    assert last[0] < last[1] < last[2]


def test_more_force_never_feels_fainter():
    sizes = [
        [c for c in commands([HapticSample(0.02, True, 0.1, f)] * 9) if c][-1].amplitude
        for f in range(0, 200, 5)
    ]
    assert sizes == sorted(sizes)
    assert sizes[-1] == 1.0


def test_a_command_is_a_line_of_text():
    (first,) = commands([HapticSample(1e-3, False, 0.5, 0.0)])
    assert line(first) == b"h 0.000 0 0.000\n"
