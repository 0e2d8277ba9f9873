"""Section VIII: pick-and-place against learnt dynamics and movement primitives."""

from dataclasses import replace
from pathlib import Path

from skillfold.experiments import pick_place, pick_place_poses, pick_place_rows
from skillfold.experiments.pick_place_rows import DIM
from skillfold.experiments.pick_place_sets import recorded
from skillfold.experiments.rows import Row, Settings
from skillfold.viewing import pick_place_pictures, tunnel_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result

DIFFERS = (
    "The paper's recordings of the iCub could not be found: a set of their shape is drawn, and handwriting (LASA) "
    "and, with a data folder, a bottle put on a shelf stand beside it. Recordings of your own in the folder's "
    "pick_place/ take its place.",
    "In sets of two coordinates a cube is a square of 9 places.",
    "The small cube about the goal lies within the hundredth of the way at which a motion counts as there, so "
    "learnt dynamics reach it without knowing of it.",
    "The dimension is what the fit chooses, 1 or 2 by the set; 1 with five kernels, as in the paper, where "
    "training is timed and for the picture of the metric.",
    "Plans follow the route that whole recordings take between such ends, not the paper's shortest path.",
    "Reaching the goal is by construction for a method that is given both ends, so shapes are measured too, the "
    "ends left out; primitives (DMP), which reach it by construction as well, stand beside.",
    "The mean of the recordings' shapes has the least distance from all of them that there can be, and a "
    "primitive imitates just that mean: a route that goes with its start is not below it in every set, and where "
    "the ends decide the shape, as in GShape, far above. What a recording left out would have done is told as "
    "well.",
    "The GMM/GMR code of the paper is not used but the `gmr` package's: its share of goals reached depends on the "
    "set, and goals that change are asked of it as they are. It has as many Gaussians as an information criterion "
    "asks for, five where time is measured and for a first look.",
    "Times are of this machine; only their order compares with the paper's. The manifold learns on all cores, so "
    "seconds of the processor stand beside those of the clock.",
    "Orientations, which the paper leaves out, are planned together with positions, and measured as these are: "
    "by the shape of the turn, the even turn between its own ends left out, and against a recording left out. How "
    "far orientations are off all the recordings is told without a target. From starts that are turned a primitive "
    "turns back to the mean of the recordings sooner than a plan does, and is nearer to them all; but what makes the "
    "made sets turns back evenly, and is farther from them than either.",
)


def carried(settings: Settings, folder: Path) -> Result:
    """Tables III and IV, pick-and-place against learnt dynamics and primitives, orientations too."""
    compared = pick_place.compare(settings)
    sets = [each.motions for each in compared]
    rows = pick_place_rows.rows(compared) + pick_place_rows.training_rows(sets[0], settings)
    rows += pick_place_poses.pose_rows(sets, settings) + _absent(settings)
    settings.progress("drawing", 0.92)
    return Result(rows, _pictures(compared[0], settings, folder))


def _pictures(shown: pick_place.Compared, settings: Settings, folder: Path) -> list[Picture]:
    # The metric is the paper's: of a curve, by five kernels.
    curve = settings.learn(list(shown.motions.recordings), dim=DIM, kernels=pick_place.KERNELS)
    data = pick_place_pictures.draw_data(shown, folder / "pick_place_data.png")
    starts = pick_place_pictures.draw_moved(shown, "start", folder / "pick_place_starts.png")
    goals = pick_place_pictures.draw_moved(shown, "goal", folder / "pick_place_goals.png")
    tunnel = tunnel_pictures.draw(replace(shown, skill=curve), folder / "pick_place_tunnel.png")
    return [
        Picture(data, "figure 28", "The recordings, and the neighbourhood graph over their states."),
        Picture(starts, "figures 29 and 30", "From the places of a small and of a large cube about a start."),
        Picture(goals, "figure 31", "To the places of a small and of a large cube about the goal."),
        Picture(tunnel, "figure 32", "Distance from the manifold: the tunnel it makes around the recordings."),
    ]


def _absent(settings: Settings) -> list[Row]:
    """A row where no recordings of others are at hand."""
    note = "pip install 'skillfold[data]' for the LASA recordings"
    return [] if recorded(settings.data) else [Row("Table IV: recorded sets", None, note=note)]


PICK_PLACE = {
    "pick-place": Experiment(
        "Section VIII: pick-and-place against GMM/GMR (Tables III and IV)", "000", carried, DIFFERS
    )
}
