"""Measuring in a process of its own: peak memory, cold imports. The answer comes back as JSON."""

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

from skillfold.errors import SkillfoldError

_CHILD = "import sys; from skillfold.experiments.alone import answer; answer(sys.argv[1], sys.argv[2])"


def alone(module: str, function: str, **arguments: Any) -> dict[str, float]:
    """What `module.function(**arguments)` returns in a fresh interpreter, and its peak memory in GB."""
    command = [sys.executable, "-c", _CHILD, f"{module}:{function}", json.dumps(arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise SkillfoldError(f"{function} failed in its own process: {last}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def answer(name: str, arguments: str) -> None:
    """The child's side: call, measure, write one line."""
    module, function = name.split(":")
    result = getattr(import_module(module), function)(**json.loads(arguments))
    sys.stdout.write(json.dumps({**result, "peak_memory_gb": peak_memory_gb()}) + "\n")


def peak_memory_gb() -> float:
    """Largest resident size of this process so far; NaN where the system does not tell."""
    try:
        # What Linux tells of a process's usage begins with the size of its parent; its status does not.
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e6
    except (OSError, StopIteration):
        pass
    try:
        import resource
    except ImportError:
        return float("nan")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e9 if sys.platform == "darwin" else 1e6)


def import_seconds(module: str = "skillfold") -> float:
    """Time of the import alone in a fresh interpreter, without the interpreter's own start."""
    code = (
        "from time import perf_counter as now; start = now(); "
        f"import {module}; import sys; sys.stdout.write(str(now() - start))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(done.stdout)


def seconds(work: Any, repeats: int = 1) -> list[float]:
    """Wall times of `repeats` calls of `work()`."""
    times = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return times
