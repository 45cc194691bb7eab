"""`softlimb report`: what it calls true is confirmed twice, what a method cannot do is said, nothing is lost.

No test here says how fast anything is.
"""

from __future__ import annotations

import csv
import dataclasses
import functools
import re
import sys
from html.parser import HTMLParser
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from softlimb.bench.clock import Clock, Samples
from softlimb.cli import main
from softlimb.report import measure as measuring
from softlimb.report.files import COLUMNS, write_scene
from softlimb.report.limbs import LimbScene
from softlimb.report.measure import Measured, Row, measure
from softlimb.report.methods import (
    CONSTANT_CURVATURE,
    LEAST_SQUARES,
    OURS,
    PAPER,
    PAPER_CONSTANTS,
    SHOOTING,
    SOLVE_BVP,
    Method,
    NoAnswer,
    Prepared,
    Reference,
    Setting,
)
from softlimb.report.page import HEADINGS, Page, as_html, as_markdown, cells
from softlimb.report.picture import draw, troubles
from softlimb.report.scenes import SCENES
from softlimb.report.tubes import TubeScene

NAMES = [scene.name for scene in SCENES]


@functools.cache
def prepared(name: str) -> Prepared:
    (scene,) = [scene for scene in SCENES if scene.name == name]
    return scene.prepare(quick=True)


def rows_of(name: str, *methods: str, limit: float = 60.0) -> dict[str, list[Row]]:
    """Some methods of a scene, measured; `limit` is for the machine that is busy, not for the test."""
    ready, clock = prepared(name), Clock(budget=0.0)
    return {
        method.name: list(measuring._rows(method, ready.reference, clock, limit))
        for method in ready.methods
        if method.name in methods
    }


# --- the scenes and what is true there -------------------------------------------------------------------------------


def test_four_kinds_of_scene_come_in_three_grades() -> None:
    kinds, grades = ("tube", "cantilever", "segment", "limb"), ("mild", "stiff", "extreme")
    assert NAMES == [f"{kind}-{grade}" for kind in kinds for grade in grades]
    assert len({scene.what for scene in SCENES}) == len(SCENES)


@pytest.mark.parametrize("name", NAMES)
def test_two_methods_agree_and_ours_keeps_its_tolerance(name: str) -> None:
    ready = prepared(name)
    # What a report asks for; a quick one, whose second method has fewer halvings, sees 1e-12 and less.
    assert ready.reference.agreement <= measuring.DISAGREEMENT
    assert len(set(ready.reference.names)) == 2
    (ours,) = [method for method in ready.methods if method.name == OURS]
    assert ours.settings
    for setting in ours.settings:
        assert setting.asked is not None
        error = ready.reference.error(setting.value(setting.run(60.0)))
        assert error <= setting.asked + ready.reference.agreement, setting.name


@pytest.mark.parametrize("scene", [scene for scene in SCENES if isinstance(scene, LimbScene)], ids=lambda s: s.name)
def test_no_random_start_leads_to_another_stable_posture(scene: LimbScene) -> None:
    limb = scene.limb()
    posture = limb.solve(**scene.options)
    generator = np.random.default_rng(7)
    for _ in range(3):
        start = posture.plates.copy()
        start[:, :3, 3] += 0.3 * limb.length * generator.normal(size=(len(start), 3))
        start[:, :3, :3] = np.linalg.qr(generator.normal(size=(len(start), 3, 3)))[0]
        start[:, :3, :3] *= np.linalg.det(start[:, :3, :3])[:, None, None]
        found = limb.solve(**scene.options, start=start)
        assert found.success and found.stable
        # Each tip may be off by its tolerance of 1e-6.
        assert np.linalg.norm(found.tip[:3, 3] - posture.tip[:3, 3]) <= 2e-6 * limb.length


def test_an_error_is_the_larger_of_the_distances_from_both_references() -> None:
    reference = Reference((np.array([1.0, 0.0]), np.array([1.0, 0.2])), ("one", "other"), 2.0)
    assert reference.agreement == pytest.approx(0.1)
    assert reference.error(np.array([1.0, 0.05])) == pytest.approx(0.075)
    assert reference.error(np.array([1.0, 0.1])) == pytest.approx(0.05)


def test_halving_the_steps_makes_shooting_more_exact() -> None:
    for name, method in (("tube-mild", SHOOTING), ("cantilever-mild", SHOOTING)):
        coarse, fine = rows_of(name, method)[method]
        assert coarse.error is not None and fine.error is not None
        # Four times the steps of a method of fourth order: 256 times; rounding and the fifth order may take some of it.
        assert 100.0 < coarse.error / fine.error < 600.0


def test_models_that_leave_things_out_are_off_and_say_so_by_their_error() -> None:
    tube = rows_of("tube-mild", PAPER_CONSTANTS, CONSTANT_CURVATURE)
    (reduced,) = tube[PAPER_CONSTANTS]
    assert reduced.outcome == "answer" and reduced.error is not None and reduced.error > 0.1
    (arcs,) = tube[CONSTANT_CURVATURE]
    assert arcs.outcome == "none" and "knows no pressure" in arcs.remark and arcs.samples is None
    segment = rows_of("segment-mild", PAPER, PAPER_CONSTANTS, CONSTANT_CURVATURE)
    errors = [segment[name][0].error for name in (PAPER, PAPER_CONSTANTS, CONSTANT_CURVATURE)]
    # Right sections: the algorithm's tolerance over the rods' stiffness. Wrong ones: per mille. None: per cent.
    for error, low, high in zip(errors, (0.0, 1e-4, 1e-2), (1e-5, 1e-2, 1.0), strict=True):
        assert error is not None and low < error < high
    (arcs,) = rows_of("segment-stiff", CONSTANT_CURVATURE)[CONSTANT_CURVATURE]
    assert arcs.error is None and "parallel" in arcs.remark
    (constants,) = rows_of("cantilever-mild", PAPER_CONSTANTS)[PAPER_CONSTANTS]
    assert constants.error is None and "without pressure" in constants.remark


def test_answers_that_are_no_answers_of_the_scene_are_told_apart() -> None:
    found = rows_of("cantilever-extreme", SHOOTING)[SHOOTING]
    assert [row.outcome for row in found] == ["none", "elsewhere"]
    assert found[0].remark == "overflow"
    assert found[1].remark == "no equilibrium there" and found[1].error is not None and found[1].error > 0.1


# --- rules of measuring ----------------------------------------------------------------------------------------------

TRUE = Reference((np.zeros(3), np.full(3, 1e-14)), ("one", "other"), 1.0)


def setting(name: str, value: float, asked: float | None = None) -> Setting:
    return Setting(name, name, lambda _: value, lambda answer: np.array([answer, 0.0, 0.0]), asked)


def refusing(name: str, reason: str) -> Setting:
    def value(_: Any) -> Any:
        raise NoAnswer(reason)

    return Setting(name, name, lambda limit: None, value)


@dataclasses.dataclass(frozen=True)
class Made:
    """A scene whose truth is zero."""

    methods: tuple[Method, ...]
    reference: Reference = TRUE
    name: str = "made"
    what: str = "made up"

    def prepare(self, quick: bool) -> Prepared:
        return Prepared(self.reference, self.methods, ["Nothing to know."])


def outcomes(*methods: Method) -> list[tuple[str, str]]:
    found = measure(Made(methods), Clock(budget=0.0), limit=0.0)
    return [(row.outcome, row.remark) for row in found.rows]


def test_ours_beyond_its_tolerance_is_a_fault() -> None:
    right = Method(OURS, [setting("1e-6", 9e-7, 1e-6)])
    assert outcomes(right) == [("answer", "")]
    for method in (
        Method(OURS, [setting("1e-6", 2e-6, 1e-6)]),
        Method(OURS, [dataclasses.replace(refusing("1e-6", "no equilibrium"), asked=1e-6)]),
    ):
        found = measure(Made((method,)), Clock(budget=0.0), limit=1.0)
        assert found.rows[0].outcome == "wrong" and "softlimb, 1e-6" in found.fault
    # What is finer than the default may be out of reach, and is said; it is no fault.
    finer = Method(OURS, [dataclasses.replace(refusing("1e-12", "no progress"), asked=1e-12)])
    assert outcomes(finer) == [("none", "no progress")]


def test_a_large_error_is_explained_where_the_equations_are_the_same() -> None:
    exact = Method(SHOOTING, [setting("10 steps", 0.5)], where=lambda answer: f"seen at {answer}")
    model = Method(CONSTANT_CURVATURE, [setting("", 0.5)])
    assert outcomes(exact, model) == [("elsewhere", "seen at 0.5"), ("answer", "")]


def test_what_runs_out_of_time_is_not_tried_at_finer_settings() -> None:
    late = Method(SHOOTING, [refusing("5", "gave up"), setting("10", 0.0)])
    assert outcomes(late) == [("none", "gave up after 0 s"), ("none", "not tried after that")]
    found = measure(Made((Method(SHOOTING, [refusing("5", "overflow"), setting("10", 0.0)]),)), Clock(0.0), limit=60.0)
    assert [row.outcome for row in found.rows] == ["none", "answer"]


def test_a_missing_module_is_named_with_what_brings_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("scipy", "scipy.integrate", "scipy.optimize"):
        monkeypatch.setitem(sys.modules, name, None)  # as where it is not installed
    for method in (SOLVE_BVP, LEAST_SQUARES):
        (row,) = rows_of("tube-mild", method)[method]
        assert row.outcome == "none" and row.remark == "scipy is missing: pip install 'softlimb[bench]'"


def test_nothing_is_measured_against_references_that_disagree() -> None:
    apart = Reference((np.zeros(3), np.full(3, 1e-6)), ("one", "other"), 1.0)
    found = measure(Made((Method(OURS, [setting("", 0.0)]),), apart), Clock(budget=0.0), limit=1.0)
    assert not found.rows and "differ by 1.7e-06" in found.fault


def test_a_scene_without_an_answer_of_ours_has_no_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    tube = next(scene for scene in SCENES if isinstance(scene, TubeScene))
    balloon = dataclasses.replace(tube, pressure=1e9)
    found = measure(balloon, Clock(budget=0.0), limit=1.0)
    assert not found.rows and found.reference is None and "nothing to compare with" in found.fault


# --- tables and pictures ---------------------------------------------------------------------------------------------


def samples(*seconds: float) -> Samples:
    return Samples(np.array(seconds), np.full(len(seconds), 6.5e-6))


def crowded() -> Measured:
    """Everything that a picture may have to show, with reasons as long as they come."""
    ours = [
        Row(OURS, f"tolerance 1e-{k}", "answer", "", 10.0 ** -(k + 2), samples(1e-4, 1.1e-4, 4e-4), f"1e-{k}")
        for k in (2, 6, 12)
    ]
    elsewhere = ("elsewhere", "no equilibrium there", 0.5, samples(1.0))
    shots = [Row(SHOOTING, f"{n} steps", *elsewhere, str(n)) for n in (5, 10)]
    shots.append(Row(SHOOTING, "20 steps", "none", "overflow", None, samples(2.0)))
    shots.append(Row(SHOOTING, "40 steps", "none", "gave up after 6 s", None, samples(6.0)))
    shots.append(Row(SHOOTING, "80 steps", "none", "not tried after that"))
    others = [
        Row(SOLVE_BVP, "tolerance 1e-3", "none", "gave up after 6 s", None, samples(6.1)),
        Row(SOLVE_BVP, "tolerance 1e-6", "none", "not tried after that"),
        Row(LEAST_SQUARES, "10 steps", "none", "gave up after 6 s", None, samples(6.0)),
        Row(LEAST_SQUARES, "40 steps", "none", "not tried after that"),
        Row(PAPER, "", "none", "no posture at its lengths: actuator 8 cannot reach 0.0341801 m", None, samples(3.0)),
        Row(PAPER_CONSTANTS, "", "none", "rods without pressure: the constants are those of tubes"),
        Row(CONSTANT_CURVATURE, "", "answer", "", 1.3, samples(5e-4)),
    ]
    names = (OURS, SHOOTING, SOLVE_BVP, LEAST_SQUARES, PAPER, PAPER_CONSTANTS, CONSTANT_CURVATURE)
    reference = Reference((np.zeros(3), np.full(3, 1e-15)), ("one method", "another method"), 0.65)
    return Measured("limb-crowded", "limb of 9 rods", [*ours, *shots, *others], reference, ["A remark."], "", names)


def test_every_row_has_all_cells_and_a_reason_where_it_has_no_error() -> None:
    for row in crowded().rows:
        shown = cells(row)
        assert len(shown) == len(HEADINGS)
        if row.error is None:
            assert shown[2] == "-" and shown[-1].startswith(f"no answer: {row.remark}")
        else:
            assert float(shown[2]) == pytest.approx(row.error, rel=0.05)
            assert float(shown[3]) > 0.0 and float(shown[5]) > 0.0


def test_settings_with_the_same_trouble_are_named_together() -> None:
    measured = crowded()
    assert troubles(measured.of(SHOOTING))[0] == "5, 10 steps: no equilibrium there"
    assert troubles(measured.of(PAPER_CONSTANTS)) == ["rods without pressure: the constants are those of tubes"]
    assert troubles(measured.of(OURS)) == []
    both = [Row("x", f"tolerance 1e-{k}", "none", "gave up") for k in (3, 6)]
    assert troubles(both) == ["tolerance 1e-3, 1e-6: gave up"]


def test_the_picture_names_every_method_and_no_two_texts_overlap() -> None:
    measured = crowded()
    figure = draw(measured, 6.5e-6)
    figure.draw_without_rendering()
    texts = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    shown = " ".join(text.get_text() for text in figure.texts)
    for name in measured.methods:
        assert name in shown
    for part in ("limb-crowded", "5, 10 steps: no equilibrium there", "80 steps: not tried after that", "overflow"):
        assert part in shown
    assert any(text.get_text() == "no answer" for text in texts)
    labels = [label for axes in figure.axes for label in (axes.xaxis.label, axes.yaxis.label) if label.get_text()]
    named = {label.get_text() for label in labels}
    assert {"time of one solve [ms]", "error of the tip,\nover the length [1]"} <= named
    boxes = {text.get_text(): text.get_window_extent() for text in [*texts, *labels]}
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        assert not a.overlaps(b), (one, other)
    for text, box in boxes.items():
        assert figure.bbox.contains(*box.min) and figure.bbox.contains(*box.max), text


def test_what_has_no_answer_stands_in_the_strip_at_its_time() -> None:
    figure = draw(crowded(), 6.5e-6)
    (strip,) = [axes for axes in figure.axes if any(text.get_text() == "no answer" for text in axes.texts)]
    rows = {float(y): sorted(line.get_xdata()) for line in strip.lines for y in line.get_ydata()}
    assert len(rows) == 4  # methods, each on its own line
    assert [2000.0, 6000.0] in rows.values()


def test_methods_differ_in_marker_and_those_with_lines_in_their_dashes() -> None:
    from softlimb.report.picture import _LOOKS

    assert len({look["marker"] for look in _LOOKS.values()}) == len(_LOOKS)
    lines = [look["linestyle"] for look in _LOOKS.values() if look["linestyle"] != "none"]
    assert len(set(lines)) == len(lines)


class Balanced(HTMLParser):
    """Opens and closes what it should, and keeps text and pictures."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.pictures: list[str] = []
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "img":
            self.pictures.append(str(given["src"]))
        if "id" in given:
            self.anchors.add(str(given["id"]))
        if tag == "a":
            self.links.add(str(given["href"]).removeprefix("#"))
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_page_says_the_same_in_both_formats() -> None:
    measured = dataclasses.replace(crowded(), fault="x < y & z")
    waiting, machine = [("tube-mild", "not yet run")], {"processor": "A & B"}
    page = Page([measured], waiting, machine, ["VOID: busy"], 6.0, "softlimb report")
    markdown, found = as_markdown(page), Balanced()
    found.feed(as_html(page))
    assert not found.open
    assert found.pictures == ["limb-crowded.png"] and "](limb-crowded.png)" in markdown
    assert found.links == {"limb-crowded"} <= found.anchors
    for text in ("x < y & z", "A & B", "tube-mild (not yet run)", "Do not trust the times", "one method", "6 s for a"):
        assert text in markdown and text in found.text
    for row in measured.rows:
        for cell in cells(row):
            assert cell in markdown and cell.replace("`", "") in found.text
    tables = re.findall(r"(?:^\|.*\|\n?)+", markdown, re.MULTILINE)
    for table in tables:
        assert len({line.count("|") for line in table.splitlines()}) == 1


# --- the command -----------------------------------------------------------------------------------------------------


def test_the_command_writes_tables_pictures_and_a_page(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    chosen = ["tube-mild", "tube-extreme"]
    assert main(["report", "--quick", "--out", str(tmp_path / "out"), "--only", *chosen]) == 0
    printed = capsys.readouterr().out
    assert max(len(line) for line in printed.splitlines() if not line.startswith("page: ")) <= 110
    for name in chosen:
        picture = (tmp_path / "out" / f"{name}.png").read_bytes()
        assert picture.startswith(b"\x89PNG")
        with (tmp_path / "out" / f"{name}.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert tuple(rows[0]) == COLUMNS
        methods = [method.name for method in prepared(name).methods]
        assert list(dict.fromkeys(row["method"] for row in rows)) == methods
        for row in rows:
            if row["outcome"] == "none":
                assert row["remark"] and not row["error"]
                continue
            assert float(row["error"]) >= 0.0 and int(row["samples"]) >= 1
            assert 0.0 < float(row["lower_quartile_ms"]) <= float(row["median_ms"]) <= float(row["upper_quartile_ms"])
            assert float(row["ratio_to_yardstick"]) > 0.0
    for file in ("report.md", "report.html"):
        page = (tmp_path / "out" / file).read_text(encoding="utf-8")
        for name in NAMES:
            assert name in page
        assert page.count("left out by --only") == len(NAMES) - len(chosen)
        for what in ("processor", "compiler", "flags", "numpy", np.__version__, "softlimb report --only tube-mild"):
            assert what in page
    assert not list((tmp_path / "out").glob("*.part"))


def test_an_interrupted_run_keeps_what_it_had(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    def one_then_none(scene: Any, *_: Any) -> Measured:
        if scene.name != NAMES[0]:
            raise KeyboardInterrupt
        return dataclasses.replace(crowded(), name=scene.name)

    monkeypatch.setattr(measuring, "measure", one_then_none)
    assert main(["report", "--out", str(tmp_path)]) == 130
    written = {f"{NAMES[0]}.png", f"{NAMES[0]}.csv", "report.md", "report.html"}
    assert {path.name for path in tmp_path.iterdir()} == written
    page = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert page.count("not yet run") == len(NAMES) - 1 and f"## {NAMES[0]}" in page


def test_a_fault_is_printed_and_ends_with_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    fault = Measured(NAMES[0], "a tube", fault="nothing to compare with: injected")
    monkeypatch.setattr(measuring, "measure", lambda *_: fault)
    assert main(["report", "--out", str(tmp_path), "--only", NAMES[0]]) == 1
    assert "FAULT: nothing to compare with: injected" in capsys.readouterr().out
    assert "injected" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not (tmp_path / f"{NAMES[0]}.png").exists()


def test_an_unknown_scene_is_refused_by_name_with_the_list(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    out = tmp_path / "out"
    assert main(["report", "--out", str(out), "--only", "tube-mild", "tube-wild"]) == 2
    error = capsys.readouterr().err
    assert "'tube-wild'" in error and all(name in error for name in NAMES)
    assert not out.exists()


@pytest.mark.parametrize(("name", "rule"), [("file", "is a file"), ("no/where", "there is no folder"), ("", "empty")])
def test_a_folder_that_cannot_be_is_refused(
    name: str, rule: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    assert main(["report", "--out", name]) == 2
    assert rule in capsys.readouterr().err
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


def test_a_table_without_times_has_empty_cells(tmp_path: Path) -> None:
    write_scene(crowded(), tmp_path, 6.5e-6)
    with (tmp_path / "limb-crowded.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    untried = next(row for row in rows if row["remark"] == "not tried after that")
    assert [untried[key] for key in ("error", "median_ms", "ratio_to_yardstick", "samples")] == [""] * 4
