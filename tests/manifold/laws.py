"""What the laws of fitted skills share: skills of every kind, and states about them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

KINDS = ["sphere", "arm", "cylinder", "recorded"]
SURFACES = KINDS[:3]  # of one surface each; curves that differ leave it open which of them a state belongs to


class Skills(dict):
    """By kind; told in a word, or a failing law would print all their arrays."""

    def __repr__(self):
        return "skills"


def law(function, kinds=KINDS):
    """For any kind of skill and any seed."""
    seeds = st.integers(0, 2**32 - 1)
    return settings(max_examples=15, deadline=None)(given(kind=st.sampled_from(kinds), seed=seeds)(function))


def law_of_surfaces(function):
    return law(function, SURFACES)


def samples_of(skill):
    """The anchors, in state units; what is free at its middle."""
    model = skill.model
    return model.centre + model.scale * model.anchors @ model.kept.T


def states_about(skill, seed, count=5, spread=0.3):
    """States near the samples and off them, by up to some share of the skill's size."""
    rng = np.random.default_rng(seed)
    at = samples_of(skill)[rng.integers(0, skill.model.anchors.shape[0], count)]
    off = rng.normal(size=at.shape) * spread * rng.random((count, 1)) * skill.model.scale
    return at + off
