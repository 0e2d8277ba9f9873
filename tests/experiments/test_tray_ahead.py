"""What is compiled ahead of the demo's tray is all that the tray needs."""

import subprocess
import sys

ASK = """
import sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from skillfold.experiments import demo, tray_demo

def ready():
    modules = [module for name, module in sys.modules.items() if name.startswith("skillfold")]
    found = {f for module in modules for f in vars(module).values() if isinstance(f, Dispatcher)}
    return {(f.py_func.__name__, signature) for f in found for signature in f.signatures}

with demo._compiled(lambda stage, share: None):
    pass
before = ready()
tray_demo.run(np.random.default_rng(0))
print(len(before), *{name for name, _ in ready() - before})
"""


def test_the_tray_finds_everything_compiled():
    ask = [sys.executable, "-W", "ignore", "-c", ASK]
    count, *missing = subprocess.run(ask, capture_output=True, text=True, timeout=300, check=True).stdout.split()
    assert int(count) > 20
    assert missing == []
