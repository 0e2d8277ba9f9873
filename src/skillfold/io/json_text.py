"""JSON that any reader takes, and text files that are written wholly or not at all."""

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skillfold.errors import InputError


def to_json(facts: Any) -> str:
    """JSON text; NaN and infinities, which JSON has not, become null."""
    return json.dumps(_finite(facts), indent=2) + "\n"


def write_whole(path: Path, text: str) -> Path:
    """Write a text file wholly or not at all, whatever happens on the way.

    Raises:
        InputError: it cannot be written.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        beside.write_text(text, encoding="utf-8")
        beside.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from None
    finally:
        beside.unlink(missing_ok=True)
    return path


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
