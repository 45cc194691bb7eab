"""A tapered rod under gravity and two tendons: 22 static poses, against rods in series with the tendons beside them.

Between two plates the backbone is a rod of constant section. A tendon runs straight between eyelets on the plates: a
rod that hardly bends, whose rest length is sought so that its tension is the motor's. It pulls on the plates where
they are, so the load follows them; friction in the eyelets is left out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softlimb._core import Section
from softlimb.identify import Block, Identified, least_squares
from softlimb.limb import Limb, Posture, Rod, Segment
from softlimb.units import deg, kPa, mm
from softlimb.validate.results import Panel, Series, Table, Validation, read_columns, rms

Array = NDArray[np.float64]

# Geometry as the source's code states it (tud-phi/soromox, commit 4f03054).
_MARKERS = (0.1291, 0.2195, 0.2800, 0.3600)  # along the rod [m]
_ASIDE = np.array([25.0, -21.0, 20.0, 8.0]) * mm  # of each marker, along x of its section
_JOINT, _LENGTH = 0.305, 0.360  # end of the first link, of the rod [m]
_RADII = 15.41 * mm, 6.42 * mm, 4.80 * mm  # at the base, the joint, the tip
_POISSON = 0.45
_FIRST_OFFSET, _NARROWING = 11.4 * mm, 0.0295  # of the tendons from the axis, and how it falls along the rod
_TENDON_ANGLES = np.array([-60.0, 60.0]) * deg  # 30 and 150 degrees there, seen in axes whose x is the markers' side
_DRUM = 0.0325  # torque over tension [m]
_FIRST_MODULUS, _DENSITY = 505 * kPa, 1318.0  # before any fit, and of the source's own fit [kg/m^3]
_PUBLISHED = (11.0, 18.0, 19.0, 36.0)  # rms of each marker that the source's own fit leaves [mm]
_AXES = np.array([1.0, -1.0, -1.0])  # their z points up, ours along the hanging rod
# Nodes: base, markers, joint, and three between each two of them. The thin end of a strongly bent pose still moves when
# there are more: the findings give by how much.
_CORNERS = np.array([0.0, *_MARKERS[:3], _JOINT, _LENGTH])
_NODES = np.interp(np.linspace(0.0, 5.0, 21), np.arange(6.0), _CORNERS)
_MARKED = tuple(int(np.argmin(np.abs(_NODES - s))) - 1 for s in _MARKERS)  # plates that carry markers
# A tendon's rod: so soft that its tension is nearly that of a spring at constant force, and hardly bending.
_TENDON_AXIAL, _TENDON_BENDING = 0.5, 2e-6
_TENSION_ERROR = 5e-4  # of the tension, at which the search for rest lengths ends
_MOST_ROUNDS = 60
_MEMORY = 6  # rounds that the extrapolation of rest lengths looks back on
_STEP = 1e-2  # of the modulus, for the difference that stands for its slope


# Torques [N m] of poses with both motors; of one motor the name says it, u025 for 0.25.
_BOTH = {
    "m12_u001": (0.1, 0.1),
    "m12_u002": (0.2, 0.2),
    "m12_u001002": (0.1, 0.2),
    "m12_u0015002": (0.15, 0.2),
    "m12_u002001": (0.2, 0.1),
    "m12_u0020015": (0.2, 0.15),
    "m12_u00100005": (0.1, 0.05),
    "m12_u00050010": (0.05, 0.1),
}


@dataclass(frozen=True, eq=False)
class Poses:
    """Names, tendon tensions (n, 2) [N] and markers (n, 4, 3) [m] in the rod's axes."""

    names: list[str]
    tensions: Array
    markers: Array

    def only(self, rows: Sequence[int]) -> Poses:
        """Some of them."""
        return Poses([self.names[i] for i in rows], self.tensions[list(rows)], self.markers[list(rows)])


def tensions_of(name: str) -> tuple[float, float]:
    """Tensions of both tendons [N] from the name of an experiment.

    Raises
    ------
    ValueError
        The name says nothing that is known.
    """
    if name in _BOTH:
        first, second = _BOTH[name]
        return first / _DRUM, second / _DRUM
    found = re.fullmatch(r"m([12])_u0(\d+)", name)
    if found is None:
        raise ValueError(f"experiment {name!r}: expected m1_u025 (0.25 N m), m2_..., or one of {', '.join(_BOTH)}")
    tension = float(f"0.{found[2]}") / _DRUM
    return (tension, 0.0) if found[1] == "1" else (0.0, tension)


def read(folder: Path) -> Poses:
    """Poses of the file ``tentacle_markers.csv``; errors as for `read_columns`, and for an unknown experiment."""
    numbers = [f"p{k}_{axis}_m" for k in range(1, 5) for axis in "xyz"]
    columns = read_columns(folder / "tentacle_markers.csv", ["experiment"], numbers, least=4)
    names = columns.texts["experiment"]
    markers = np.stack([columns.numbers[name] for name in numbers], axis=1).reshape(-1, 4, 3) * _AXES
    return Poses(names, np.array([tensions_of(name) for name in names]), markers)


def _radius(s: float) -> float:
    return float(np.interp(s, [0.0, _JOINT, _LENGTH], _RADII))


def _backbone(modulus: float, start: float, end: float) -> Rod:
    """The rod of one piece: the radius in its middle, which errs by a hundredth of EI on pieces this short."""
    radius = _radius(0.5 * (start + end))
    area = np.pi * radius**2
    inertia, shear = 0.25 * area * radius**2, 0.5 * modulus / (1.0 + _POISSON)
    section = Section(
        axial=modulus * area,
        shear=shear * area,
        bending=modulus * inertia,
        torsion=2.0 * shear * inertia,
        mass_per_length=_DENSITY * area,
    )
    return Rod(section, end - start)


def _limb(modulus: float, tendons: Sequence[int], lengths: Array, nodes: Array) -> Limb:
    """The tentacle with tendons of given rest lengths, shape (pieces of the first link, tendons)."""
    thread = Section(
        axial=_TENDON_AXIAL, shear=_TENDON_AXIAL, bending=_TENDON_BENDING, torsion=_TENDON_BENDING, mass_per_length=0.0
    )
    segments = []
    for j, (start, end) in enumerate(pairwise(nodes.tolist())):
        rods, frames = [_backbone(modulus, start, end)], np.tile(np.eye(4), (2, 1, 1, 1))
        if j < len(lengths):
            for k, tendon in enumerate(tendons):
                eyelets = np.tile(np.eye(4), (2, 1, 1, 1))
                out = np.array([np.cos(_TENDON_ANGLES[tendon]), np.sin(_TENDON_ANGLES[tendon])])
                for eyelet, s in zip(eyelets, (start, end), strict=True):
                    eyelet[0, :2, 3] = (_FIRST_OFFSET - _NARROWING * s) * out
                frames = np.concatenate([frames, eyelets], axis=1)
                rods.append(Rod(thread, float(lengths[j, k])))
        segments.append(Segment(rods=rods, base_frames=frames[0], end_frames=frames[1]))
    return Limb(segments)


def solve(modulus: float, tensions: Array, nodes: Array = _NODES) -> Posture | None:
    """The hanging tentacle with its tendons at given tensions; None where a posture or the tensions are not found.

    The rest length that would give a tendon's piece its tension at its present chord is one round; from the last rounds
    the next is extrapolated (D. G. Anderson, J. ACM 12 (1965) 547-560).
    """
    tendons = [i for i in range(2) if tensions[i] > 0.0]
    wanted = tensions[tendons]
    pieces = np.diff(nodes[nodes <= _JOINT + 1e-12])
    x = np.log(pieces[:, None] / (1.0 + wanted / _TENDON_AXIAL)).ravel()
    points: list[Array] = []
    steps: list[Array] = []
    near: Array | None = None
    for _ in range(_MOST_ROUNDS):
        lengths = np.exp(x).reshape(len(pieces), len(tendons))
        posture = _limb(modulus, tendons, lengths, nodes).solve(gravity=(0.0, 0.0, 9.81), start=near)
        if not (posture.success and posture.stable):
            return None
        near = posture.plates
        pulls = np.array(
            [[np.linalg.norm(rod.base_wrench[:3]) for rod in posture.rods[j][1:]] for j in range(len(pieces))]
        )
        if not pulls.size or np.abs(pulls / wanted - 1.0).max() <= _TENSION_ERROR:
            return posture
        step = np.log((1.0 + pulls / _TENDON_AXIAL) / (1.0 + wanted / _TENDON_AXIAL)).ravel()
        points, steps = [*points, x][-_MEMORY:], [*steps, step][-_MEMORY:]
        x = x + step
        if len(steps) > 1:
            by_step = np.diff(np.array(steps), axis=0)
            share = np.linalg.lstsq(by_step.T, step, rcond=1e-8)[0]
            x = x - share @ (np.diff(np.array(points), axis=0) + by_step)
    return None


def _halved(nodes: Array) -> Array:
    return np.sort(np.concatenate([nodes, 0.5 * (nodes[1:] + nodes[:-1])]))


def markers_of(posture: Posture) -> Array:
    """Markers of a posture, shape (4, 3) [m]."""
    plates = posture.plates[list(_MARKED)]
    found: Array = plates[:, :3, 3] + _ASIDE[:, None] * plates[:, :3, 0]
    return found


def predict(modulus: float, poses: Poses) -> Array:
    """Markers of all poses, shape (n, 4, 3) [m]; NaN where there is no answer."""
    found = np.full(poses.markers.shape, np.nan)
    for i, tensions in enumerate(poses.tensions):
        posture = solve(modulus, tensions)
        if posture is not None:
            found[i] = markers_of(posture)
    return found


def fit_modulus(poses: Poses) -> Identified:
    """The modulus that explains some poses best.

    The core has no derivative through the search for the tendons' rest lengths: the slope is a difference over a
    hundredth of the modulus, good to about a hundredth, which the search's end does not feel.
    """

    def model(values: Array) -> tuple[Array, Array]:
        modulus = float(values[0])
        at, above = (predict(m, poses).ravel() for m in (modulus, (1.0 + _STEP) * modulus))
        return at, ((above - at) / (_STEP * modulus))[:, None]

    blocks = [Block("markers", "m", 0, poses.markers.size)]
    bounds = {"modulus": (0.1 * _FIRST_MODULUS, 10.0 * _FIRST_MODULUS)}
    start = {"modulus": _FIRST_MODULUS}
    return least_squares(model, poses.markers.ravel(), start, bounds=bounds, blocks=blocks)


def validate(folder: Path) -> Validation:
    """One modulus from every fourth pose; the others held out."""
    poses = read(folder)
    few = list(range(0, len(poses.names), 4))
    found = fit_modulus(poses.only(few))
    modulus = found["modulus"]
    first, after = predict(_FIRST_MODULUS, poses), predict(modulus, poses)
    held = np.array([i not in few for i in range(len(poses.names))])
    gaps = np.linalg.norm(after - poses.markers, axis=2)
    before = np.linalg.norm(first - poses.markers, axis=2)
    bent = poses.tensions[int(np.argmax(poses.tensions.sum(axis=1) * held))]
    ends = [solve(modulus, bent, nodes) for nodes in (_NODES, _halved(_NODES))]
    tips = [np.full(3, np.nan) if end is None else end.tip[:3, 3] for end in ends]
    finer = float(np.linalg.norm(tips[0] - tips[1]))
    pieces = f"pieces half as long move the tip of the held-out pose of largest tension by {_mm(finer)} mm"
    failed = _failures(poses, found, np.stack([before, gaps]))
    rows = [
        (
            f"p{k + 1} at {1e3 * s:.1f} mm",
            _mm(rms(before[:, k])),
            _mm(rms(gaps[few, k])),
            _mm(rms(gaps[held, k])),
            f"{100 * rms(gaps[held, k]) / _LENGTH:.1f}",
            f"{_PUBLISHED[k]:.0f}",
        )
        for k, s in enumerate(_MARKERS)
    ]
    each = [
        (
            name,
            "fitted" if not held[i] else "held out",
            f"{poses.tensions[i, 0]:.2f}, {poses.tensions[i, 1]:.2f}",
            *(_mm(gap) for gap in gaps[i]),
            f"{100 * gaps[i, 3] / _LENGTH:.1f}",
        )
        for i, name in enumerate(poses.names)
    ]
    low, high = found.intervals["modulus"]
    tip = gaps[held, 3]
    return Validation(
        "tendon_tentacle",
        f"{len(poses.names)} static poses of a tapered rod, hanging, pulled by two tendons; four markers. Fitted: one "
        f"modulus, on every fourth pose; density and Poisson's ratio as the source has them, geometry "
        f"as its code states it. Per cent of {_LENGTH / mm:.0f} mm, the rod.",
        (
            Table(
                f"rms distance of the markers, the error of the pieces' number within it: {pieces}",
                ("marker", f"E = {_FIRST_MODULUS / kPa:.0f} kPa, nothing fitted [mm]", "fitted [mm]", "held out [mm]",
                 "held out [%]", "source's own fit [mm]"),
                tuple(rows),
            ),
            Table(
                "every pose", ("pose", "role", "tensions [N]", "p1 [mm]", "p2 [mm]", "p3 [mm]", "p4 [mm]", "p4 [%]"),
                tuple(each),
            ),
        ),
        (
            *(f"failed: {text}" for text in failed),
            f"modulus {modulus / kPa:.0f} kPa, 95 % {low / kPa:.0f} .. {high / kPa:.0f} kPa: of the scatter alone, at "
            "this number of pieces, whose error is not in the interval",
            f"held-out poses: last marker {rms(tip) / mm:.0f} mm rms = {100 * rms(tip) / _LENGTH:.1f} % of "
            f"{_LENGTH / mm:.0f} mm, median {float(np.median(tip)) / mm:.0f} mm; not the "
            f"model's error alone: {pieces}, so that at large tension much of it may be the number of pieces",
            "the source fitted modulus, Poisson's ratio and density on all poses at once, with another model",
        ),
        (
            *found.notes,
            f"with the least tension the first marker is already "
            f"{gaps[np.argmin(poses.tensions.sum(axis=1)), 0] / mm:.0f} mm off: where the base's marker sits against "
            "the rod's clamp is not stated",
            "the last link has no tendon: its marker turns with the end of the first, whose thin end bends most, so "
            "that taper, modulus and the place of the tendons' end all show there, and finer pieces still move it",
            "friction of the tendons, and slack before they pull, are not in the model; nor are loading and unloading "
            "in the data, which hold one static pose a torque",
        ),
        _panels(poses, after, held),
        not failed,
    )


def _failures(poses: Poses, found: Identified, gaps: Array) -> list[str]:
    """What did not come out, in words; gaps of all predictions, shape (2, n, 4)."""
    failed = []
    if not found.success:
        failed.append(
            f"the search for the modulus ended with {found.status} after {found.iterations} steps: its slope, a "
            "difference of two answers, did not become flat"
        )
    missing = [name for name, one in zip(poses.names, gaps.swapaxes(0, 1), strict=True) if not np.isfinite(one).all()]
    if missing:
        failed.append(f"no stable posture at the tensions of {', '.join(missing)}")
    return failed


def _mm(value: float) -> str:
    return f"{value / mm:.1f}" if np.isfinite(value) else "-"


def _panels(poses: Poses, model: Array, held: NDArray[np.bool_]) -> tuple[Panel, ...]:
    panels = []
    kinds = (("first tendon", [1, 0]), ("second tendon", [0, 1]), ("both tendons", [1, 1]))
    for title, pulled in kinds:
        rows = np.flatnonzero(((poses.tensions > 0.0) == pulled).all(axis=1))
        if not rows.size:
            continue
        across = 0 if title == "both tendons" else 1
        series = []
        for i in rows:
            seen, made = poses.markers[i] / mm, model[i] / mm
            gaps = np.stack([seen, made, np.full(seen.shape, np.nan)], axis=1).reshape(-1, 3)
            series += [
                Series("off by", gaps[:, across], gaps[:, 2]),
                Series("measured", seen[:, across], seen[:, 2]),
                Series("held out" if held[i] else "model at points", made[:, across], made[:, 2]),
            ]
        panels.append(Panel(title, f"{'xy'[across]} [mm]", "z, down the rod [mm]", tuple(series), equal=True))
    return tuple(panels)
