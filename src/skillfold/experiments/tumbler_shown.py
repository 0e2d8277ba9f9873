"""What the picture after figure 16 shows: two runs of the KUKA arm in simulation, each pushed on its way."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.control.rollout import Rollout
from skillfold.experiments.tumbler_runs import BODIES, Trial, carry, trials

PUSHED = ("tool", "forearm")


@dataclass(frozen=True)
class Example:
    """A trial and what became of it under the reactive controller."""

    trial: Trial
    rollout: Rollout

    @property
    def title(self) -> str:
        """Of the push."""
        push = self.trial.push
        if push is None:
            return "not pushed"
        newtons = float(np.linalg.norm(push.force))
        body = {link: name for name, link in BODIES.items()}[str(push.body)]
        words = f"{body} pushed with {newtons:.0f} N for {push.duration:.2g} s"
        return f"{words}; {self.rollout.standing} of {self.rollout.tumblers.shape[1]} tumblers stand at the end"


def examples(skill: Any, rng: np.random.Generator) -> list[Example]:
    """A run for each body that is pushed, between random ends, under a random short push."""
    asked = [trials(skill, 1, rng, body)[0] for body in PUSHED]
    return [Example(trial, carry("skill", skill, trial)) for trial in asked]
