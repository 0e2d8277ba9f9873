"""Section VII: the Nao balances on one leg, steps and walks."""

from pathlib import Path

from skillfold.experiments import nao_balance, nao_stepping
from skillfold.experiments.rows import Settings
from skillfold.viewing import nao_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result


def balance(settings: Settings, folder: Path) -> Result:
    """Table II, a Nao that balances on one leg."""
    tables = nao_balance.run(settings, nao_balance.Counts())
    rows = nao_balance.rows(tables, settings)
    settings.progress("drawing", 0.95)
    file = nao_pictures.draw_balance(tables[0], folder / "nao_balance.png")
    caption = "Where the swing foot was shown and where projections put it; random poses and their projections."
    return Result(rows, [Picture(file, "figures 25 and 26", caption)])


def stepping(settings: Settings, folder: Path) -> Result:
    """Steps of a Nao, past obstacles, and ten in a row."""
    found = nao_stepping.run(settings, nao_stepping.Counts())
    settings.progress("drawing", 0.95)
    file = nao_pictures.draw_stepping(found, folder / "nao_stepping.png")
    caption = "Swings shown and new, their times, swings past obstacles, and a walk of ten random steps."
    return Result(nao_stepping.rows(found), [Picture(file, "figures 18 to 22", caption)])


NAO = {
    "nao-balance": Experiment("Section VII-C: a Nao balances on one leg (Table II)", "000", balance),
    "nao-stepping": Experiment("Sections VII-A and VII-B: steps of a Nao, ten in a row", "000", stepping),
}
