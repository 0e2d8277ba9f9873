"""The demo: what it computes, and that it goes on without the handwriting."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

from skillfold.errors import MissingExtraError
from skillfold.experiments import demo


@pytest.fixture(scope="module")
def story():
    told = []
    made = demo.run(1, lambda stage, share: told.append((stage, share)), shapes=("Sshape",))
    return made, told


def test_every_chapter_plans_and_projects(story):
    chapters = story[0].chapters
    assert [chapter.name for chapter in chapters] == ["S", "three-link arm"]
    for chapter in chapters:
        facts = json.loads(json.dumps(chapter.facts()))
        assert facts["successful"] >= 1
        assert facts["projected_off"] < 1e-3 * facts["disturbed_off"]
        assert len(chapter.paths) == facts["successful"]


def test_handwriting_has_a_field_and_new_ends(story):
    chapter = story[0].chapters[0]
    n = demo.COARSE
    assert chapter.field.distance.shape == (n, n)
    assert chapter.field.inside.shape == (demo.FINE * n, demo.FINE * n)
    assert (chapter.field.distance >= 0).all()
    starts = np.array([states[0] for states in chapter.demonstrations])
    for path in chapter.paths:
        assert np.linalg.norm(starts - path[0], axis=1).min() > 0


def test_the_arm_beats_the_paper(story):
    facts = story[0].chapters[-1].facts()
    assert facts["successful"] == facts["plans"] == demo.PATHS
    assert facts["rmse"] < facts["paper_rmse"]


def test_the_tray_is_carried_past_the_box_and_stands_the_push(story):
    facts = json.loads(json.dumps(story[0].carrying.facts()))
    assert facts["plan_success"] and facts["replans"] >= 1 and facts["contacts"] == 0 and facts["clearance"] > 0
    assert facts["standing"]["skill"] == facts["tumblers"] > facts["standing"]["naive"]
    assert facts["peak_tilt"]["skill"] < facts["peak_tilt"]["naive"] / 5


def test_progress_goes_forward(story):
    shares = [share for _, share in story[1]]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] == 1.0


def test_without_the_handwriting_the_arm_remains(monkeypatch):
    def absent(multi_mode):
        raise MissingExtraError("not installed: pip install 'skillfold[data]'.")

    monkeypatch.setattr(demo, "lasa", absent)
    monkeypatch.setattr(demo, "PATHS", 3)
    monkeypatch.setattr(demo, "_compiled", nullcontext)
    monkeypatch.setattr(demo.tray_demo, "run", lambda rng: None)
    made = demo.run(0)
    assert [chapter.name for chapter in made.chapters] == ["three-link arm"]
    assert "skillfold[data]" in made.notes[0]
