"""Experiments found by name: those that ship with hannes, or a TOML file of the user's own."""

from pathlib import Path

from hannes.core.errors import BadInput, nearest


def folder() -> Path:
    """Folder of the shipped experiments: in the installed package, else beside it."""
    package = Path(__file__).parents[2]
    inside = package / "experiments"
    return inside if inside.is_dir() else package.parent / "experiments"


def names() -> list[str]:
    """Names of the shipped experiments, in alphabetical order."""
    return sorted(path.stem for path in folder().glob("*.toml"))


def find(name: str | Path) -> Path:
    """Return the file of an experiment: a shipped name, or the path of a .toml file."""
    if str(name).endswith(".toml"):
        return Path(name)
    if str(name) not in names():
        raise BadInput(
            f'no experiment named "{name}"{nearest(str(name), names())} '
            f"(shipped: {', '.join(names())}; or give the path of a .toml file)"
        )
    return folder() / f"{name}.toml"


def question(path: Path) -> str:
    """First comment of an experiment's file: the question it answers."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return " ".join(lines)
