"""The page of a report: it needs nothing else, hides nothing, and shows text as text."""

import base64
import io
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from matplotlib import image

from skillfold.viewing.reproduced import page, report, running
from skillfold.viewing.reproduced.running import Asked
from viewing.stand_ins import experiments

VOID = {"meta", "img", "br", "hr"}


class Read(HTMLParser):
    """A page as a reader gets it: elements, text, and whether every element is closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.text = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.text.append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def words(self):
        return " ".join(" ".join(self.text).split())


SEEDED = Asked(seed=9)


def made(folder, every, asked=SEEDED):
    """The page of a run, as text and as read."""
    under_way = running.take_up(asked, every, folder)
    running.go_on(under_way, every, folder, lambda *_: lambda *_: None, lambda now: None)
    report.write(under_way, every, folder)
    text = (folder / "report.html").read_text(encoding="utf-8")
    return text, Read(text)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    every, _ = experiments("one", "two", "three", two={"raises": ValueError("no <way>")}, three={"measured": 0.95})
    return made(folder, every)


def test_it_is_whole_and_needs_nothing_else(drawn):
    text, read = drawn
    assert read.open == [] and text.startswith("<!doctype html>")
    assert not {tag for tag, _ in read.elements} & {"script", "link", "iframe", "object", "base"}
    assert not re.search(r"https?:|@import|url\(|\$", text.split("<body>")[0])
    assert all(attributes["href"].startswith("#") for attributes in read.all("a"))
    assert not [name for _, attributes in read.elements for name in attributes if name.startswith("on")]
    assert "width=device-width" in str(read.all("meta"))


def test_links_lead_somewhere(drawn):
    _, read = drawn
    ids = [attributes["id"] for _, attributes in read.elements if "id" in attributes]
    assert len(set(ids)) == len(ids)
    assert {attributes["href"][1:] for attributes in read.all("a")} <= set(ids)
    assert {"summary", "missed", "one", "two", "three", "machine"} <= set(ids)


def test_pictures_are_inside(drawn):
    _, read = drawn
    pictures = read.all("img")
    assert len(pictures) == 2
    for attributes in pictures:
        kind, data = attributes["src"].split(",")
        assert kind == "data:image/png;base64"
        assert image.imread(io.BytesIO(base64.b64decode(data, validate=True))).shape[:2] == (1, 2)
        assert (attributes["width"], attributes["height"]) == ("2", "1")
        assert attributes["alt"].startswith("What ")
    assert "After figures 2 and 3 of the paper." in read.words


def test_what_is_not_reached_is_told_in_words_before_the_tables(drawn):
    text, read = drawn
    assert text.index('id="missed"') < text.index('id="one"')
    told = read.words.split("What is not reached")[1].split("Section I: one")[0]
    assert "one : one reached: 0.5 share , target ≥ 0.9; in the paper 0.95." in told
    assert "one : absent: not measured , target ≤ 1. no data." in told
    assert "one : endless: ∞ s , target ≤ 1." in told
    assert "two : ended with an error. ValueError: no <way>" in told
    assert "three reached" not in told and "beside" not in told


def test_verdicts_are_told_by_word_and_sign(drawn):
    _, read = drawn
    assert "✓ met" in read.words and "✗ missed" in read.words and "? not measured" in read.words
    assert "12345 N" in read.words


def test_counts_are_those_of_the_rows(drawn):
    _, read = drawn
    assert "3 targets met 3 targets missed 2 targets not measured 2 figures without target" in read.words


def test_each_experiment_tells_paper_seed_and_what_differs(drawn):
    _, read = drawn
    told = read.words.split("Section I: three")[-1]
    assert "Havoutis and Ramamoorthy" in told and "seed 9" in told
    assert "What differs, and why three has other weights." in told


def test_it_tells_machine_versions_and_how_to_run_it_again(tmp_path):
    every, _ = experiments("one", "two")
    folder = tmp_path / "a folder"
    folder.mkdir()
    _, read = made(folder, every, Asked(names=("two",), seed=9, quick=True, data=folder))
    facts = running.machine()
    assert f"numpy {facts['packages']['numpy']}" in read.words and facts["python"] in read.words
    again = f"skillfold reproduce two --quick --data '{folder}' --seed 9 --fresh --out '{folder}'"
    assert again in read.words
    assert "few trials" in read.words
    assert "Not in this report, because not run, or not yet: one Section I: one" in read.words


def test_text_is_shown_as_text(tmp_path):
    spiteful = "</td></table><script>alert(1)</script> & \" ' <img src=x onerror=y>"
    every, counted = experiments("one", one={"note": spiteful})
    every = {"one": replace(every["one"], title=spiteful, differs=(spiteful,))}
    counted["one"].measured = float("nan")
    text, read = made(tmp_path, every)
    assert read.open == [] and "<script" not in text and len(read.all("img")) == 1
    assert read.words.count(spiteful) >= 4
    assert "no number" in read.words


def test_a_report_of_nothing_can_be_read(tmp_path):
    every, _ = experiments("one", one={"raises": ValueError("")})
    under_way = running.take_up(Asked(), every, tmp_path)
    report.write(under_way, every, tmp_path)
    read = Read((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert read.open == [] and "0 targets met" in read.words
    assert "What is not reached" not in read.words


def test_praise_only_where_all_is_met(tmp_path):
    every, counted = experiments("one")
    answer = counted["one"]
    whole = replace(every["one"], run=lambda settings, folder: best(answer(settings, folder)))
    _, read = made(tmp_path, {"one": whole})
    assert "Every target in this report is met." in read.words


def best(result):
    return replace(result, rows=[row for row in result.rows if row.met])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (0.0, "0"),
        (200.0, "200"),
        (0.12345, "0.123"),
        (12345.678, "12346"),
        (3e6, "3e+06"),
        (-float("inf"), "−∞"),
    ],
)
def test_figures_have_few_digits(value, text):
    assert page.figure(value) == text
