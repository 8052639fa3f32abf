"""What every benchmark shares: its arguments, its table, its JSON, its verdict on bounds."""

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

Row = dict[str, Any]
ROOT = Path(__file__).parent.parent  # of this checkout


def must_show(name: str, value: float, bound: float, holds: bool) -> Row:
    """One figure that an issue asks for, with its bound and whether it holds."""
    return {"name": name, "value": value, "bound": bound, "holds": bool(holds)}


def peak_mib() -> float:
    """Most memory that this process has had resident [MiB].

    Linux keeps it in a file; getrusage's value there starts with the parent's.
    """
    status = Path("/proc/self/status")
    if status.exists():
        line = next(each for each in status.read_text().splitlines() if "VmHWM" in each)
        return float(line.split()[1]) / 1024.0
    import resource  # macOS counts in bytes

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def processor() -> str:
    """Model, family and model number of the processor, and how many cores there are."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.exists() else []
    fields = {
        key.strip(): value.strip() for key, _, value in (each.partition(":") for each in lines)
    }
    model = fields.get("model name") or platform.processor() or platform.machine()
    if "cpu family" in fields:
        model += f" (family {fields['cpu family']}, model {fields['model']})"
    return f"{model}, {os.cpu_count()} cores"


def interpreter(root: Path) -> str:
    """Python of another checkout's own environment, where it has one, else this one."""
    own = root / ".venv" / "bin" / "python"
    return str(own) if root != ROOT and own.exists() else sys.executable


def interval(samples: Sequence[float]) -> dict[str, float]:
    """95 % interval of the median of repeats (bootstrap), of infinite ones, too."""
    import numpy as np  # not where the memory of small processes is measured

    values = np.array(samples)
    picks = np.random.default_rng(0).integers(0, values.size, (2000, values.size))
    medians = np.median(values[picks], axis=1)
    between = "linear" if np.isfinite(medians).all() else "nearest"
    low, high = np.percentile(medians, (2.5, 97.5), method=between)
    return {"low": float(low), "high": float(high)}


def aligned(rows: Sequence[Row]) -> list[Row]:
    """The same rows, each with all keys."""
    keys = {key: "" for row in rows for key in row}
    return [keys | row for row in rows]


def arguments(doc: str, module: str, parts: Sequence[str] = ()) -> argparse.Namespace:
    """Parse `--quick`, `--json FILE|-` and, of a benchmark with `parts`, `--only PART`."""
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{module}",
        description=doc,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="fewer repeats, for a first look")
    parser.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    if parts:
        parser.add_argument("--only", nargs="+", choices=parts, default=parts, metavar="PART",
                            help=f"of {', '.join(parts)}")  # fmt: skip
    return parser.parse_args()


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Align rows under their keys."""
    if not rows:
        return ""
    keys = list(rows[0])
    cells = [keys] + [[_cell(row.get(key, "")) for key in keys] for row in rows]
    widths = [max(len(line[k]) for line in cells) for k in range(len(keys))]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in cells
    )


def _cell(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def given(found: Mapping[str, Any], tables: Sequence[Sequence[Row]], target: str | None) -> None:
    """Print tables, and write what was found as JSON where asked: to a file, or "-".

    Tables go to standard error where the JSON goes to standard output.
    """
    stream = sys.stderr if target == "-" else sys.stdout
    print("\n\n".join(table(aligned(each)) for each in tables), file=stream)
    text = json.dumps(found, indent=1)
    if target == "-":
        print(text)
    elif target:
        Path(target).write_text(text + "\n", encoding="utf-8")


def main(
    doc: str,
    module: str,
    measure: Callable[..., tuple[list[Row], list[Row]]],
    parts: Sequence[str] = (),
) -> None:
    """Run `measure(quick)` -> rows, must_show rows; print tables and write JSON where asked.

    A benchmark with `parts` is also given which of them: `measure(quick, only)`.
    """
    from threadpoolctl import threadpool_limits  # not where the memory of small processes counts

    asked = arguments(doc, module, parts)
    with threadpool_limits(1, "blas"):
        rows, bounds = measure(asked.quick, asked.only) if parts else measure(asked.quick)
    given({"rows": rows, "must_show": bounds}, (rows, bounds), asked.json)
    stream = sys.stderr if asked.json == "-" else sys.stdout
    print(f"\nOn {processor()}; ratios of times differ from one processor to another.", file=stream)
