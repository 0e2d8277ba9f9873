"""What several tests share."""

from pathlib import Path

import pytest

_SHARED = Path(__file__).resolve().parents[1] / ".." / "shared"


def shared(path: str) -> Path:
    """A file of the recordings kept beside the repository; the test is skipped where they are absent."""
    file = _SHARED / path
    if not file.exists():
        pytest.skip(f"needs {path}, which is not part of the repository")
    return file
