"""`skillfold demo keyframes`: learn, plan and draw both keyframe tasks; one table."""

from pathlib import Path
from time import perf_counter
from typing import Any

from skillfold.cli import console

LEGEND = (
    "α: percent of the variance that is kept; way: until the first path was there; plan: until it was short "
    "and checked; medians. outside, touching: of states every 0.005 rad, judged apart from the planner."
)


def show(seed: int, folder: Path, json: bool) -> int:
    """Learn, plan, draw, report."""
    from skillfold.experiments import keyframe_demo
    from skillfold.viewing.keyframe_pictures import draw

    begun = perf_counter()
    with console.progress() as progress, console.quiet():
        story = keyframe_demo.run(seed, progress)
        progress("drawing", 1.0)
        picture, note = draw(story, folder / "keyframes.png")
    facts: dict[str, Any] = {
        "tasks": story.facts(),
        "notes": [note] if note else [],
        "pictures": [str(picture)],
        "seconds": perf_counter() - begun,
    }
    if note:
        console.say(f"note: {note}")
    console.report(facts, json, *_tables(facts))
    return 0


def _tables(facts: dict[str, Any]) -> list[Any]:
    columns = ("task", "α", "fit", "plans", "way", "plan", "nodes", "length", "gates", "outside", "touching")
    sides = dict.fromkeys(columns, "right") | {"task": "left"}
    table = console.table(
        "Learnt from seven demonstrations, planned past what was not there", sides, map(_cells, facts["tasks"])
    )
    return [table, LEGEND, f"{facts['seconds']:.0f} s; picture: {facts['pictures'][0]}"]


def _cells(told: dict[str, Any]) -> list[str]:
    return [
        told["task"],
        f"{told['alpha']:g}",
        f"{told['fit_seconds']:.2g} s",
        f"{told['solved']} of {told['plans']}",
        _or_dash(told["first_seconds"], lambda value: f"{1e3 * value:.1f} ms"),
        _or_dash(told["plan_seconds"], lambda value: f"{1e3 * value:.1f} ms"),
        _or_dash(told["nodes"], lambda value: f"{value:.0f}"),
        _or_dash(told["length"], lambda value: f"{value:.2f} rad"),
        _or_dash(told["gate_factor"], lambda value: f"× {value:g}"),
        f"{told['outside']} of {told['states']}",
        str(told["touching"]),
    ]


def _or_dash(value: float | None, shown: Any) -> str:
    return "–" if value is None else shown(value)
