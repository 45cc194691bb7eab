"""The page: what was measured and how, every scene with its picture and its table; as Markdown and as HTML.

Both are written from the same blocks, so they say the same.
"""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from softlimb.bench.figures import median_and_spread, three_digits
from softlimb.report.measure import Measured, Row
from softlimb.report.methods import (
    CONSTANT_CURVATURE,
    LEAST_SQUARES,
    OURS,
    PAPER,
    PAPER_CONSTANTS,
    SHOOTING,
    SOLVE_BVP,
)
from softlimb.units import ms

__all__ = ["HEADINGS", "Page", "as_html", "as_markdown", "cells"]

_TITLE = "softlimb: error against run time"
_RIGHT = 1e-4
"""Error of an answer that a user would call right."""

HEADINGS = ("method", "setting", "error", "time [ms]", "quartiles [ms]", "time [Y]", "remark")
"""Of a scene's table."""

_METHODS = {
    OURS: "This package. A limb is solved from its pressures, sections included, to the tolerance that is asked for; a "
    "tube to rounding, either by Newton (`inflate`) or from tables that were made with the tube (`section`).",
    SHOOTING: "Every rod is integrated from its base by classical RK4 with a fixed number of steps; Newton with exact "
    "derivatives on all base wrenches and plate poses (a tube: the balance of stresses through its wall, Newton on "
    "stretch, inner radius and twist). In numpy. Starts from arcs of constant curvature, then straight.",
    SOLVE_BVP: "`scipy.integrate.solve_bvp`, collocation on a mesh that it refines, on the same equations, without "
    "derivatives given, from the same start.",
    LEAST_SQUARES: "`scipy.optimize.least_squares` on the residuals of single shooting, everything at its defaults.",
    PAPER: "Algorithm 1 of Zhang et al. (dense Levenberg-Marquardt with finite differences, RK4 of 40 steps), "
    "corrected only where it cannot run as printed. It is given the true pose of the tip and finds the rods' lengths; "
    "its error is how far from there a limb of these lengths has its tip. Sections are softlimb's.",
    PAPER_CONSTANTS: "The same with the paper's constants: E = 6 c1, area and second moment of the undeformed tube. It "
    "is given the pose that these constants predict at the scene's pressures; its error is how far from there the tip "
    "of a limb comes to lie that has these lengths and the true stiffness. For a tube: the paper's eq. 3 alone.",
    CONSTANT_CURVATURE: "Every segment an arc that its rods' lengths determine: closed form, no loads, no stiffness.",
}

_HOW = (
    "Each picture shows one scene: how far the answers of several methods are from the truth, over the time that one "
    "solve takes. Lower is more exact, further left is faster; both axes are logarithmic.",
    "**Error**: distance of the tip from where it truly is, over the limb's length (rods without pressure, and the "
    "plates between them); for a tube, the error of its length over its length without pressure. What is true is "
    "computed in the same run by two methods that share no code, and shown with what they differ by; the error is the "
    "larger of the distances from both, so it cannot fall below half of that difference. For rods, both take the "
    "sections and rest lengths that softlimb finds for the pressures (the tubes' scenes say how exact these are), and "
    "the second starts where the first one ended: it confirms the equilibrium, not that there is no other.",
    "**Time**: one solve from nothing, called from Python, on one core; median and quartiles. Calls that take less "
    "than a millisecond are repeated and averaged within a sample. `Y` is the yardstick of `softlimb bench`, a fixed "
    "loop in plain C++ that is read before and after each sample: a time in Y means the same on any machine. The core "
    "of softlimb is compiled, the other methods run in numpy and scipy: a ratio of times holds the language as well as "
    "the method, an error at a number of steps does not. The time of softlimb includes the sections from the "
    "pressures, which the other methods get as numbers.",
    "**No answer**: what ended without one stands in the grey strip above the picture, at the time after which it "
    "ended, and with the reason beside its name and in the table. Hollow markers in the picture are answers that a "
    "method called converged but that are not this scene's posture. A method that ran out of time at one setting is "
    "not tried at finer ones.",
)


@dataclass(frozen=True)
class Page:
    """What there is so far.

    Parameters
    ----------
    done : sequence of Measured
    waiting : sequence of (str, str)
        Names of other scenes, and why they are not here.
    machine : mapping of str to str
    notes : sequence of str
        How the yardstick fared.
    limit : float
        Time for one solve of another method [s].
    command : str
        What was asked for.
    """

    done: Sequence[Measured]
    waiting: Sequence[tuple[str, str]]
    machine: Mapping[str, str]
    notes: Sequence[str]
    limit: float
    command: str


# --- blocks ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Heading:
    level: int
    text: str


@dataclass(frozen=True)
class _Paragraph:
    text: str


@dataclass(frozen=True)
class _Table:
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class _Picture:
    file: str
    text: str


_Block = _Heading | _Paragraph | _Table | _Picture


def _blocks(page: Page) -> list[_Block]:
    blocks: list[_Block] = [_Heading(1, _TITLE)]
    blocks += [_Paragraph(f"**Do not trust the times: {note}.**") for note in page.notes if note.startswith("VOID")]
    blocks += [
        _Paragraph(
            "How exact is an answer for the time that it takes? Tubes, single rods, segments and limbs, each mild, "
            f"stiff and extreme. Made by `{page.command}`; other methods had {page.limit:g} s for a solve."
        ),
        _Heading(2, "In short"),
        _Table(
            ("scene", "what", "softlimb at 1e-6: error", "ms", "Y", "fastest other below 1e-4", "its time over ours"),
            [_in_short(measured) for measured in page.done],
        ),
    ]
    if page.waiting:
        blocks.append(_Paragraph("Not here: " + "; ".join(f"{name} ({why})" for name, why in page.waiting) + "."))
    blocks.append(_Heading(2, "How to read it"))
    blocks += [_Paragraph(text) for text in _HOW]
    blocks += [_Heading(2, "Methods"), _Table(("method", "what it does"), list(_METHODS.items()))]
    blocks += [_Heading(2, "Machine and versions"), _Table(("what", "here"), list(page.machine.items()))]
    blocks += [_Paragraph(f"{note[:1].upper()}{note[1:]}.") for note in page.notes]
    for measured in page.done:
        blocks += _scene(measured)
    return blocks


def _in_short(measured: Measured) -> list[str]:
    link = f"[{measured.name}](#{_anchor(measured.name)})"
    ours = next((row for row in measured.of(OURS) if row.mark in ("1e-6", "section")), None)
    if ours is None or ours.error is None or ours.seconds is None or ours.ratio is None:
        return [link, measured.what, measured.fault or "no answer", "", "", "", ""]
    right = [
        row
        for row in measured.rows
        if row.method != OURS and row.outcome == "answer" and row.error is not None and row.error <= _RIGHT
    ]
    start = [link, measured.what, f"{ours.error:.0e}", three_digits(ours.seconds / ms), three_digits(ours.ratio)]
    fastest = min(right, key=lambda row: row.seconds or 0.0, default=None)
    if fastest is None or fastest.seconds is None:
        return [*start, "none", ""]
    return [*start, f"{fastest.method}, {fastest.setting}".strip(", "), three_digits(fastest.seconds / ours.seconds)]


def _scene(measured: Measured) -> list[_Block]:
    blocks: list[_Block] = [_Heading(2, measured.name), _Paragraph(f"{measured.what[:1].upper()}{measured.what[1:]}.")]
    if measured.fault:
        blocks.append(_Paragraph(f"**Fault: {measured.fault}.**"))
    reference = measured.reference
    if reference is not None:
        blocks.append(
            _Paragraph(
                f"True by {reference.names[0]} and by {reference.names[1]}: they differ by {reference.agreement:.1e} "
                f"of the length, {reference.length:.3g} m. {' '.join(measured.remarks)}"
            )
        )
    if measured.rows:
        blocks.append(_Picture(f"{measured.name}.png", f"Error over time, {measured.name}"))
        blocks.append(_Table(HEADINGS, [cells(row) for row in measured.rows]))
    return blocks


def cells(row: Row) -> list[str]:
    """A row as text, under `HEADINGS`: figures where there is an answer, a reason where there is none."""
    if row.error is None or row.samples is None or row.ratio is None:
        spent = "" if row.seconds is None else f" (after {three_digits(row.seconds / ms)} ms)"
        return [row.method, row.setting, "-", "-", "-", "-", f"no answer: {row.remark}{spent}"]
    figures = [f"{row.error:.1e}", *median_and_spread(row.samples, ms), three_digits(row.ratio)]
    return [row.method, row.setting, *figures, row.remark]


# --- writing ---------------------------------------------------------------------------------------------------------


def _anchor(text: str) -> str:
    """The name of a heading in links, as the usual readers of Markdown make it."""
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def as_markdown(page: Page) -> str:
    """The page with links to its pictures."""
    parts = []
    for block in _blocks(page):
        if isinstance(block, _Heading):
            parts.append(f"{'#' * block.level} {block.text}")
        elif isinstance(block, _Paragraph):
            parts.append(block.text)
        elif isinstance(block, _Picture):
            parts.append(f"![{block.text}]({block.file})")
        else:
            lines = [block.headings, ["---"] * len(block.headings), *block.rows]
            parts.append("\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines))
    return "\n\n".join(parts) + "\n"


_STYLE = """\
body { font-family: sans-serif; line-height: 1.45; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; font-size: 0.88em; }
th, td { border-bottom: 1px solid #ccc; padding: 0.25em 0.7em; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #555; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
img { max-width: 100%; margin: 0.5em 0; }
code { background: #f2f2f2; padding: 0 0.2em; }
h2 { margin-top: 2em; border-bottom: 1px solid #ccc; }
"""


def as_html(page: Page) -> str:
    """The page in one file, its pictures beside it."""
    parts = []
    for block in _blocks(page):
        if isinstance(block, _Heading):
            anchor = html.escape(_anchor(block.text))
            parts.append(f'<h{block.level} id="{anchor}">{html.escape(block.text)}</h{block.level}>')
        elif isinstance(block, _Paragraph):
            parts.append(f"<p>{_inline(block.text)}</p>")
        elif isinstance(block, _Picture):
            text = html.escape(block.text)
            parts.append(f'<p><img src="{html.escape(block.file)}" alt="{text}"></p>')
        else:
            head = "".join(f"<th>{_inline(cell)}</th>" for cell in block.headings)
            rows = ["".join(_cell(cell) for cell in row) for row in block.rows]
            body = "\n".join(f"<tr>{row}</tr>" for row in rows)
            parts.append(f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>")
    head = f'<meta charset="utf-8">\n<title>{html.escape(_TITLE)}</title>\n<style>\n{_STYLE}</style>'
    lines = ["<!DOCTYPE html>", '<html lang="en">', "<head>", head, "</head>", "<body>", *parts, "</body>", "</html>"]
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    kind = ' class="number"' if re.fullmatch(r"-|[\d.e+-]+(\.\.[\d.]+)?", text) else ""
    return f"<td{kind}>{_inline(text)}</td>"


def _inline(text: str) -> str:
    """Code, bold and links; everything else as it is."""
    escaped = html.escape(text, quote=False)
    escaped = re.sub(r"`([^`]+)`", r"<code>\1</code>", escaped)
    escaped = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", escaped)
    return re.sub(r"\[([^\]]+)\]\((#[\w-]+)\)", r'<a href="\2">\1</a>', escaped)
