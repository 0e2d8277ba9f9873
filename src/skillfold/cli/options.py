"""How options look in `--help`."""

from typing import Annotated, Any

import tyro

Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
"""Off unless given."""


def shown(metavar: str, hint: str | None = None) -> Any:
    """An option whose value is called `metavar`; `hint` stands in place of its default."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=hint)
