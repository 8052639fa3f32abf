"""What is installed with the core is no copyleft package, and one that were would be seen."""

from email.message import Message

import pytest

from tools import licences


@pytest.mark.parametrize("lock", [licences.CORE, licences.TEST], ids=["core", "test"])
def test_no_copyleft_package_is_installed(lock):
    names = licences.locked(lock)
    assert len(names) > 30 and licences.refused(names) == []


def test_the_core_is_in_what_tests_need_and_has_no_optional_part():
    core, test = licences.locked(licences.CORE), licences.locked(licences.TEST)
    assert set(core) <= set(test)
    for name in ("pytest", "mujoco", "distributed", "sympy", "hypothesis", "mypy", "ruff"):
        assert name in test and name not in core


def test_locks_name_no_host():
    for lock in (licences.CORE, licences.TEST):
        text = lock.read_text(encoding="utf-8")
        assert "--hash=sha256:" in text and "://" not in text and "--index" not in text


def test_every_package_has_its_line(capsys):
    assert licences.main() == 0
    printed = capsys.readouterr().out
    assert "under the MPL in the core: certifi" in printed and "core  numpy" in printed


class Metadata:
    """A package with the given metadata."""

    files = ()

    def __init__(self, **fields):
        self.metadata = Message()
        for name, value in fields.items():
            self.metadata[name.replace("_", "-")] = value


@pytest.mark.parametrize(
    "fields, name, refused",
    [
        ({"License_Expression": "AGPL-3.0-only"}, "AGPL-3.0-only", True),
        ({"License": "LGPL-2.1\nThe whole text"}, "LGPL-2.1", True),
        (
            {"Classifier": "License :: OSI Approved :: GNU General Public License v3 (GPLv3)"},
            "GNU General Public License v3 (GPLv3)",
            True,
        ),
        ({"License_Expression": "MPL-2.0 AND MIT"}, "MPL-2.0 AND MIT", False),
        ({"License": "BSD"}, "BSD", False),
        ({}, "", True),
    ],
)
def test_licences_are_read(monkeypatch, fields, name, refused):
    monkeypatch.setattr(licences, "distribution", lambda package: Metadata(**fields))
    assert licences.licence(Metadata(**fields)) == name
    assert bool(licences.refused(["one"])) == refused


def test_a_library_inside_a_wheel_is_seen(tmp_path):
    text = "Name: libfree\nFiles: libs/free.so\nLicense: LGPL-3.0\n\nName: other\nLicense: MIT\n"
    file = tmp_path / "a-1.dist-info" / "LICENSE.txt"
    file.parent.mkdir()
    file.write_text(text, encoding="utf-8")

    class File(type(file)):
        """As importlib.metadata lists files."""

        def locate(self):
            return self

    package = Metadata(License="MIT")
    package.files = [File(file)]
    assert dict(licences.bundled(package)) == {"libfree": "LGPL-3.0"}
