"""Section VIII: pick-and-place against learnt dynamics and movement primitives."""

from pathlib import Path

from skillfold.experiments import pick_place, pick_place_poses
from skillfold.experiments.rows import Settings
from skillfold.viewing import pick_place_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result


def carried(settings: Settings, folder: Path) -> Result:
    """Tables III and IV, pick-and-place against learnt dynamics and primitives, orientations too."""
    compared = pick_place.compare(settings)
    rows = pick_place.rows(compared) + pick_place.training_rows(settings, pick_place.Counts().trainings)
    rows += pick_place_poses.measure(settings)
    settings.progress("drawing", 0.95)
    file = pick_place_pictures.draw(compared[0], folder / "pick_place.png")
    caption = "New starts and goals on a small and a large cube, by every method; the tunnel of the metric."
    return Result(rows, [Picture(file, "figures 29 to 32", caption)])


PICK_PLACE = {
    "pick-place": Experiment("Section VIII: pick-and-place against GMM/GMR (Tables III and IV)", "000", carried)
}
