"""Section VII: the Nao balances on one leg, steps and walks."""

from pathlib import Path

from skillfold.experiments import nao_balance, nao_balance_rows, nao_stepping
from skillfold.experiments.rows import Settings
from skillfold.viewing import nao_around_pictures, nao_balance_pictures, nao_step_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result


def balance(settings: Settings, folder: Path) -> Result:
    """Table II, a Nao that balances on one leg."""
    tables = nao_balance.run(settings, nao_balance.Counts.of(settings))
    settings.progress("drawing", 0.95)
    files = nao_balance_pictures.draw(tables[0], folder)
    return Result(nao_balance_rows.rows(tables), _pictures(files, BALANCE))


def stepping(settings: Settings, folder: Path) -> Result:
    """Steps of a Nao, past obstacles, and ten in a row."""
    found = nao_stepping.run(settings, nao_stepping.Counts.of(settings))
    settings.progress("drawing", 0.95)
    files = *nao_step_pictures.draw(found, folder), *nao_around_pictures.draw(found.around, folder)
    return Result(nao_stepping.rows(found), _pictures(files, STEPPING))


def _pictures(files: tuple[Path | None, ...], told: tuple[tuple[str, str], ...]) -> list[Picture]:
    """Those that could be drawn, with the paper's figures and a caption."""
    return [Picture(file, *told) for file, told in zip(files, told, strict=True) if file is not None]


BALANCE = (
    ("figure 25", "Foot positions drawn from the box of Equation 24: within reach, out of it, and of projections."),
    ("figure 26", "Random poses, grey, and their projections onto the learnt manifold, black."),
    ("figure 27", "Snapshots of the geodesics through these projections, one after the other."),
    ("", "Table II: errors of projections, times, and who stands on a pedestal, on the floor, and with it known."),
)
STEPPING = (
    ("figure 18", "Neighbourhood graphs of both swing feet's samples, and the swings they come from."),
    ("figure 19", "New swings of both feet between starts, heights and goals that were not shown."),
    ("figure 20", "Errors along new steps, and the time of a step, planned and optimised."),
    ("figure 21", "A walk of random steps: swings, places of the feet, and the torso's way in dynamics."),
    ("figure 22", "Swings planned past balls and edges that the plain geodesics run into."),
    ("figures 23 and 24", "Snapshots of one of them: the plain geodesic above, the way planned around below."),
)

NAO = {
    "nao-balance": Experiment(
        "Section VII-C: a Nao balances on one leg (Table II)",
        "000",
        balance,
        (
            "No robot: stable is what both judges call stable, the centre of mass over the sole and two seconds of "
            "servos in MuJoCo's dynamics. Poses in which parts of the robot overlap are judged like all others, and "
            "counted. Ten poses of each geodesic are held so, one by one; whole geodesics are played as motions "
            "besides, which is harder: a foot that skims the ground stands there, but stumbles when it is dragged.",
            "The paper's robot stands on the ground; neither its demonstrations nor its projection know of it. Feet "
            "that end in the floor topple the robot, so the same is judged on a pedestal, on flat ground, and on "
            "flat ground with states led out of floor and robot and geodesics planned around both.",
            "The cost of the paper's optimiser is told in words; how high the pelvis is, it leaves open, so a weak "
            "pull toward the home pose settles it here. About one in five foot positions of Equation 24 is in reach.",
            "The paper does not tell how many poses it learnt from: here 1000, and beside that 500, as for steps.",
            "Times are of one thread on compiled kinematics, where a pose is optimised in milliseconds; the paper's "
            "took 38 s, so its factors are not to be had. The factor against the like of its optimiser, finite "
            "differences, stands beside the paper's, the one against analytic derivatives beside the target.",
        ),
    ),
    "nao-stepping": Experiment(
        "Sections VII-A and VII-B: steps of a Nao, ten in a row",
        "000",
        stepping,
        (
            "Skills are learnt with the defaults of a user, where the paper sets dimension 4 and 20 kernels.",
            "A new step is asked by start, height half way and goal; the paper does not tell how heights are asked.",
            "Obstacles are balls and edges on the floor between the places of the foot; the foot is raised before it "
            "swings and lowered after, because the floor is an obstacle too.",
            "Walks are played in MuJoCo's dynamics by servos that nothing is fed back to, not by a robot.",
            "Times are of one thread; twenty poses take a tenth of a second to optimise here, 45 s in the paper.",
        ),
    ),
}
