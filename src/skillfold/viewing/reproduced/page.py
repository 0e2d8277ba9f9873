"""The report as one HTML page that needs nothing else: pictures and style inside, no scripts."""

from base64 import b64encode
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files
from itertools import groupby
from math import isfinite
from pathlib import Path
from string import Template
from typing import Any

from skillfold.viewing import style
from skillfold.viewing.reproduced import stored

SIGNS = {"<=": "≤", ">=": "≥", "==": "="}
MARKS = {"met": "✓", "missed": "✗", "not measured": "?", "without target": ""}
COLUMNS = ("what", "measured", "target", "verdict", "in the paper", "note")
Facts = Mapping[str, Any]


def page(told: Facts, folder: Path) -> str:
    """The page of a report, given its facts and the folder of its pictures."""
    title = "Two papers, repeated"
    body = [_opening(title, told), _summary(told), _missed(told)]
    body += [_experiment(part, told, folder) for part in told["experiments"]]
    head = [
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        _tag("title", f"skillfold: {title.lower()}"),
        f"<style>{_style()}</style>",
    ]
    whole = ["<!doctype html>", '<html lang="en"><head>', *head, "</head><body><main>", *body, _closing(told)]
    return "\n".join([*whole, "</main></body></html>\n"])


def figure(value: float | None) -> str:
    """A figure in three digits; whole numbers, and those above a thousand, in full."""
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞" if value > 0 else "−∞" if value < 0 else "no number"
    whole = value == round(value) or abs(value) >= 1e3
    return f"{value:.0f}" if whole and abs(value) < 1e6 else f"{value:.3g}"


def measured(row: Facts) -> str:
    """What was measured, with its unit."""
    return figure(row["measured"]) + (f" {row['unit']}" if row["measured"] is not None and row["unit"] else "")


def target(row: Facts) -> str:
    """What a row must reach, in the unit of what was measured; empty where nothing."""
    if row["target"] is None:
        return ""
    return f"{SIGNS.get(row['comparison'], row['comparison'])} {figure(row['target'])}"


def _style() -> str:
    css = files("skillfold.viewing.reproduced").joinpath("page.css").read_text(encoding="utf-8")
    colours = {
        "ink": style.INK,
        "faint": style.FAINT,
        "met": style.ON,
        "missed": style.PLANS[0],
        "link": style.TUNNEL,
    }
    return Template(css).substitute(colours)


def _tag(name: str, text: str, **attributes: str) -> str:
    """An element around text that is escaped."""
    return _wrap(name, escape(text), **attributes)


def _wrap(name: str, inner: str, **attributes: str) -> str:
    """An element around HTML; `class_` stands for class, `data_label` for data-label."""
    told = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"' for key, value in attributes.items())
    return f"<{name}{told}>{inner}</{name}>"


def _list(items: Iterable[str]) -> str:
    """A list of HTML; nothing where there are no items."""
    inner = "".join(f"<li>{item}</li>" for item in items)
    return f"<ul>{inner}</ul>" if inner else ""


def _opening(title: str, told: Facts) -> str:
    trials = "few trials of everything, for a first look" if told["quick"] else "all trials"
    lede = (
        "The experiments of two papers, repeated with the library as a user gets it. What was measured on the "
        "machine told at the end stands beside what the library means to reach and what the papers print. "
        f"Seed {told['seed']}, {trials}."
    )
    look = "<p>With few trials, shares and means scatter: this is a look, not a measurement.</p>"
    absent = _list(f"{_tag('code', name)} {escape(text)}" for name, text in told["absent"].items())
    asides = [look] if told["quick"] else []
    asides += [f"<p>Not in this report, because not run, or not yet:</p>{absent}"] if absent else []
    shaded = "".join(_wrap("div", aside, class_="aside") for aside in asides)
    return _wrap("header", _tag("h1", title) + _tag("p", lede, class_="lede") + shaded)


def _summary(told: Facts) -> str:
    counts = told["targets"]
    words = ("targets met", "targets missed", "targets not measured", "figures without target")
    numbers = "".join(
        _wrap("div", _tag("b", str(count)) + _tag("span", text), class_=_class(verdict) if count else "none")
        for (verdict, count), text in zip(counts.items(), words, strict=True)
    )
    head = "".join(_tag("th", text, scope="col") for text in ("experiment", *counts, "seconds"))
    groups = (
        _tag("th", paper, scope="rowgroup", colspan="6", class_="note") + "</tr>" + "".join(map(_summary_line, parts))
        for paper, parts in groupby(told["experiments"], lambda part: part["paper"])
    )
    body = "".join(f"<tbody><tr>{group}</tbody>" for group in groups)
    table = f"<table><thead><tr>{head}</tr></thead>{body}</table>" if body else ""
    return _wrap("section", f"<h2>Summary</h2>{_wrap('div', numbers, class_='counts')}{table}", id="summary")


def _summary_line(part: Facts) -> str:
    cells = [_wrap("td", _tag("a", part["title"], href=f"#{part['name']}"), data_label="experiment")]
    if part["failed"] is not None:
        return f"<tr>{cells[0]}{_tag('td', '✗ ended with an error', colspan='5', class_='missed')}</tr>"
    cells += [
        _tag("td", str(count) if count else "·", data_label=key, class_=f"number {_class(key) if count else 'empty'}")
        for key, count in part["targets"].items()
    ]
    cells.append(_tag("td", f"{part['seconds']:.0f}", data_label="seconds", class_="number"))
    return f"<tr>{''.join(cells)}</tr>"


def _missed(told: Facts) -> str:
    """Every target that is not met, in words: the reader should not have to look for them."""
    parts = told["experiments"]
    lines = [f"{_link(part)}: ended with an error. {escape(part['failed'])}" for part in parts if part["failed"]]
    wanting = [(part, row) for part in parts for row in part["rows"] if row["verdict"] in ("missed", "not measured")]
    lines += [f"{_link(part)}: {_sentence(row)}" for part, row in wanting]
    if not lines and not told["targets"]["met"]:
        return ""  # nothing is judged: neither praise nor blame
    inner = _list(lines) or "<p>Every target in this report is met.</p>"
    return _wrap("section", f"<h2>What is not reached</h2>{inner}", id="missed")


def _link(part: Facts) -> str:
    return _tag("a", part["name"], href=f"#{part['name']}")


def _sentence(row: Facts) -> str:
    got = "not measured" if row["verdict"] == "not measured" else measured(row)
    beside = f", target {target(row)}" + (f"; in the paper {row['paper']}" if row["paper"] else "")
    note = f" {row['note'].rstrip('.')}." if row["note"] else ""
    return f"{escape(row['name'])}: {_tag('strong', got)}{escape(beside)}.{_tag('span', note, class_='note')}"


def _experiment(part: Facts, told: Facts, folder: Path) -> str:
    took = "" if part["seconds"] is None else f" · {part['seconds']:.0f} s"
    meta = f"{part['paper']} · {part['name']} · seed {told['seed']}{took}"
    blocks = [_tag("h2", part["title"]), _tag("p", meta, class_="meta")]
    if part["failed"] is not None:
        blocks.append(_tag("p", f"✗ Ended with an error. {part['failed']}", class_="failed"))
    if part["differs"]:
        differs = "<h3>What differs, and why</h3>" + _list(map(escape, part["differs"]))
        blocks.append(_wrap("div", differs, class_="aside"))
    blocks += [_table(part["rows"])] if part["rows"] else []
    blocks += [_figure(picture, folder) for picture in part["pictures"]]
    return _wrap("section", "\n".join(blocks), id=part["name"])


def _table(rows: Iterable[Facts]) -> str:
    """A table of what was measured; columns that would stand empty are left out."""
    cells = [_cells(row) for row in rows]
    shown = [column for column in COLUMNS if any(told[column] for told in cells)]
    head = "".join(_tag("th", column, scope="col") for column in shown)
    body = "\n".join(f"<tr>{''.join(_cell(column, told[column]) for column in shown)}</tr>" for told in cells)
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


def _cells(row: Facts) -> dict[str, str]:
    verdict = row["verdict"]
    told = f"{MARKS[verdict]} {verdict}" if verdict != "without target" else ""
    return dict(zip(COLUMNS, (row["name"], measured(row), target(row), told, row["paper"], row["note"]), strict=True))


def _cell(column: str, text: str) -> str:
    if column == "what":
        return _tag("th", text, scope="row")
    kinds = {"measured": "number", "target": "number", "note": "note"}
    kind = _class(text.split(" ", 1)[-1]) if column == "verdict" and text else kinds.get(column, "text")
    return _tag("td", text, data_label=column, class_=kind if text else f"{kind} empty")


def _class(verdict: str) -> str:
    return verdict.replace(" ", "-")


def _figure(picture: Facts, folder: Path) -> str:
    data = stored.png(folder / picture["file"])
    width, height = (str(int.from_bytes(data[at : at + 4], "big")) for at in (16, 20))  # of the PNG's first chunk
    source = f"data:image/png;base64,{b64encode(data).decode()}"
    image = f'<img alt="{escape(picture["caption"])}" width="{width}" height="{height}" src="{source}">'
    after = f"After {picture['figures']} of the paper." if picture["figures"] else ""
    caption = f"{_tag('b', after)} {escape(picture['caption'])}" if after else escape(picture["caption"])
    return _wrap("figure", image + _wrap("figcaption", caption))


def _closing(told: Facts) -> str:
    machine, data = told["machine"], told["data"]
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    facts = {
        "machine": f"{machine['system']}, {machine['cores']} cores",
        "python": machine["python"],
        "packages": packages,
        "recordings": data or "those that come with the library or are drawn",
        "seed": str(told["seed"]),
        "seconds": f"{told['seconds']:.0f} in all, as long as the runs lasted here",
    }
    terms = "".join(_tag("dt", name) + _tag("dd", text) for name, text in facts.items())
    again = "<p>To measure all of this again, with the same seed:</p>" + _wrap("pre", _tag("code", told["again"]))
    return _wrap("footer", f"<h2>Machine, versions, seed</h2><dl>{terms}</dl>{again}", id="machine")
