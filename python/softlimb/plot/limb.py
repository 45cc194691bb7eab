"""A limb in space: actuators as tubes, plates as discs, loads as arrows, and two views from the side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.plot import style
from softlimb.units import kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.limb import Posture, Segment

Array: TypeAlias = NDArray[np.float64]

_AROUND = 20  # faces around a tube
_ALONG = 28  # rings along a tube
_PLATE_COLOUR = (0.62, 0.65, 0.68)
_LIGHT = np.array([0.35, -0.75, 0.56])  # direction towards the light, from the viewer's upper left


def limb(posture: Posture, ax: Axes | None = None, *, loads: bool = True) -> Figure | Axes:
    """Draw a posture.

    Parameters
    ----------
    posture : Posture
    ax : matplotlib 3-D axes, optional
        Where to draw the limb in space. Without it a figure is made, with the limb seen from two sides as well.
    loads : bool
        Draw gravity, forces and moments as arrows.

    Returns
    -------
    Figure or Axes
        The figure made, or `ax`.

    Notes
    -----
    Lengths in mm, equal on all axes. A limb that gravity pulls along +z is drawn hanging: the picture is turned half a
    turn, not mirrored. Colours show pressure; where a rod's radius is not known it is drawn as a thin line of 1 % of
    the limb's length.
    """
    if ax is not None:
        _draw_space(posture, ax, loads)
        return ax
    figure = style.new_figure(180.0, 125.0)
    grid = figure.add_gridspec(1, 3, width_ratios=[2.2, 1.0, 1.0])
    space = figure.add_subplot(grid[0, 0], projection="3d")
    _draw_space(posture, space, loads)
    front = figure.add_subplot(grid[0, 1])
    side = figure.add_subplot(grid[0, 2], sharey=front)
    side_view(posture, front, 0)
    side_view(posture, side, 1)
    side.set_ylabel("")
    side.tick_params(labelleft=False)
    if getattr(posture, "pressures", None) is not None:
        _colour_bar(posture, figure, [front, side])
    return figure


def side_view(posture: Posture, ax: Axes, axis: int) -> Axes:
    """Draw a posture seen along one horizontal axis.

    Parameters
    ----------
    posture : Posture
    ax : matplotlib axes
    axis : int
        Horizontal axis of the picture: 0 for x, 1 for y. The vertical one is z.
    """
    for tube in _tubes(posture):
        ax.plot(*(tube.points[:, [axis, 2]].T / mm), color=tube.colour, linewidth=2.2, solid_capstyle="butt")
    for plate in _plates(posture):
        corners = np.array([plate.rim(along) for along in (0.0, 1.0)]) / mm
        flat = corners[..., [axis, 2]].reshape(-1, 2)
        ax.fill(*_hull(flat).T, facecolor=_PLATE_COLOUR, edgecolor="0.3", linewidth=0.6)
    ax.plot(*(posture.centreline(60)[:, [axis, 2]].T / mm), color="black", linewidth=0.9, linestyle=(0, (4, 2)))
    style.finish(ax, f"{'xy'[axis]} [mm]", "z [mm]")
    ax.set_aspect("equal", adjustable="datalim")
    ax.locator_params(axis="x", nbins=4)
    if _hangs(posture):
        ax.yaxis.set_inverted(True)
    return ax


@dataclass(frozen=True)
class _Tube:
    points: Array  # (n, 3)
    radius: float
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class _Disc:
    pose: Array  # of the face where rods end
    thickness: float
    radius: float

    def rim(self, along: float, count: int = 40) -> Array:
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        height = np.full(count, along * self.thickness)
        local = np.stack([self.radius * np.cos(angle), self.radius * np.sin(angle), height])
        return np.asarray((self.pose[:3, :3] @ local).T + self.pose[:3, 3])


def _hangs(posture: Posture) -> bool:
    return bool(posture.loads["gravity"][2] > 0.0)


def _outer_radius(segment: Segment, i: int, fallback: float) -> float:
    actuators = getattr(segment, "actuators", None)
    layers = getattr(actuators[i], "layers", None) if actuators else None
    return float(layers[-1].outer_radius) if layers else fallback


def _pressure_scale(posture: Posture) -> tuple[float, float]:
    pressures = np.asarray(posture.pressures) / kPa
    return min(0.0, float(pressures.min())), max(float(pressures.max()), 1.0)


def _tubes(posture: Posture) -> Iterator[_Tube]:
    from matplotlib import colormaps

    thin = 0.01 * float(posture.limb.length)
    pressures = getattr(posture, "pressures", None)
    flat = None if pressures is None else np.ravel(pressures) / kPa
    low, high = (0.0, 1.0) if flat is None else _pressure_scale(posture)
    place = 0
    for segment, rods in zip(posture.limb.segments, posture.rods, strict=True):
        for i, rod in enumerate(rods):
            share = 0.5 if flat is None else (flat[place] - low) / (high - low)
            colour = tuple(colormaps[style.PRESSURE_COLOURS](0.08 + 0.87 * share)[:3])
            yield _Tube(np.asarray(rod.centreline(_ALONG)), _outer_radius(segment, i, thin), colour)
            place += 1


def _plates(posture: Posture) -> Iterator[_Disc]:
    """The base plate, which is only drawn, and the limb's own plates."""
    thin, segments = 0.01 * float(posture.limb.length), posture.limb.segments
    reaches = [
        max(
            float(np.hypot(frame[0, 3], frame[1, 3])) + _outer_radius(segment, i, thin)
            for frames in (segment.base_frames, segment.end_frames)
            for i, frame in enumerate(np.asarray(frames))
        )
        for segment in segments
    ]
    thickness = segments[0].plate.thickness or thin
    base = np.eye(4)
    base[2, 3] = -thickness
    yield _Disc(base, thickness, 1.05 * reaches[0])
    for j, (pose, segment) in enumerate(zip(np.asarray(posture.plates), segments, strict=True)):
        reach = max(reaches[j : j + 2])
        yield _Disc(pose, segment.plate.thickness or 0.3 * thin, 1.05 * reach)


def _rings(points: Array, radius: float) -> Array:
    """Circles about a line, (n, around + 1, 3), with a normal carried along it without twist."""
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    normal = np.cross(tangents[0], [1.0, 0.0, 0.0] if abs(tangents[0, 0]) < 0.7 else [0.0, 1.0, 0.0])
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    rings = []
    for point, tangent in zip(points, tangents, strict=True):
        normal = normal - tangent * (normal @ tangent)
        normal /= np.linalg.norm(normal)
        across = np.cross(tangent, normal)
        rings.append(point + radius * (np.outer(np.cos(angle), normal) + np.outer(np.sin(angle), across)))
    return np.array(rings)


def _quads(rings: Array) -> Array:
    """Faces between neighbouring circles, (m, 4, 3)."""
    faces = np.stack([rings[:-1, :-1], rings[1:, :-1], rings[1:, 1:], rings[:-1, 1:]], axis=2)
    return faces.reshape(-1, 4, 3)


def _shaded(faces: Array, colour: tuple[float, ...], light: Array) -> Array:
    """Face colours under one lamp and its surroundings, (m, 3)."""
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    # Half of the light comes from all sides, so that the far side of a tube does not turn black.
    brightness = 0.62 + 0.38 * normals @ light
    tint = np.clip(np.outer(brightness, colour), 0.0, 1.0)
    return tint + 0.12 * np.clip(brightness - 0.9, 0.0, 1.0)[:, None]


def _draw_space(posture: Posture, ax: Any, loads: bool) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    turn = np.array([1.0, -1.0, -1.0]) if _hangs(posture) else np.ones(3)
    light = _LIGHT / np.linalg.norm(_LIGHT) * turn
    polygons: list[Array] = []
    colours: list[Array] = []
    for tube in _tubes(posture):
        faces = _quads(_rings(tube.points, tube.radius))
        polygons.extend(faces / mm)
        colours.extend(_shaded(faces, tube.colour, light))
    for disc in _plates(posture):
        for faces in _disc_faces(disc):
            polygons.extend(faces / mm)
            colours.extend(_shaded(faces, _PLATE_COLOUR, light))
    # One collection, so that faces of all bodies are sorted together from back to front.
    ax.add_collection3d(Poly3DCollection(polygons, facecolors=colours, edgecolors=colours, linewidths=0.2))
    corners = np.concatenate(polygons)
    if loads:
        corners = np.concatenate([corners, _draw_loads(posture, ax, corners, turn)])
    _equal_axes(ax, corners)
    ax.view_init(elev=14.0, azim=-62.0, roll=180.0 if _hangs(posture) else 0.0)
    for name in "xyz":
        getattr(ax, f"set_{name}label")(f"{name} [mm]", fontsize=style.FONT_SIZE)
        getattr(ax, f"{name}axis").set_pane_color((1.0, 1.0, 1.0, 0.0))
    ax.tick_params(labelsize=style.FONT_SIZE - 2.0, pad=0)
    ax.locator_params(axis="x", nbins=4)
    ax.locator_params(axis="y", nbins=4)


def _disc_faces(disc: _Disc) -> Iterator[Array]:
    bottom, top = disc.rim(0.0), disc.rim(1.0)
    yield _quads(np.array([top, bottom]))
    for rim, middle in ((bottom, bottom[:-1].mean(axis=0)), (top, top[:-1].mean(axis=0))):
        # A wheel of wedges in four rings: one large face would be sorted by its centre and cover tubes it should not.
        for inner, outer in ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0)):
            faces = _quads(np.array([middle + outer * (rim - middle), middle + inner * (rim - middle)]))
            yield faces[:, ::-1] if rim is bottom else faces


def _equal_axes(ax: Any, corners: Array) -> None:
    low, high = corners.min(axis=0), corners.max(axis=0)
    # A straight limb is a thin column: half of its height keeps room for the ticks.
    span = np.maximum(high - low, 0.45 * (high - low).max()) * 1.04
    middle = 0.5 * (low + high)
    ax.set_xlim(middle[0] - span[0] / 2, middle[0] + span[0] / 2)
    ax.set_ylim(middle[1] - span[1] / 2, middle[1] + span[1] / 2)
    ax.set_zlim(middle[2] - span[2] / 2, middle[2] + span[2] / 2)
    ax.set_box_aspect(span / span.max(), zoom=1.0)


def _draw_loads(posture: Posture, ax: Any, corners: Array, turn: Array) -> Array:
    """Arrows with value and unit; returns their ends so that the axes make room for them [mm]."""
    size = float((corners.max(axis=0) - corners.min(axis=0)).max())
    plates = np.asarray(posture.plates)
    forces, moments = _applied(posture)
    ends = []
    for vectors, unit, line in ((forces, "N", "-"), (moments, "N m", (0, (3, 1.5)))):
        largest = max((float(np.linalg.norm(vector)) for vector in vectors), default=0.0)
        for plate, vector in zip(plates, vectors, strict=True):
            norm = float(np.linalg.norm(vector))
            if norm > 0.0:
                # A small load stays visible: a quarter of the largest at least.
                reach = 0.22 * size * max(norm / largest, 0.25) * vector / norm
                start = plate[:3, 3] / mm
                ends.append(_arrow(ax, start, reach, f"{norm:.3g} {unit}", style.LOAD_COLOUR, line))
    gravity = np.asarray(posture.loads["gravity"], dtype=float)
    strength = float(np.linalg.norm(gravity))
    if strength > 0.0:
        # Beside the base, where no limb is.
        start = np.array([corners[:, 0].min(), corners[:, 1].max(), 0.0])
        reach = 0.16 * size * gravity / strength
        ends.append(_arrow(ax, start, reach, f"g = {strength:.2f} m/s²", style.GRAVITY_COLOUR, "-"))
        ends.append(start)
    return np.array(ends).reshape(-1, 3)


def _applied(posture: Posture) -> tuple[Array, Array]:
    """Force and moment on each plate in base axes [N], [N m], shape (J, 3) each."""
    plates = np.asarray(posture.plates)
    wrenches = posture.loads.get("plate_wrenches")
    total = np.zeros((len(plates), 6)) if wrenches is None else np.array(wrenches, dtype=float)
    total[-1, :3] += posture.loads["tip_force"]
    total[-1, 3:] += posture.loads["tip_moment"]
    if posture.loads.get("frame") == "plate":
        total = np.concatenate(
            [np.einsum("jab,jb->ja", plates[:, :3, :3], part) for part in (total[:, :3], total[:, 3:])], axis=1
        )
    return total[:, :3], total[:, 3:]


def _arrow(ax: Any, start: Array, reach: Array, text: str, colour: str, line: Any) -> Array:
    end = start + reach
    ax.quiver(*start, *reach, color=colour, linewidth=1.8, linestyle=line, arrow_length_ratio=0.22, zorder=10)
    ax.text(
        *(start + 1.12 * reach),
        text,
        color=colour,
        fontsize=style.FONT_SIZE - 1.0,
        ha="center",
        va="center",
        zorder=11,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
    )
    return np.asarray(end)


def _colour_bar(posture: Posture, figure: Figure, axes: list[Axes]) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    low, high = _pressure_scale(posture)
    # The same part of the map that the tubes use.
    colours = ListedColormap(colormaps[style.PRESSURE_COLOURS](np.linspace(0.08, 0.95, 128)))
    bar = figure.colorbar(ScalarMappable(Normalize(low, high), colours), ax=axes, shrink=0.6, aspect=25)
    bar.set_label("gauge pressure [kPa]", fontsize=style.FONT_SIZE)
    bar.ax.tick_params(labelsize=style.FONT_SIZE - 1.0)


def _hull(points: Array) -> Array:
    """Convex hull of points in the plane, counter-clockwise (Andrew's monotone chain, 1979)."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]

    def chain(sequence: Array) -> list[Array]:
        kept: list[Array] = []
        for point in sequence:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], point) <= 0.0:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
