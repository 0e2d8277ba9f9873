"""The papers' experiments repeated: each gives rows beside the paper's figures, and pictures of the same data."""

from skillfold.viewing.reproduced.arms import ARMS
from skillfold.viewing.reproduced.keyframes import KEYFRAMES
from skillfold.viewing.reproduced.nao import NAO
from skillfold.viewing.reproduced.pick_place import PICK_PLACE
from skillfold.viewing.reproduced.result import Experiment

EXPERIMENTS: dict[str, Experiment] = {**ARMS, **NAO, **PICK_PLACE, **KEYFRAMES}
