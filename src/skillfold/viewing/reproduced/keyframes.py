"""Paper 002: envelopes, the two tasks, and the cost of the first path."""

from pathlib import Path

from skillfold.experiments import keyframe_cost, keyframe_demo, keyframe_motions, keyframe_runs, keyframes
from skillfold.experiments.rows import Settings
from skillfold.viewing import keyframe_costs, keyframe_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result

DRAWS, STARTS = 12, 4  # of demonstrations, and on each, of tasks


def shapes(settings: Settings, folder: Path) -> Result:
    """Envelopes in the plane and in space, whole and reduced; what the gates hold."""
    rows = keyframes.learning(settings)
    settings.progress("drawing", 0.95)
    file = keyframe_costs.draw_envelopes(keyframes.learn(settings, 1), folder / "envelopes.png")
    return Result(rows, [Picture(file, "figures 2 and 3", "Soft-Envelopes, whole and reduced.")])


def paths(settings: Settings, folder: Path) -> Result:
    """Both tasks, planned in the whole and in the reduced envelope."""
    skills = keyframes.learn(settings, DRAWS)
    found = keyframe_runs.answers(skills, STARTS, settings)
    rows = [*keyframe_runs.first_rows(found), *keyframe_runs.inside_rows(found)]
    rows += keyframe_motions.turned_rows(skills, STARTS, settings)
    settings.progress("drawing", 0.9)
    file, _ = keyframe_pictures.draw(keyframe_demo.run(settings.seed), folder / "keyframes.png")
    return Result(rows, [Picture(file, "figures 5 to 8", "Both tasks in the whole and in the reduced envelope.")])


def first_paths(settings: Settings, folder: Path) -> Result:
    """Nodes and run time of the algorithm as printed and as it is here."""
    found = keyframe_cost.run(keyframes.learn(settings, 1), settings)
    file = keyframe_costs.draw_costs(found, folder / "keyframe_cost.png")
    return Result(keyframe_cost.rows(found), [Picture(file, "figure 9", "Nodes and run time, as printed and here.")])


KEYFRAMES = {
    "envelopes": Experiment("Section III-B: Soft-Envelopes and what they hold", "002", shapes),
    "keyframes": Experiment("Section V: both tasks in the whole and in the reduced envelope", "002", paths),
    "keyframe-cost": Experiment("Section V: nodes and run time of the first path", "002", first_paths),
}
