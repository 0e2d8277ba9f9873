"""What is compiled ahead: silent, harmless where it fails, and found on disk by whoever needs it."""

import os
import subprocess
import sys

from skillfold import ahead

ASK = """
from skillfold.manifold import ahead
from skillfold.manifold.kernels.projection import bring_onto
ahead.project_onto_a_line()
print(sum(bring_onto.stats.cache_hits.values()), sum(bring_onto.stats.cache_misses.values()))
"""


def test_a_module_that_fails_is_passed_over(capfd):
    with ahead.running("skillfold.no_such_module"):
        pass
    assert capfd.readouterr() == ("", "")


def test_what_was_compiled_ahead_is_found_on_disk():
    with ahead.running("skillfold.manifold.ahead"):
        pass
    found = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True, timeout=300)
    if (os.cpu_count() or 1) > 1:
        assert found.stdout.split() == ["1", "0"]


def test_on_one_core_nothing_is_started(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    monkeypatch.setattr(ahead.subprocess, "Popen", None)
    with ahead.running("skillfold.manifold.ahead"):
        pass
