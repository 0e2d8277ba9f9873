"""Every error that skillfold raises about what it was given.

One root, few kinds. A message says what was given, what was expected, and what is possible.
A plan that cannot be made is no error: it is a `Plan` with `success=False` and a reason.
"""


class SkillfoldError(Exception):
    """Root of every error about input; the command line prints it as one line and exits with 2."""


class InputError(SkillfoldError, ValueError):
    """An argument that cannot be used: wrong shape, not finite, out of range, unknown name."""


class RecordingError(InputError):
    """A recording that cannot be used; names the file or demonstration, row, column and value."""


class DisconnectedError(SkillfoldError):
    """Samples that fall into parts too far from each other to lie on one manifold."""


class SkillFileError(SkillfoldError):
    """A saved skill that is damaged, of another format, or not a skill at all."""


class RobotError(SkillfoldError):
    """A robot that cannot be used: an unknown name, a damaged file, a missing mesh, joints of other kinds."""


class SceneError(InputError):
    """An obstacle or scene that cannot be used; names the obstacle, the value and what was expected."""


class MissingExtraError(SkillfoldError, ImportError):
    """An optional package that is not installed; names the extra that brings it."""
