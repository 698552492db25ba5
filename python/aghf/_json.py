"""Arguments and results in JSON, as the compiled part has them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np


def read(text: str) -> dict[str, Any]:
    """The object of a text in JSON."""
    read: dict[str, Any] = json.loads(text)
    return read


def text(x: object) -> str:
    """A value in JSON, with arrays as lists."""
    return json.dumps(x, default=_plain)


def _plain(x: object) -> Any:
    if isinstance(x, (np.ndarray, np.generic)):
        return x.tolist()
    raise TypeError(f"'{type(x).__name__}' is neither a number, a text nor a container of these")


def given(arguments: Mapping[str, object], *others: str) -> str:
    """The options that were given among the arguments of a function, all but the others, in JSON."""
    return text({name: value for name, value in arguments.items() if name not in others and value is not None})


def named(scenario: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str | None]:
    """The name and the text of a scenario; a built-in one or one in a file has no text."""
    if isinstance(scenario, Mapping):
        return "scenario", text(scenario)
    return os.fspath(scenario), None
