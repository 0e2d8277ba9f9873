"""MuJoCo as a plain object: its compiled module declares no types."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco as _mujoco

mujoco: Any = _mujoco


@contextmanager
def listening() -> Iterator[list[str]]:
    """What MuJoCo warns of: left alone it writes that to a file in the working folder."""
    told: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(told.append)
    try:
        yield told
    finally:
        mujoco.set_mju_user_warning(before)
