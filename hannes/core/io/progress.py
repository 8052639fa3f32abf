"""Progress of long work: a bar in a terminal or a notebook, nothing in a pipe."""

import sys
import warnings
from typing import Any


def progress_bar(*args: Any, **options: Any) -> Any:
    """tqdm's bar as the place can show it; arguments are tqdm's, `disable` by the place alone.

    In a notebook it is a widget where ipywidgets is installed, else text.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # text serves as well as a widget
        from tqdm.auto import tqdm
    hidden = options.pop("disable", None)
    if hidden is None and in_notebook():
        hidden = False
    return tqdm(*args, disable=hidden, **options)


def in_notebook() -> bool:
    """Return whether a notebook's kernel runs this process."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"
