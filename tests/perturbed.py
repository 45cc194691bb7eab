"""A limb and its loads with one named number changed: what derivatives are compared with, made without them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

import softlimb as sl
from softlimb.changed import changed_tube as changed_by_name
from softlimb.changed import tube_values


def changed_tube(tube: sl.Tube, what: str, step: float) -> sl.Tube:
    """``what`` is the label of a column within the tube, as ``layers[0].c1``."""
    return changed_by_name(tube, {what: tube_values(tube)[what] + step})


def changed_rod(rod: sl.Rod, what: str, step: float) -> sl.Rod:
    if what == "length":
        return sl.Rod(rod.section, rod.length + step)
    names = ("axial", "shear", "bending", "torsion", "mass_per_length", "rest_twist", "extension_twist")
    given = {name: getattr(rod.section, name) for name in names}
    given[what.removeprefix("section.")] += step
    return sl.Rod(sl.Section(**given), rod.length)


def changed(limb: sl.Limb, options: dict[str, Any], label: str, step: float) -> tuple[sl.Limb, dict[str, Any]]:
    """The limb and the arguments of its solve, with the number of one column (``each="segment"``) changed by a step."""
    if found := re.fullmatch(r"(pressures|rod_forces)\[(\d+)\](?:\.([xyz]))?", label):
        size = (len(limb._tubes),) if found[1] == "pressures" else (len(limb._members), 3)
        value = np.array(options.get(found[1], np.zeros(size)), dtype=float).reshape(size)
        value[int(found[2]) if not found[3] else (int(found[2]), "xyz".index(found[3]))] += step
        return limb, {**options, found[1]: value}
    if found := re.fullmatch(r"(gravity|tip_force|tip_moment)\.([xyz])", label):
        vector = np.array(options.get(found[1], np.zeros(3)), dtype=float)
        vector["xyz".index(found[2])] += step
        return limb, {**options, found[1]: vector}
    if found := re.fullmatch(r"plate_wrenches\[(\d)\]\.(\w\w)", label):
        wrenches = np.array(options.get("plate_wrenches", np.zeros((len(limb), 6))), dtype=float)
        wrenches[int(found[1]), ["fx", "fy", "fz", "mx", "my", "mz"].index(found[2])] += step
        return limb, {**options, "plate_wrenches": wrenches}
    found = re.fullmatch(r"segments\[(\d)\]\.(.*)", label)
    assert found, label
    number, what = int(found[1]), found[2]
    segments = list(limb.segments)
    old = segments[number]
    members, ring, plate = list(old.members), old.ring_radius, old.plate
    if what == "ring_radius":
        ring += step
    elif what.startswith("plate_"):
        values = {"thickness": plate.thickness, "mass": plate.mass}
        values[what.removeprefix("plate_")] += step
        plate = sl.Plate(**values)
    else:
        made: dict[int, Any] = {}  # equal members stay one object, so that they are solved once
        for k, member in enumerate(members):
            if id(member) not in made:
                change = changed_tube if isinstance(member, sl.Tube) else changed_rod
                made[id(member)] = change(member, what, step)
            members[k] = made[id(member)]
    kind = "actuators" if old.actuators else "rods"
    place = (
        {"ring_radius": ring} if ring is not None else {"base_frames": old.base_frames, "end_frames": old.end_frames}
    )
    segments[number] = sl.Segment(**{kind: members}, plate=plate, **place)
    return sl.Limb(segments), options


def turn_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rotation vector of ``a b^T`` for rotations that differ little."""
    turn = a @ b.T
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = 0.5 * np.linalg.norm(twice)
    angle = np.arctan2(sine, 0.5 * (np.trace(turn) - 1.0))
    return 0.5 * twice * (angle / sine if sine > 0.0 else 1.0)


def answers(posture: sl.Posture, n: int, energy: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """What is differentiated: plates, points of the centreline, energy."""
    return posture.plates, posture.centreline(n), posture.energy if energy else 0.0


def difference(a: Any, b: Any) -> np.ndarray:
    """Answers a less answers b, in the rows of a derivative of plates, centreline and energy."""
    moves = [
        np.concatenate([p[:3, 3] - q[:3, 3], turn_between(p[:3, :3], q[:3, :3])])
        for p, q in zip(a[0], b[0], strict=True)
    ]
    return np.concatenate([np.ravel(moves), np.ravel(a[1] - b[1]), [a[2] - b[2]]])


def joints(posture: sl.Posture, n: int) -> list[tuple[int, int]]:
    """Which points of the centreline stand on which rods and plates: where one passes a joint there is a corner."""
    parts = posture._centreline_parts(np.linspace(0.0, 1.0, n))[1]
    return [(part.number, int(k)) for part in parts for k in part.inside]


def extrapolated(quotients: list[np.ndarray]) -> np.ndarray:
    """Richardson's table of central differences with halved steps, and of its entries the one that agrees best.

    An entry's error is taken as its distance to the two that it was made of (Ridders): large steps leave terms out,
    small ones leave rounding.
    """
    best, least, above = quotients[0], np.inf, [quotients[0]]
    for quotient in quotients[1:]:
        row = [quotient]
        for order, before in enumerate(above, start=1):
            row.append((4.0**order * row[-1] - before) / (4.0**order - 1.0))
            error = max(np.linalg.norm(row[-1] - row[-2]), np.linalg.norm(row[-1] - before))
            if error < least:
                best, least = row[-1], error
        above = row
    return best


def slope(
    posture: sl.Posture, options: dict[str, Any], label: str, step: float, n: int, energy: bool, levels: int = 8
) -> np.ndarray:
    """The column of a label by differences of tight solves, started from the posture: plates, centreline, energy.

    A step at which a point of the centreline passes a joint of rods and plates does not count for the centreline, whose
    rows are NaN where that leaves fewer than three.
    """
    length = 6 * len(posture.limb)
    parts = (slice(0, length), slice(length, -1), slice(-1, None))
    quotients: list[list[np.ndarray]] = [[], [], []]
    for k in range(levels):
        h, ends, passed = step / 2.0**k, [], False
        for side in (h, -h):
            limb, moved = changed(posture.limb, options, label, side)
            found = limb.solve(**moved, start=posture, prefer_stable=False)
            assert found.success, (label, side, found.message)
            ends.append(answers(found, n, energy))
            passed = passed or joints(found, n) != joints(posture, n)
        quotient = difference(*ends) / (2.0 * h)
        for which, part in enumerate(parts):
            if not (passed and which == 1):
                quotients[which].append(quotient[part])
    few = len(quotients[1]) < 3
    line = np.full(3 * n, np.nan) if few else extrapolated(quotients[1])
    return np.concatenate([extrapolated(quotients[0]), line, extrapolated(quotients[2])])
