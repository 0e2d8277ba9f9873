"""Drawing without a screen: MuJoCo must be told before it is loaded."""

import os
import sys
from ctypes.util import find_library


def draw_off_screen() -> None:
    """Let MuJoCo draw through EGL on a Linux machine without a display, if EGL is there: loading would fail else."""
    bare = sys.platform.startswith("linux") and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    if bare and find_library("EGL"):
        os.environ.setdefault("MUJOCO_GL", "egl")
