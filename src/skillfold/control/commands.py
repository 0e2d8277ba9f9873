"""What controllers answer."""

from typing import NamedTuple

from skillfold.motion import Array

MODES = ("tracking", "returning", "replanned", "holding")


class Command(NamedTuple):
    """What the robot shall do now.

    Attributes:
        torque: (D,) [N m, N]; None where the controller knows no robot.
        mode: "tracking" the plan; "returning" from a push; "replanned", on a later plan; "holding" still, for want
            of good samples.
        acceleration: (D,), what the torque is for.
        reference: (3, D) position, velocity, acceleration that is followed.
        distance: from the manifold; from the path, where that is gone back to straight.
        deviation: from the reference along the manifold.
        clearance: from obstacles; infinite without any.
    """

    torque: Array | None
    mode: str
    acceleration: Array
    reference: Array
    distance: float
    deviation: float
    clearance: float
