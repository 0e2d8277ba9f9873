"""What samples tell, whatever is handed over: `Clock`, seconds that go on all the same, and `read_sample`."""

from typing import Any

import numpy as np

from skillfold.motion import Array

NOMINAL = 1e-3  # seconds between samples where their times tell nothing
SLOWEST = 1.0  # seconds between samples for which gains are eased, at most
GAP = 0.055  # seconds between samples that are too many: at 20 Hz one may be a little late


class Clock:
    """Time by the samples.

    Attributes:
        time: of the last sample that told one [s], or None.
        now: seconds that have passed.
        interval: seconds between the last two samples.
    """

    def __init__(self) -> None:
        self.time: float | None = None
        self.now = self.interval = 0.0

    def tick(self, t: Any) -> tuple[float, bool]:
        """Seconds since the last sample, and whether time does not go on as it should."""
        elapsed, strange = self._elapsed(t)
        self.now += elapsed
        return elapsed, strange

    def _elapsed(self, t: Any) -> tuple[float, bool]:
        try:
            time = float(t)
        except Exception:  # whatever was handed over
            return NOMINAL, True
        last = self.time
        if not -1e12 < time < 1e12:
            return NOMINAL, True
        self.time = time
        if last is None:
            return 0.0, False
        elapsed = time - last
        if elapsed > 0.0:
            self.interval = min(elapsed, SLOWEST)
        return (elapsed, False) if 0.0 <= elapsed <= GAP else (NOMINAL, True)


def read_sample(given: tuple[Any, Any], own: tuple[Array, Array]) -> bool:
    """Copy positions and velocities (D,); False where they are none of that shape."""
    try:
        for values, kept in zip(given, own, strict=True):
            array = np.asarray(values)
            if array.shape != kept.shape or array.dtype.kind not in "iuf":
                return False
            kept[:] = array
    except Exception:  # the robot must be held
        return False
    return True
