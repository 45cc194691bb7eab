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

    from softlimb.limb import Posture

Array: TypeAlias = NDArray[np.float64]
Colour: TypeAlias = tuple[float, ...]

_WIDTH, _HEIGHT = 180.0, 110.0  # of the figure: a text column and a half of most journals [mm]
_AROUND = 20  # faces around a tube
_ALONG = 28  # rings along a tube
_BOX_COLOUR = "0.8"
_PLATE_COLOUR = (0.66, 0.69, 0.72)
_ROD_COLOUR = (0.82, 0.82, 0.82)  # no colour of the pressures: what has none
_FILL = 0.76  # how much of the axes the limb fills; ticks and labels need the rest
_ELEVATION, _AZIMUTH = 14.0, -62.0  # of the viewer [deg]


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
    turn, not mirrored. A posture whose solve did not succeed says so in red above the picture. Colours show pressure.
    Tubes have their unpressurised outer radius; where it is not known a rod is drawn 1 % of the limb's length thick.
    """
    if ax is not None:
        _draw_space(posture, ax, loads)
        if not posture.success:
            ax.set_title(_warning(posture), color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE + 2.0)
        return ax
    figure = style.new_figure(_WIDTH, _HEIGHT, constrained=False)
    # The numbers of z stand on the left of a hanging limb and on the right of a standing one.
    left = 0.03 if _hangs(posture) else -0.035
    _draw_space(posture, figure.add_axes((left, 0.0, 0.55, 1.0), projection="3d"), loads)
    places = _side_places(_limits(posture))
    front, side = (figure.add_axes(place) for place in places)
    side_view(posture, front, 0)
    side_view(posture, side, 1)
    if places[0][1] == places[1][1]:  # beside each other they share the scale of z
        side.set_ylabel("")
        side.tick_params(labelleft=False)
    if not posture.success:
        figure.suptitle(_warning(posture), color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE + 2.0)
    if posture.pressures is not None:
        colour_bar(figure, figure.add_axes((0.915, 0.25, 0.012, 0.5)), _largest_pressure(posture))
    return figure


def _warning(posture: Posture) -> str:
    return f"not an equilibrium: {posture.status}"


def _side_places(limits: Array) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """Where the two views go, as parts of the figure: beside or above each other, whatever makes them larger."""
    x, y, z = np.ptp(limits, axis=1)
    left, bottom, width, height = 0.625 * _WIDTH, 0.13 * _HEIGHT, 0.26 * _WIDTH, 0.84 * _HEIGHT
    gap, label = 7.0, 13.0  # between the views; for ticks and label of the upper one [mm]
    beside, above = min((width - gap) / (x + y), height / z), min(width / max(x, y), 0.5 * (height - label) / z)
    scale = max(beside, above)
    if beside >= above:
        floor = bottom + 0.5 * (height - z * scale)
        boxes = ((left, floor, x * scale, z * scale), (left + x * scale + gap, floor, y * scale, z * scale))
    else:
        floor = bottom + 0.5 * (height - label) - z * scale
        boxes = ((left, floor + z * scale + label, x * scale, z * scale), (left, floor, y * scale, z * scale))
    parts = [(a / _WIDTH, b / _HEIGHT, c / _WIDTH, d / _HEIGHT) for a, b, c, d in boxes]
    return parts[0], parts[1]


def side_view(posture: Posture, ax: Axes, axis: int, *, highest: float | None = None) -> Axes:
    """Draw a posture seen along one horizontal axis.

    Parameters
    ----------
    posture : Posture
    ax : matplotlib axes
    axis : int
        Horizontal axis of the picture: 0 for x, 1 for y. The vertical one is z.
    highest : float, optional
        End of the colours [Pa], where several pictures share it. Default: a round number above the posture's own.

    Returns
    -------
    Axes
    """
    shown, depth = [axis, 2], 1 - axis
    # The viewer stands at -y in the first view and at +x in the second, opposite when z points down: far things first.
    near = (-1.0 if axis == 0 else 1.0) * (-1.0 if _hangs(posture) else 1.0)
    for tube in sorted(_tubes(posture, highest), key=lambda tube: near * float(tube.points[:, depth].mean())):
        outline = _band(tube.points[:, shown], tube.radius) / mm
        ax.fill(*outline.T, facecolor=tube.colour, edgecolor="0.25", linewidth=0.5)
    for plate in _plates(posture):
        rims = np.concatenate([plate.rim(0.0), plate.rim(1.0)]) / mm
        ax.fill(*hull(rims[:, shown]).T, facecolor=_PLATE_COLOUR, edgecolor="0.25", linewidth=0.5)
    ax.plot(*(posture.centreline(60)[:, shown].T / mm), color="black", linewidth=1.0, linestyle=(0, (4, 2)))
    style.finish(ax, f"{'xy'[axis]} [mm]", "z [mm]")
    ax.set_aspect("equal", adjustable="box")
    limits = _limits(posture)
    ax.set_xlim(*limits[axis])
    ax.set_ylim(*(limits[2][::-1] if _hangs(posture) else limits[2]))
    box = ax.get_window_extent()
    on_paper = np.array([box.width, box.height]) / ax.figure.dpi * 25.4  # [mm]
    scale = float(np.min(on_paper / np.ptp(limits[shown], axis=1)))
    # A tick label is 6 mm wide and 3 mm high on paper.
    ax.tick_params(labelsize=style.FONT_SIZE - 2.0)
    ax.xaxis.set_major_locator(ticks(7.0 / scale, *limits[axis]))
    ax.yaxis.set_major_locator(ticks(7.0 / scale, *limits[2]))
    return ax


def outline_of_tip(posture: Posture, pose: Array) -> Array:
    """Points around the tip's plate, (n, 3) [m], were it at a pose (4, 4): those of its two rims in turn."""
    *_, last = _plates(posture)
    disc = _Disc(pose, last.thickness, last.radius)
    return np.concatenate([disc.rim(0.0), disc.rim(1.0)])


def hull(points: Array) -> Array:
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


@dataclass(frozen=True)
class _Tube:
    points: Array  # (n, 3)
    radius: float
    colour: Colour


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


def _largest_pressure(posture: Posture) -> float:
    """End of the colours [kPa]: a round number above all pressures."""
    largest = float(np.max(np.abs(np.asarray(posture.pressures)))) / kPa
    return max(10.0, 10.0 * float(np.ceil(largest / 10.0 - 1e-9)))


def _tubes(posture: Posture, highest: float | None = None) -> Iterator[_Tube]:
    from matplotlib import colormaps

    end = _largest_pressure(posture) if highest is None and posture.pressures is not None else (highest or kPa) / kPa
    thin = 0.01 * float(posture.limb.length)
    low, high = style.PRESSURE_SHARE
    pressures = None if posture.pressures is None else np.ravel(posture.pressures) / kPa
    actuator = 0
    for segment, rods in zip(posture.limb.segments, posture.rods, strict=True):
        for rod in rods:
            colour: Colour = _ROD_COLOUR
            if pressures is not None and segment.actuators:
                share = max(0.0, float(pressures[actuator])) / end
                colour = tuple(colormaps[style.PRESSURE_COLOURS](low + (high - low) * share)[:3])
                actuator += 1
            yield _Tube(rod.centreline(_ALONG), rod.radius or thin, colour)


def _plates(posture: Posture) -> Iterator[_Disc]:
    """The base plate, which is only drawn, and the limb's own plates."""
    thin, segments = 0.01 * float(posture.limb.length), posture.limb.segments
    reaches = [
        max(
            float(np.hypot(frame[0, 3], frame[1, 3])) + (rod.radius or thin)
            for frames in (segment.base_frames, segment.end_frames)
            for rod, frame in zip(rods, frames, strict=True)
        )
        for segment, rods in zip(segments, posture.rods, strict=True)
    ]
    thickness = segments[0].plate.thickness or thin
    base = np.eye(4)
    base[2, 3] = -thickness
    yield _Disc(base, thickness, 1.05 * reaches[0])
    for j, (pose, segment) in enumerate(zip(np.asarray(posture.plates), segments, strict=True)):
        reach = max(reaches[j : j + 2])
        yield _Disc(pose, segment.plate.thickness or 0.3 * thin, 1.05 * reach)


def _limits(posture: Posture) -> Array:
    """What the views show, (3, 2) [mm]: everything, a margin, and no axis shorter than a quarter of the longest."""
    points = [tube.points + offset for tube in _tubes(posture) for offset in (-tube.radius, tube.radius)]
    points += [plate.rim(along) for plate in _plates(posture) for along in (0.0, 1.0)]
    corners = np.concatenate(points) / mm
    low, high = corners.min(axis=0), corners.max(axis=0)
    span = np.maximum(high - low, 0.25 * (high - low).max())
    span = span + 0.06 * span.max()
    middle = 0.5 * (low + high)
    return np.stack([middle - 0.5 * span, middle + 0.5 * span], axis=1)


def ticks(least: float, low: float, high: float) -> Any:
    """Ticks at round distances, at least `least` apart [mm]; where that leaves fewer than two, one towards each end."""
    from matplotlib.ticker import FixedLocator

    steps = [digit * 10.0**power for power in range(-2, 5) for digit in (1.0, 2.0, 5.0)]
    step = next((step for step in steps if step >= least), steps[-1])
    first, last = int(np.ceil(low / step)), int(np.floor(high / step))
    if last > first:
        return FixedLocator([step * i for i in range(first, last + 1)])
    fine = max((step for step in steps if step <= (high - low) / 3.0), default=steps[0])
    return FixedLocator([fine * float(np.ceil(low / fine)), fine * float(np.floor(high / fine))])


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


def _band(line: Array, radius: float) -> Array:
    """Outline of a line in the plane drawn 2 radius wide, (2 n, 2)."""
    along = np.gradient(line, axis=0)
    # Where a tube points at the viewer the line stands still; any direction will do there.
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across *= radius / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    return np.concatenate([line + across, (line - across)[::-1]])


def _quads(rings: Array) -> Array:
    """Faces between neighbouring circles, (m, 4, 3)."""
    faces = np.stack([rings[:-1, :-1], rings[1:, :-1], rings[1:, 1:], rings[:-1, 1:]], axis=2)
    return faces.reshape(-1, 4, 3)


def _shaded(faces: Array, colour: Colour, light: Array) -> Array:
    """Face colours under one lamp and its surroundings, (m, 3)."""
    # By the diagonals: a wedge at the middle of a disc has two corners in one place.
    normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    # Most of the light comes from all sides, so that the far side of a tube does not turn black.
    brightness = 0.78 + 0.26 * normals @ light
    return np.clip(np.outer(brightness, colour), 0.0, 1.0)


@dataclass(frozen=True)
class _Camera:
    """Directions of the picture in space."""

    right: Array
    up: Array
    towards: Array  # from the limb to the viewer
    roll: float  # [deg]

    @classmethod
    def on(cls, posture: Posture) -> _Camera:
        elevation, azimuth = np.radians([_ELEVATION, _AZIMUTH])
        towards = np.array(
            [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
        )
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        up = np.cross(towards, right)
        return cls(-right, -up, towards, 180.0) if _hangs(posture) else cls(right, up, towards, 0.0)

    @property
    def plane(self) -> tuple[Array, Array]:
        return self.right, self.up

    def flat(self, points: Array) -> Array:
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def _draw_space(posture: Posture, ax: Any, loads: bool) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped, unused-ignore]

    camera = _Camera.on(posture)
    light = -0.5 * camera.right + 0.6 * camera.up + 0.6 * camera.towards
    light /= np.linalg.norm(light)
    polygons: list[Array] = []
    colours: list[Array] = []
    for tube in _tubes(posture):
        faces = _quads(_rings(tube.points, tube.radius))[:, ::-1]  # outer side out
        polygons.extend(faces / mm)
        colours.extend(_shaded(faces, tube.colour, light))
    for disc in _plates(posture):
        for faces in _disc_faces(disc):
            polygons.extend(faces / mm)
            colours.extend(_shaded(faces, _PLATE_COLOUR, light))
    # Arrows go over the limb; left to itself matplotlib hides an arrow that starts inside a plate.
    ax.computed_zorder = False
    # One collection, so that faces of all bodies are sorted together from back to front.
    ax.add_collection3d(Poly3DCollection(polygons, facecolors=colours, edgecolors=colours, linewidths=0.2))
    limits = _limits(posture)
    if loads:
        limits = _draw_loads(posture, ax, np.concatenate(polygons), limits, camera)
    middle, span = limits.mean(axis=1), np.ptp(limits, axis=1)
    # A straight limb is a thin column: 0.4 of its height keeps room for the ticks.
    span = np.maximum(span, 0.4 * span.max())
    ax.set_xlim(middle[0] - span[0] / 2, middle[0] + span[0] / 2)
    ax.set_ylim(middle[1] - span[1] / 2, middle[1] + span[1] / 2)
    ax.set_zlim(middle[2] - span[2] / 2, middle[2] + span[2] / 2)
    corners = np.array(np.meshgrid(*([-0.5, 0.5],) * 3)).reshape(3, -1).T * span
    extent = float(np.ptp(camera.flat(corners), axis=0).max())
    seen = extent / np.linalg.norm(span)
    ax.set_proj_type("ortho")
    # matplotlib scales by the box's diagonal; what counts is what the viewer sees of it.
    ax.set_box_aspect(tuple(span), zoom=_FILL / seen)
    ax.view_init(elev=_ELEVATION, azim=_AZIMUTH, roll=camera.roll)
    window = ax.get_window_extent()
    scale = _FILL * min(window.width, window.height) / ax.figure.dpi * 25.4 / extent  # of the paper
    for i, name in enumerate("xyz"):
        line = getattr(ax, f"{name}axis")
        low, high = middle[i] - 0.5 * span[i], middle[i] + 0.5 * span[i]
        # At the corner of largest x and least y the numbers of both axes would meet.
        ends = (low + (8.5 / scale if name == "y" else 0.0), high - (4.5 / scale if name == "x" else 0.0))
        line.set_label_text(f"{name} [mm]", fontsize=style.FONT_SIZE)
        line.labelpad = -3.0
        # Without its edges the box seems to be cut off. `set_pane_color` would make them as transparent as the faces.
        # A pane left open, as matplotlib makes it, has three edges.
        line.pane.set(facecolor="none", edgecolor=_BOX_COLOUR, linewidth=0.5, alpha=None, closed=True)
        # A number is 6 mm wide and 3 mm high on paper; y is seen from its end.
        line.set_major_locator(ticks((9.0, 14.0, 6.0)[i] / scale, *ends))
        line._axinfo["grid"].update(color="0.88", linewidth=0.5)
    ax.tick_params(labelsize=style.FONT_SIZE - 2.0, pad=0.0)
    # The numbers of z stand beside an upright axis, not below a sloping one: they are wider than high.
    letters = len(f"{np.abs(limits[2]).max():.0f}")
    ax.zaxis.labelpad = (8.0 if camera.roll else 6.0) + 4.0 * max(0, letters - 3)
    ax.tick_params(axis="z", pad=4.0 if camera.roll else 3.0)


def _disc_faces(disc: _Disc) -> Iterator[Array]:
    bottom, top = disc.rim(0.0), disc.rim(1.0)
    yield _quads(np.array([top, bottom]))
    for rim in (bottom, top):
        middle = rim[:-1].mean(axis=0)
        # A wheel of wedges in four rings: one large face would be sorted by its centre and cover tubes it should not.
        for inner, outer in ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0)):
            faces = _quads(np.array([middle + outer * (rim - middle), middle + inner * (rim - middle)]))
            yield faces if rim is bottom else faces[:, ::-1]


@dataclass(frozen=True)
class _Arrow:
    start: Array
    reach: Array
    text: str
    colour: str
    line: Any


def _draw_loads(posture: Posture, ax: Any, corners: Array, limits: Array, camera: _Camera) -> Array:
    """Arrows with value and unit; returns limits with room for them [mm]."""
    size = float(np.ptp(limits, axis=1).max())
    arrows = list(_load_arrows(posture, size))
    gravity = np.asarray(posture.loads["gravity"], dtype=float)
    if np.any(gravity):
        reach = 0.16 * size * gravity / np.linalg.norm(gravity)
        text = f"gravity\n{np.linalg.norm(gravity):.3g} m/s²"
        shafts = [arrow.start + share * arrow.reach for arrow in arrows for share in np.linspace(0.0, 1.3, 6)]
        taken = np.concatenate([corners, np.reshape(shafts, (-1, 3))])
        arrows.append(_Arrow(_free_corner(limits, reach, taken, camera), reach, text, style.GRAVITY_COLOUR, "-"))
    for arrow in arrows:
        ax.quiver(
            *arrow.start,
            *arrow.reach,
            color=arrow.colour,
            linewidth=1.8,
            linestyle=arrow.line,
            arrow_length_ratio=0.25,
            zorder=10,
        )
    ends = [point for arrow in arrows for point in (arrow.start, arrow.start + arrow.reach)]
    for arrow, (place, half) in zip(arrows, _label_places(arrows, size, camera), strict=True):
        # The whole label goes into the box: outside it are the numbers of the axes.
        ends += [place + sign * h * axis for sign in (-1.0, 1.0) for h, axis in zip(half, camera.plane, strict=True)]
        ax.text(
            *place,
            arrow.text,
            color=arrow.colour,
            fontsize=style.FONT_SIZE - 1.0,
            ha="center",
            va="center",
            zorder=11,
            linespacing=1.0,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.4},
        )
    if not ends:
        return limits
    return np.stack([np.minimum(limits[:, 0], np.min(ends, axis=0)), np.maximum(limits[:, 1], np.max(ends, axis=0))], 1)


# Half of a label of 8 pt, as parts of the picture's size of 60 mm or more: a letter's width, a line's height.
_HALF_LETTER, _HALF_LINE = 0.0125, 0.027


def _label_places(arrows: list[_Arrow], size: float, camera: _Camera) -> Iterator[tuple[Array, Array]]:
    """Centre and half size of each arrow's label: near its head, off all arrows and off the labels before it."""
    shafts = [camera.flat(arrow.start + np.linspace(0.0, 1.0, 15)[:, None] * arrow.reach) for arrow in arrows]
    taken = np.concatenate(shafts) if shafts else np.zeros((0, 2))
    placed: list[tuple[Array, Array]] = []
    for arrow, shaft in zip(arrows, shafts, strict=True):
        lines = arrow.text.split("\n")
        half = size * np.array([_HALF_LETTER * max(len(line) for line in lines), _HALF_LINE * len(lines)])
        along = shaft[-1] - shaft[0]
        heading = float(np.arctan2(along[1], along[0]))
        best, fewest = np.zeros(2), np.inf
        # Straight ahead first, then turning away to both sides, then farther out.
        for gap in (0.025, 0.07, 0.12, 0.18, 0.25):
            for turn in np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120]):
                way = np.array([np.cos(heading + turn), np.sin(heading + turn)])
                shift = way * (gap * size + float(np.min(half / np.maximum(np.abs(way), 1e-9))))
                flat = shaft[-1] + shift
                over = np.all(np.abs(taken - flat) < half + 0.012 * size, axis=1).sum()
                over += sum(10 * bool(np.all(np.abs(flat - other) < half + extent)) for other, extent in placed)
                if over < fewest:
                    best, fewest = shift, over
            if fewest == 0:
                break
        placed.append((shaft[-1] + best, half))
        yield arrow.start + arrow.reach + best[0] * camera.right + best[1] * camera.up, half


def _load_arrows(posture: Posture, size: float) -> Iterator[_Arrow]:
    plates = np.asarray(posture.plates)
    forces, moments = _applied(posture)
    for vectors, unit, line in ((forces, "N", "-"), (moments, "N m", (0, (2.5, 1.2)))):
        largest = max(float(np.linalg.norm(vector)) for vector in vectors)
        for plate, vector in zip(plates, vectors, strict=True):
            norm = float(np.linalg.norm(vector))
            if norm > 0.0:
                # A small load stays visible: half of the largest at least.
                reach = 0.2 * size * max(norm / largest, 0.5) * vector / norm
                yield _Arrow(plate[:3, 3] / mm, reach, f"{norm:.3g} {unit}", style.LOAD_COLOUR, line)


def _applied(posture: Posture) -> tuple[Array, Array]:
    """Force and moment on each plate in base axes [N], [N m], shape (J, 3) each."""
    plates = np.asarray(posture.plates)
    wrenches = posture.loads.get("plate_wrenches")
    total = np.zeros((len(plates), 6)) if wrenches is None else np.array(wrenches, dtype=float)
    total[-1, :3] += posture.loads["tip_force"]
    total[-1, 3:] += posture.loads["tip_moment"]
    forces, moments = total[:, :3], total[:, 3:]
    if posture.loads.get("frame") == "plate":
        forces, moments = (np.einsum("jab,jb->ja", plates[:, :3, :3], part) for part in (forces, moments))
    return forces, moments


def _free_corner(limits: Array, reach: Array, corners: Array, camera: _Camera) -> Array:
    """A vertical edge of the box where an arrow is farthest from the limb in the picture."""
    inset = 0.12 * np.ptp(limits, axis=1)
    low, high = limits[:, 0] + inset, limits[:, 1] - inset
    body = camera.flat(corners[:: max(1, len(corners) // 2000)])
    # The outermost upright edges carry the numbers of z.
    edges = np.array(
        [[x, y, z] for x in limits[0] for y in limits[1] for z in np.linspace(limits[2, 0], limits[2, 1], 40)]
    )
    across = edges @ camera.right
    outermost = (across > across.max() - 1e-6) | (across < across.min() + 1e-6)
    body = np.concatenate([body, camera.flat(edges[outermost])])
    # The label below the arrow: 0.26 by 0.14 of the picture's size in 8 pt.
    size = float(np.ptp(limits, axis=1).max())
    downwards = camera.flat(reach) / max(float(np.linalg.norm(camera.flat(reach))), 1e-9 * size)
    box = np.array(np.meshgrid(np.linspace(-0.13, 0.13, 5), np.linspace(-0.05, 0.05, 3))).reshape(2, -1).T
    label = size * (box + 0.06 * downwards)
    best: Array = low
    room = -1.0
    for x in (low[0], high[0]):
        for y in (low[1], high[1]):
            for share in (0.0, 0.25, 0.5, 0.75, 1.0):
                start = np.array([x, y, low[2] + share * (high[2] - low[2])])
                start -= share * np.maximum(reach, 0.0) - (1.0 - share) * np.maximum(-reach, 0.0)
                arrow = camera.flat(start + np.linspace(0.0, 1.0, 6)[:, None] * reach)
                taken = np.concatenate([arrow, arrow[-1] + label])
                distance = float(np.linalg.norm(taken[:, None] - body, axis=-1).min())
                if distance > room:
                    best, room = start, distance
    return best


def colour_bar(figure: Figure, ax: Axes, highest: float) -> None:
    """Draw the scale of the tubes' colours into axes, 0 to ``highest`` [kPa]."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    # The same part of the map that the tubes use.
    colours = ListedColormap(colormaps[style.PRESSURE_COLOURS](np.linspace(*style.PRESSURE_SHARE, 128)))
    bar = figure.colorbar(ScalarMappable(Normalize(0.0, highest), colours), cax=ax)
    bar.set_label("gauge pressure [kPa]", fontsize=style.FONT_SIZE)
    bar.ax.tick_params(labelsize=style.FONT_SIZE - 1.0)


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
