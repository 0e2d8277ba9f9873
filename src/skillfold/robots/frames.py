"""The frames of a robot: its sites and bodies, by name."""

from typing import Any

import numpy as np

from skillfold.tables import Array

NAMELESS = "none, for no body and no site of the model has a name; give its tool one"


def frames_of(model: Any) -> dict[str, tuple[int, Array, Array]]:
    """Body, position and quaternion in it of every named site and body; a site hides a body of its name."""
    frames = {}
    for i in range(model.nsite):
        frames[model.site(i).name] = (int(model.site_bodyid[i]), model.site_pos[i].copy(), model.site_quat[i].copy())
    still = (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    for i in range(1, model.nbody):
        frames.setdefault(model.body(i).name, (i, *still))
    frames.pop("", None)
    return frames


def last_frame(model: Any) -> str:
    """The named body at the end of the longest chain of joints."""
    depth = np.zeros(model.nbody, int)
    for body in range(1, model.nbody):
        # Of bodies behind the same joints the last counts: frames are fixed to links, not links to frames.
        depth[body] = depth[model.body_parentid[body]] + 1000 * int(model.body_jntnum[body]) + 1
    named = [body for body in range(1, model.nbody) if model.body(body).name]
    return model.body(max(named, key=lambda body: depth[body])).name if named else ""
