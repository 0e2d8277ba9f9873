"""MuJoCo as a plain object: its compiled module declares no types."""

from typing import Any

import mujoco as _mujoco

mujoco: Any = _mujoco
