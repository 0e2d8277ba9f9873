"""MuJoCo's C functions, callable from compiled loops by the addresses of a model and its data.

An address keeps nothing alive: whoever passes one on must hold the `MjModel` and `MjData` it belongs to. One `MjData`
per thread.
"""

from pathlib import Path

import llvmlite.binding as llvm
import mujoco
from numba import types

_NAMES = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")


def _library() -> Path:
    folder = Path(mujoco.__file__).parent
    found = [file for name in _NAMES for file in sorted(folder.glob(name))]
    if not found:
        raise ImportError(f"MuJoCo's library is not in {folder}; expected one of {', '.join(_NAMES)}.")
    return found[0]


# The interpreter has this very file open already: this only tells the compiler where its symbols are.
llvm.load_library_permanently(str(_library()))

# mj_kinematics(model, data): poses of bodies, joints, shapes and sites from data's qpos.
kinematics = types.ExternalFunction("mj_kinematics", types.void(types.intp, types.intp))
# mj_geomDistance(model, data, geom1, geom2, farthest, segment): smallest signed distance, at most `farthest`; the six
# numbers at `segment` become the nearest points of geom1 and geom2.
geom_distance = types.ExternalFunction(
    "mj_geomDistance",
    types.float64(types.intp, types.intp, types.int32, types.int32, types.float64, types.intp),
)
# mj_comPos(model, data), then mj_comVel(model, data), after mj_kinematics: motion axes and inertias about centres of
# mass, then velocities from data's qvel.
com_pos = types.ExternalFunction("mj_comPos", types.void(types.intp, types.intp))
com_vel = types.ExternalFunction("mj_comVel", types.void(types.intp, types.intp))
# mj_rne(model, data, flag, forces), after those: the (nv,) forces at `forces` that gravity and velocities ask for,
# and accelerations in data's qacc where the flag is 1; without armature, damping and contacts.
newton_euler = types.ExternalFunction("mj_rne", types.void(types.intp, types.intp, types.int32, types.intp))
# mj_passive(model, data), after mj_comVel: data's qfrc_passive, what springs, dampers, compensated gravity and fluids
# do to each joint.
passive = types.ExternalFunction("mj_passive", types.void(types.intp, types.intp))
