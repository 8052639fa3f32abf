"""Where the recordings of other laboratories come from; none of them is part of this project.

`HANNES_MEASURED` names a folder that holds them, one subfolder per set (`emps/DATA_EMPS.mat`).
Without it a set is fetched once from its public source, at a fixed commit, and checked against
its SHA-256; it then stays in the user's cache folder.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hannes.core.errors import BadInput, MissingRecording, nearest

SECONDS_TO_ANSWER = 5.0  # a server that is silent this long counts as absent


@dataclass(frozen=True)
class Source:
    """A public set of recordings: who made it, where it lies, which bytes it must have.

    `moved`: file -> subfolder of `path` in which it lies there.
    """

    cite: str
    repository: str
    commit: str
    path: str
    sha256: Mapping[str, str]
    moved: Mapping[str, str] = field(default_factory=dict)

    @property
    def url(self) -> str:
        """Address to which a file's name is appended to fetch it."""
        return f"https://raw.githubusercontent.com/{self.repository}/{self.commit}/{self.path}/"

    @property
    def page(self) -> str:
        """Address for people: the folder at the fixed commit."""
        return f"https://github.com/{self.repository}/tree/{self.commit}/{self.path}"


def _sums(name: str) -> dict[str, str]:
    """SHA-256 by file, as `sha256sum` writes them."""
    lines = (Path(__file__).parent / f"{name}.sha256").read_text(encoding="utf-8").splitlines()
    return {file: digest for digest, _, file in (line.partition("  ") for line in lines)}


SOURCES = {
    "emps": Source(
        cite=(
            "A. Janot, M. Gautier, M. Brunot: Data Set and Reference Models of EMPS. "
            "Workshop on Nonlinear System Identification Benchmarks, 2019"
        ),
        repository="forgi86/sysid-neural-continuous",
        commit="956aa7ecd73061b0321c6f6098d74c9e4a7ce67a",
        path="examples/EMPS/data",
        sha256={
            "DATA_EMPS.mat": "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
            "DATA_EMPS_PULSES.mat": (
                "0eab75bb1f6b16228ee78791343a88bf9bfd9a51036ac9807d7b5fc11c0e1704"
            ),
        },
    ),
    "rh56_finger": Source(
        cite=(
            "Correll Lab, University of Colorado Boulder: rh56_controller, recordings of an "
            "Inspire RH56DFX hand's middle finger, 2026"
        ),
        repository="correlllab/rh56_controller",
        commit="e4ef2568c9106bd220526053732ae4aae90c3dfd",
        path="experiment_data/hybrid",
        sha256=_sums("rh56_finger"),
        moved={
            "middlefinger_speed250_force250_20trials_20260303-173935.csv": "data/",
            "middlefinger_speed750_force1000_20trials_20260303-171447.csv": "data/",
        },
    ),
}


def folder(name: str, base_url: str | None = None) -> Path:
    """Return the folder that holds every file of the set `name`, fetching it if need be.

    `base_url` stands in for the public source (a mirror, a test server).
    Raises BadInput for an unknown set, MissingRecording where neither way works.
    """
    if name not in SOURCES:
        hint = nearest(name, SOURCES) or f"; known: {', '.join(SOURCES)}"
        raise BadInput(f'no set of recordings is called "{name}"{hint}')
    source = SOURCES[name]
    return _given(name, source) or _fetched(name, source, base_url or source.url)


def _given(name: str, source: Source) -> Path | None:
    root = os.environ.get("HANNES_MEASURED")
    if not root:
        return None
    here = Path(root).expanduser().absolute() / name
    return here if all(_there(here / file) for file in source.sha256) else None


def _there(file: Path) -> bool:
    """Whether a file is given, as it is or packed."""
    return file.is_file() or file.with_name(f"{file.name}.gz").is_file()


def _fetched(name: str, source: Source, url: str) -> Path:
    import pooch

    pooch.get_logger().setLevel("WARNING")
    cache = pooch.os_cache("hannes") / name
    elsewhere = {file: f"{url}{place}{file}" for file, place in source.moved.items()}
    store = pooch.create(cache, url, registry=dict(source.sha256), urls=elsewhere)
    download = pooch.HTTPDownloader(timeout=SECONDS_TO_ANSWER)
    try:
        for file in source.sha256:
            store.fetch(file, downloader=download)
    except (OSError, ValueError) as error:  # network or disk; checksum
        raise MissingRecording(_how_to_get(name, source, url, error)) from error
    return cache


def _how_to_get(name: str, source: Source, url: str, error: Exception) -> str:
    root = os.environ.get("HANNES_MEASURED")
    given = f"HANNES_MEASURED={root} lacks them" if root else "HANNES_MEASURED is not set"
    files = ",".join([*source.sha256][:2] + ["..."] * (len(source.sha256) > 2))
    return (
        f"the recordings {name}/{{{files}}} are missing: {given}, and fetching "
        f"them from {url} failed ({_reason(error)}); download them from {source.page} into a "
        f"folder {name} and set HANNES_MEASURED to the folder above it"
    )


def _reason(error: Exception) -> str:
    """One short clause; what the network library says runs over many lines."""
    import requests

    if isinstance(error, requests.HTTPError) and error.response is not None:
        return f"the server answered {error.response.status_code}"
    if isinstance(error, requests.RequestException):
        return "no answer from the server"
    if isinstance(error, ValueError):
        return "what came is not the expected file: its SHA-256 differs"
    return " ".join(str(error).split())
