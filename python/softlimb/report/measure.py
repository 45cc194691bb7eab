"""A scene measured: every method at every setting, its error and its time, or why it has none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from softlimb.bench.clock import Clock, Samples, quartiles, seconds_of
from softlimb.bench.others import INSTALL
from softlimb.report.methods import OURS, Method, NoAnswer, Reference, Scene, Setting
from softlimb.units import ms

__all__ = ["Measured", "Row", "measure"]

DISAGREEMENT = 1e-9
"""Two references that differ by more, over the length, are none."""
_FAR = 1e-2
"""An error beyond this of a method that solves the same equations is no error of its steps: it ended elsewhere."""
# A call of a tube takes a few microseconds: a hundred of them are timed as one. Most solves are longer than this.
_SHORTEST_SAMPLE = 1 * ms
_ROUNDS = (3, 50)


@dataclass(frozen=True)
class Row:
    """A method at a setting.

    Parameters
    ----------
    outcome : str
        "answer", "elsewhere" (an answer, but of another equilibrium or of none), "wrong" (of ours: none, or one beyond
        what it promises), or "none".
    remark : str
        Why there is no answer, or what is where it ended.
    error : float, optional
        Over the scene's length; where there is an answer.
    samples : Samples, optional
        Times of a solve that has an answer; of one that has none, what it took to find that out.
    mark : str
        The setting in a picture.
    """

    method: str
    setting: str
    outcome: str
    remark: str = ""
    error: float | None = None
    samples: Samples | None = None
    mark: str = ""

    @property
    def seconds(self) -> float | None:
        """Median time [s]."""
        return None if self.samples is None else quartiles(self.samples.seconds)[1]

    @property
    def ratio(self) -> float | None:
        """Median of the times over the yardstick."""
        return None if self.samples is None else quartiles(self.samples.ratios)[1]


@dataclass(frozen=True)
class Measured:
    """All rows of a scene; ``fault`` says what forbids to trust them, or that there are none."""

    name: str
    what: str
    rows: Sequence[Row] = ()
    reference: Reference | None = None
    remarks: Sequence[str] = ()
    fault: str = ""
    methods: Sequence[str] = ()

    def of(self, method: str) -> list[Row]:
        """The rows of a method."""
        return [row for row in self.rows if row.method == method]


def measure(scene: Scene, clock: Clock, limit: float, quick: bool = False) -> Measured:
    """Find what is true on a scene, then measure every method against it.

    Parameters
    ----------
    limit : float
        Time for one solve of another method [s].
    quick : bool
        Fewer settings.
    """
    try:
        prepared = scene.prepare(quick)
    except NoAnswer as reason:
        return Measured(scene.name, scene.what, fault=f"nothing to compare with: {reason}")
    reference = prepared.reference
    if not reference.agreement <= DISAGREEMENT:
        fault = f"the two references differ by {reference.agreement:.1e} of the length"
        return Measured(scene.name, scene.what, reference=reference, remarks=prepared.remarks, fault=fault)
    rows = [row for method in prepared.methods for row in _rows(method, reference, clock, limit)]
    wrong = [row for row in rows if row.outcome == "wrong"]
    fault = "; ".join(f"{row.method}, {row.setting}: {row.remark}" for row in wrong)
    names = [method.name for method in prepared.methods]
    return Measured(scene.name, scene.what, rows, reference, prepared.remarks, fault, names)


def _rows(method: Method, reference: Reference, clock: Clock, limit: float) -> Iterator[Row]:
    if method.unable:
        yield Row(method.name, "", "none", method.unable)
        return
    if method.needs is not None:
        try:
            import_module(method.needs)  # here, so that the first solve is not timed with it
        except ModuleNotFoundError:
            yield Row(method.name, "", "none", f"{method.needs.partition('.')[0]} is missing: {INSTALL}")
            return
    late = False
    for setting in method.settings:
        if late:
            yield Row(method.name, setting.name, "none", "not tried after that")
            continue
        row = _row(method, setting, reference, clock, limit)
        late = row.outcome == "none" and row.seconds is not None and row.seconds >= limit
        yield row


def _row(method: Method, setting: Setting, reference: Reference, clock: Clock, limit: float) -> Row:
    first, answer = clock.once(lambda: setting.run(limit))
    try:
        error = reference.error(setting.value(answer))
    except NoAnswer as reason:
        text = f"gave up after {limit:g} s" if str(reason) == "gave up" else str(reason)
        # Where the package itself, asked for no more than its default, has no answer, something is wrong.
        ours = method.name == OURS and setting.asked is not None and setting.asked >= 1e-6
        return Row(method.name, setting.name, "wrong" if ours else "none", text, samples=first)
    outcome, remark = _judged(method, setting, answer, error, reference)
    return Row(method.name, setting.name, outcome, remark, error, _timed(setting, first, clock, limit), setting.mark)


def _judged(
    method: Method, setting: Setting, answer: Any, error: float, reference: Reference
) -> tuple[str, str]:
    if setting.asked is not None and not error <= setting.asked + reference.agreement:
        return "wrong", f"an error of {error:.1e} where {setting.asked:g} was asked for"
    if method.where is not None and not error <= _FAR:
        return "elsewhere", method.where(answer)
    return "answer", ""


def _timed(setting: Setting, first: Samples, clock: Clock, limit: float) -> Samples:
    if first.seconds[0] >= clock.budget:
        return first
    again = {setting.name: lambda: seconds_of(lambda: setting.run(limit), _SHORTEST_SAMPLE)}
    return clock.in_turn(again, _ROUNDS, warm_up=False)[setting.name]
