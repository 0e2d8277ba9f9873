"""How options look in `--help`."""

from typing import Annotated, Any

import tyro

from skillfold.errors import InputError

Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
"""Off unless given."""


def shown(metavar: str, hint: str | None = None, told: str | None = None) -> Any:
    """An option whose value is called `metavar`; `hint` stands in place of its default.

    Help longer than a line is `told` here: the line breaks of a docstring would show.
    """
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=hint, help=told)


def seed(given: int) -> int:
    """A seed that NumPy takes.

    Raises:
        InputError: a negative one.
    """
    if given < 0:
        raise InputError(f"--seed {given}: expected a whole number, 0 or more.")
    return given
