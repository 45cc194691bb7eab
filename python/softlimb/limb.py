"""Rods, segments and limbs: from pressures to the static posture, and what a posture can be asked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb._core import Section
from softlimb.arguments import (
    finite_of_shape,
    is_rotation,
    joined,
    one_finite,
    one_not_negative,
    one_of,
    one_positive,
    one_real,
    shown,
    truth,
    truths,
)
from softlimb.derivatives import ring_directions
from softlimb.path import Path
from softlimb.posture import Posture, RodPosture, Verification
from softlimb.tube import SECTION_MODELS, VALVES, SectionModel, Tube, Valve

if TYPE_CHECKING:
    import os
    import pathlib
    from concurrent.futures import Executor

    from softlimb.payload import Payload
    from softlimb.reach import Reach
    from softlimb.sense import Sensed
    from softlimb.sweep import Batch
    from softlimb.workspace import Workspace

__all__ = ["Limb", "Plate", "Posture", "Rod", "RodPosture", "Segment", "Verification"]

Array = NDArray[np.float64]
Frame = Literal["base", "plate"]

_NO_LOAD = (0.0, 0.0, 0.0)
_ROUNDED_STRETCH = 1e-6  # a length that somebody computed may lie that far below the tube's own: no pressure gives it


def _frames(name: str, value: ArrayLike, count: int) -> Array:
    frames = finite_of_shape(name, value, (count, 4, 4))
    for number, frame in enumerate(frames):
        _require_pose(f"{name}[{number}]", frame)
    frames.setflags(write=False)
    return frames


def _require_pose(name: str, pose: Array) -> None:
    rotation = pose[:3, :3]
    if not is_rotation(rotation):
        raise ValueError(f"the upper left 3x3 block of {name} must be a rotation matrix, got {rotation.tolist()}")
    if not np.array_equal(pose[3], [0.0, 0.0, 0.0, 1.0]):
        raise ValueError(f"the last row of {name} must be (0, 0, 0, 1), got {pose[3].tolist()}")


@dataclass(frozen=True)
class Plate:
    """The rigid plate at the end of a segment.

    Parameters
    ----------
    thickness : float
        The next segment's rods start this far along the plate's z axis [m].
    mass : float
        With its centre half a thickness along z [kg].

    Raises
    ------
    ValueError
        A value is negative or not finite.
    """

    thickness: float = 0.0
    mass: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", one_not_negative("plate thickness", self.thickness))
        object.__setattr__(self, "mass", one_not_negative("plate mass", self.mass))


@dataclass(frozen=True)
class Rod:
    """A Cosserat rod: a section and a rest length.

    Parameters
    ----------
    section : Section
        Stiffness per rest length.
    length : float
        Rest length [m].
    radius : float, optional
        Outer radius [m], for clearance and pictures.

    Raises
    ------
    ValueError
        The length or the radius is not positive and finite.
    """

    section: Section
    length: float
    radius: float | None = None

    @property
    def outer_radius(self) -> float | None:
        """The same as ``radius``, under the name that tubes have."""
        return self.radius

    def __post_init__(self) -> None:
        if not isinstance(self.section, Section):
            raise TypeError(f"section must be a Section, got {type(self.section).__name__}")
        object.__setattr__(self, "length", one_positive("rod length", self.length))
        if self.radius is not None:
            object.__setattr__(self, "radius", one_positive("rod radius", self.radius))

    def cantilever(
        self,
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        tip_moment: ArrayLike = (0.0, 0.0, 0.0),
        *,
        distributed_force: ArrayLike = _NO_LOAD,
        distributed_moment: ArrayLike = _NO_LOAD,
        gravity: ArrayLike = (0.0, 0.0, 0.0),
        tolerance: float = 1e-6,
        start: Posture | RodPosture | None = None,
        prefer_stable: bool = True,
    ) -> RodPosture:
        """Shape of the rod clamped at the origin along +z, under dead loads.

        Parameters
        ----------
        tip_force, tip_moment : array_like, shape (3,)
            At the tip, base axes [N], [N m].
        distributed_force, distributed_moment : array_like, shape (3,)
            Per rest length, base axes [N/m], [N].
        gravity : array_like, shape (3,)
            [m/s^2]; acts on the section's mass per length.
        tolerance : float
            Tip error asked for, relative to the rod's length.
        start : Posture or RodPosture, optional
            An earlier answer to start from.
        prefer_stable : bool
            Leave an unstable equilibrium downhill.

        Returns
        -------
        RodPosture

        Raises
        ------
        ValueError
            A load is not finite or has the wrong shape, or the tolerance is out of range.

        Notes
        -----
        Zhang et al. eq. 4-6; MECHANICS, "Rod".
        """
        distributed: dict[str, Any] = {}
        if distributed_force is not _NO_LOAD:
            distributed["rod_forces"] = finite_of_shape("distributed_force", distributed_force, (3,))[None]
        if distributed_moment is not _NO_LOAD:
            distributed["rod_moments"] = finite_of_shape("distributed_moment", distributed_moment, (3,))[None]
        posture = self._alone.solve(
            tip_force=tip_force,
            tip_moment=tip_moment,
            gravity=gravity,
            tolerance=tolerance,
            start=start.posture if isinstance(start, RodPosture) else start,
            prefer_stable=prefer_stable,
            **distributed,
        )
        # Not out of `posture.rods`, which would hold it: the posture then goes with its last user, not by collection.
        return RodPosture(posture, 0, 0, 0)

    @cached_property
    def _alone(self) -> Limb:
        """A limb of this rod and nothing else."""
        return Limb([Segment(rods=[self], base_frames=np.eye(4)[None], end_frames=np.eye(4)[None])])

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_alone"}


class Segment:
    """Actuators or rods in parallel, and the plate at their end.

    Parameters
    ----------
    actuators : sequence of Tube, optional
        Pressure-driven actuators. Either these or ``rods``.
    rods : sequence of Rod, optional
        Rods given directly.
    ring_radius : float, optional
        Places the n rods on a ring of this radius [m], at angles 2 pi i / n from x, all along z.
    base_frames, end_frames : array_like, shape (n, 4, 4), optional
        Any other placement: pose of each rod's base in the frame of the proximal plate's distal face, and of its end in
        the plate's frame. Instead of ``ring_radius``.
    plate : Plate
        Default: no thickness, no mass.

    Raises
    ------
    ValueError
        Not exactly one of ``actuators`` and ``rods``, or of ring and frames; a frame is not a pose; no rods.
    """

    def __init__(
        self,
        actuators: Sequence[Tube] | None = None,
        *,
        rods: Sequence[Rod] | None = None,
        ring_radius: float | None = None,
        base_frames: ArrayLike | None = None,
        end_frames: ArrayLike | None = None,
        plate: Plate | None = None,
    ) -> None:
        if (actuators is None) == (rods is None):
            raise ValueError("a segment takes either actuators or rods: give exactly one of the two")
        name, kind, given = ("actuators", Tube, actuators) if actuators is not None else ("rods", Rod, rods)
        members: tuple[Tube | Rod, ...] = _tuple(name, given)
        for member in members:
            if not isinstance(member, kind):
                raise TypeError(f"{name} of a segment must each be a {kind.__name__}, got {type(member).__name__}")
        if not members:
            raise ValueError(f"{name} of a segment must be at least one {kind.__name__}, got none")
        self.members = members
        if not isinstance(plate, (Plate, type(None))):
            raise TypeError(f"plate must be a Plate, got {type(plate).__name__}")
        self.plate = Plate() if plate is None else plate
        self.ring_radius: float | None = None
        if ring_radius is not None:
            if base_frames is not None or end_frames is not None:
                raise ValueError("a segment is placed either by ring_radius or by base_frames and end_frames, got both")
            self.ring_radius = one_not_negative("ring_radius", ring_radius)
            self.base_frames = self.end_frames = _ring(len(members), self.ring_radius)
        else:
            if base_frames is None or end_frames is None:
                raise ValueError("a segment needs ring_radius, or both base_frames and end_frames")
            self.base_frames = _frames("base_frames", base_frames, len(members))
            self.end_frames = _frames("end_frames", end_frames, len(members))

    @property
    def actuators(self) -> tuple[Tube, ...]:
        """The tubes; empty for a segment of rods."""
        return tuple(member for member in self.members if isinstance(member, Tube))

    @property
    def rods(self) -> tuple[Rod, ...]:
        """The rods given directly; empty for a segment of actuators."""
        return tuple(member for member in self.members if isinstance(member, Rod))

    @property
    def length(self) -> float:
        """Mean unpressurised length of the members [m]."""
        return float(np.mean([member.length for member in self.members]))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Segment):
            return NotImplemented
        return (
            self.members == other.members
            and self.plate == other.plate
            and self.ring_radius == other.ring_radius
            and np.array_equal(self.base_frames, other.base_frames)
            and np.array_equal(self.end_frames, other.end_frames)
        )

    def __hash__(self) -> int:
        return hash((self.members, self.plate, self.ring_radius))

    def __repr__(self) -> str:
        kind = "actuators" if self.actuators else "rods"
        place = "given frames" if self.ring_radius is None else f"ring_radius={self.ring_radius:.6g}"
        return f"Segment({len(self.members)} {kind}, length={self.length:.6g}, {place}, {self.plate!r})"


def _ring(count: int, radius: float) -> Array:
    frames = np.tile(np.eye(4), (count, 1, 1))
    frames[:, :3, 3] = radius * ring_directions(count)
    frames.setflags(write=False)
    return frames


@dataclass(frozen=True)
class _Scene:
    """A scene as the core wants it, with what a posture keeps of the arguments that it came from."""

    core: _core.Scene
    pressures: Array | None
    rest_lengths: Array
    loads: dict[str, Any]
    model: tuple[SectionModel, Valve]
    refusal: tuple[str, str] | None  # status and reason where an actuator has no state


@dataclass(frozen=True)
class _CommonScene:
    """What many rows of pressures share: loads, holds and options of a solve."""

    core: _core.Scene  # its sections and rest lengths do not count
    model: tuple[SectionModel, Valve]
    tolerance: float
    prefer_stable: bool
    start: _core.Posture | None
    start_plates: Array | None

    @property
    def from_nothing(self) -> bool:
        """True where rows are solved from nothing, and only stable ones are answers."""
        return self.prefer_stable and self.start is None and self.start_plates is None


class Limb:
    """Segments in series, from the base upwards.

    Parameters
    ----------
    segments : sequence of Segment

    Raises
    ------
    ValueError
        There is no segment.
    """

    def __init__(self, segments: Sequence[Segment]) -> None:
        self.segments: tuple[Segment, ...] = _tuple("segments", segments)
        if not self.segments:
            raise ValueError("segments of a limb must be at least one Segment, got none")
        for segment in self.segments:
            if not isinstance(segment, Segment):
                raise TypeError(f"segments of a limb must each be a Segment, got {type(segment).__name__}")
        self._members = tuple(member for segment in self.segments for member in segment.members)
        self._tubes = tuple(member for member in self._members if isinstance(member, Tube))
        self._counts = tuple(len(segment.actuators) for segment in self.segments)
        self._length = sum(s.length for s in self.segments) + sum(s.plate.thickness for s in self.segments[:-1])
        self._geometry = _core.Geometry(
            [(s.base_frames, s.end_frames, s.plate.thickness, s.plate.mass) for s in self.segments], self._length
        )
        self._core_members = _core.Members(
            [m if isinstance(m, Tube) else (m.section, m.length, m.radius or 0.0) for m in self._members]
        )
        self._plain = _core.PlainSolver(self._geometry, self._core_members, self._counts)

    @property
    def length(self) -> float:
        """Unpressurised rods plus the plates between them [m]: what relative errors refer to."""
        return self._length

    @property
    def mass(self) -> float:
        """Actuators, rods and plates [kg], base plate excluded."""
        rods = sum(m.mass if isinstance(m, Tube) else m.section.mass_per_length * m.length for m in self._members)
        return float(rods) + sum(segment.plate.mass for segment in self.segments)

    @classmethod
    def from_toml(cls, path: str | pathlib.Path) -> Limb:
        """Read a limb from a TOML file; unknown keys, wrong types and missing units raise ValueError."""
        from softlimb.scenes import read_limb

        return read_limb(path)

    def to_toml(self, path: str | pathlib.Path) -> None:
        """Write the limb as a TOML file that `from_toml` reads back unchanged."""
        from softlimb.scenes import write_limb

        write_limb(self, path)

    def solve(
        self,
        pressures: ArrayLike | Sequence[ArrayLike] | None = None,
        *,
        rest_lengths: ArrayLike | Sequence[ArrayLike] | None = None,
        gravity: ArrayLike = (0.0, 0.0, 0.0),
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        tip_moment: ArrayLike = (0.0, 0.0, 0.0),
        plate_wrenches: ArrayLike | None = None,
        frame: Frame = "base",
        rod_forces: ArrayLike | Sequence[ArrayLike] | None = None,
        rod_moments: ArrayLike | Sequence[ArrayLike] | None = None,
        tip_pose: ArrayLike | None = None,
        tip_held: Sequence[bool] | None = None,
        plate_poses: ArrayLike | None = None,
        plate_held: ArrayLike | None = None,
        tolerance: float = 1e-6,
        start: Posture | ArrayLike | None = None,
        prefer_stable: bool = True,
        section: SectionModel = "tangent",
        valve: Valve = "open",
    ) -> Posture:
        """Find the static posture at given pressures or rest lengths.

        Parameters
        ----------
        pressures : array_like, shape (A,) or (J, n), or a list of J arrays
            Gauge pressure in each actuator [Pa], segment by segment. A limb of rods only needs none.
        rest_lengths : array_like, shape (R,) or (J, n), or a list of J arrays, optional
            Rest length of each rod [m] instead of pressures: a tube takes the pressure that gives it, a rod given
            directly keeps its section.
        gravity : array_like, shape (3,)
            Acceleration in the base frame [m/s^2]; a hanging limb has (0, 0, 9.81), because it grows along +z.
        tip_force, tip_moment : array_like, shape (3,)
            On the last plate at its origin [N], [N m].
        plate_wrenches : array_like, shape (J, 6), optional
            Force and moment on each plate at its origin [N, N m]; added to the tip's.
        frame : {"base", "plate"}
            Axes of the wrenches: of the base (dead loads), or of the plate they act on, with which they turn.
        rod_forces, rod_moments : array_like, shape (R, 3) or (J, n, 3), or a list of J arrays, optional
            Distributed load per rest length, base axes [N/m], [N]; weight comes from ``gravity``.
        tip_pose : array_like, shape (4, 4), optional
            Where the tip is held.
        tip_held : sequence of 6 bool, optional
            Which freedoms are held: translations along, then rotations about base axes, measured from ``tip_pose``.
            Default: all six when ``tip_pose`` is given. Without ``tip_pose`` the tip is held where the start has it: at
            the pose in ``start``, or else at that of the unpressurised limb.
        plate_poses, plate_held : array_like, shape (J, 4, 4) and (J, 6), optional
            The same for every plate; excludes ``tip_pose`` and ``tip_held``.
        tolerance : float
            Tip error asked for, relative to ``limb.length``; 1e-12 to 0.1.
        start : Posture or array_like of shape (J, 4, 4), optional
            Where to start: an earlier posture of this limb, or plate poses. From a posture near by a solve is fastest,
            and so is its Jacobian. Default: constant curvature, and a descent of the energy from there.
        prefer_stable : bool
            Leave an unstable equilibrium along its mode and descend to a stable one. False returns what is found first.
        section : {"tangent", "nonlinear", "paper"}
            What a tube hands to its rod, see `Tube.section`.
        valve : {"open", "locked"}
            Constant pressure or constant volume.

        Returns
        -------
        Posture
            An unconverged solve returns its best point with ``success`` false; it does not raise.

        Raises
        ------
        ValueError
            An argument has a wrong shape or is not finite, a pose is not rigid, the tolerance is out of range.

        Notes
        -----
        Balance of the plates: Zhang et al. eq. 7-10 with the lever arms of MECHANICS, "Limb".
        """
        if (
            plate_wrenches is None
            and rod_forces is None
            and rod_moments is None
            and tip_pose is None
            and tip_held is None
            and plate_poses is None
            and plate_held is None
        ):
            # Most calls: numbers that the core can read as they are. It says None where it cannot, or where there is
            # something to explain.
            found = self._plain.solve(
                pressures,
                rest_lengths,
                gravity,
                tip_force,
                tip_moment,
                frame,
                tolerance,
                start._solved if type(start) is Posture else start,
                prefer_stable,
                section,
                valve,
            )
            if found is not None:
                return Posture(self, found, tolerance, (section, valve))
        prefer_stable = truth("prefer_stable", prefer_stable)
        tolerance = _tolerance(tolerance)
        first, first_plates = self._start(start)
        scene = self._scene(
            first,
            first_plates,
            pressures=pressures,
            rest_lengths=rest_lengths,
            gravity=gravity,
            tip_force=tip_force,
            tip_moment=tip_moment,
            plate_wrenches=plate_wrenches,
            frame=frame,
            rod_forces=rod_forces,
            rod_moments=rod_moments,
            tip_pose=tip_pose,
            tip_held=tip_held,
            plate_poses=plate_poses,
            plate_held=plate_held,
            section=section,
            valve=valve,
        )
        if scene.refusal is None:
            solved = self._geometry.solve(
                scene.core,
                tolerance=tolerance,
                prefer_stable=prefer_stable,
                start=first,
                start_plates=first_plates,
            )
        else:
            solved = self._geometry.refused(scene.core, status=scene.refusal[0], message=scene.refusal[1])
        return self._posture(scene, solved, tolerance)

    def follow(
        self,
        arguments: Callable[[float], Mapping[str, Any]],
        start: float,
        stop: float,
        *,
        posture: Posture | None = None,
        tolerance: float = 1e-6,
        largest_step: float = 0.1,
        max_points: int = 500,
        through_events: bool = True,
        **common: Any,
    ) -> Path:
        """Follow a posture while one parameter of its scene changes, through folds.

        Parameters
        ----------
        arguments : callable
            Value of the parameter -> those arguments of `solve` that depend on it, for instance
            ``lambda force: {"tip_force": (0, 0, -force)}``. Smooth; also called a little outside ``start`` .. ``stop``.
        start, stop : float
            Where the parameter starts and where the path ends. A path that meets a fold turns back and may end at
            ``start`` again, on another posture.
        posture : Posture, optional
            Where to start, an equilibrium at ``start``. Default: `solve` there; where that fails the path is empty.
        tolerance : float
            Of every posture, as for `solve`.
        largest_step : float
            Of the arclength: root of the mean square move of plates and nodes (limb lengths, radians) and of the
            parameter (in units of ``stop - start``).
        max_points : int
            Where a path that does not end is cut.
        through_events : bool
            False ends the path at its first fold or bifurcation.
        **common
            The other arguments of `solve`.

        Returns
        -------
        Path
            With ``parameters``, ``postures``, ``folds``, ``bifurcations``, and ``at(parameter)``.

        Raises
        ------
        ValueError
            ``start`` equals ``stop``, or an argument is one that `solve` refuses.
        TypeError
            ``arguments`` is no callable, or does not return a mapping of arguments of `solve`.

        Notes
        -----
        MECHANICS, "Paths".
        """
        if not callable(arguments):
            raise TypeError(f"arguments must be a callable of the parameter, got {type(arguments).__name__}")
        first_value, last_value = one_finite("start", start), one_finite("stop", stop)
        if first_value == last_value:
            raise ValueError(f"start and stop must differ, got {start!r} twice")
        tolerance = _tolerance(tolerance)
        step = one_positive("largest_step", largest_step)
        if not isinstance(max_points, (int, np.integer)) or isinstance(max_points, bool) or max_points < 2:
            raise ValueError(f"max_points must be a whole number of at least 2, got {shown(max_points)}")
        if posture is not None and not isinstance(posture, Posture):
            raise TypeError(f"posture must be a Posture, got {type(posture).__name__}")

        # What a scene depends on: the arguments of `solve` except those of the solver.
        allowed = self._scene.__kwdefaults__ or {}

        def at(value: float) -> dict[str, Any]:
            given = arguments(value)
            if not isinstance(given, Mapping):
                raise TypeError(f"arguments({value:.6g}) must be a mapping of solve's arguments, got {given!r}")
            for name in (*given, *common):
                if name not in allowed:
                    raise TypeError(f"{name!r} cannot be followed: expected one of {', '.join(allowed)}")
            twice = sorted(set(given) & set(common))
            if twice:
                raise TypeError(f"{twice[0]!r} is given both by the parameter and as a constant")
            return {**common, **given}

        first = self.solve(**at(first_value), tolerance=tolerance) if posture is None else posture
        core, _ = self._start(first)
        assert core is not None
        scenes: dict[float, _Scene] = {}

        def scene_at(value: float) -> _Scene:
            if value not in scenes:
                if len(scenes) > 8:
                    scenes.clear()
                scenes[value] = self._scene(core, None, **at(value))
            return scenes[value]

        def core_scene_at(value: float) -> _core.Scene | None:
            scene = scene_at(value)
            return scene.core if scene.refusal is None else None

        if not first.success:
            return Path(_core.FollowedPath(), first_value, last_value, lambda _, __: first, first)
        followed = _core.follow(
            self._geometry,
            core_scene_at,
            core,
            start=first_value,
            stop=last_value,
            tolerance=tolerance,
            largest_step=step,
            max_points=int(max_points),
            through_events=truth("through_events", through_events),
        )
        return Path(
            followed,
            first_value,
            last_value,
            lambda value, solved: self._posture(scene_at(value), solved, tolerance),
            first,
        )

    def sweep(
        self,
        pressures: ArrayLike,
        *,
        threads: int | None = None,
        executor: Executor | Callable[[], Executor] | None = None,
        progress: bool = True,
        ordered: bool = False,
        file: str | os.PathLike[str] | None = None,
        **scene: Any,
    ) -> Batch:
        """Solve one posture for each row of pressures.

        A row depends on itself alone: its bits are the same for any number of threads or workers, any order of the
        rows, and whether or not the sweep was interrupted; of one build and instruction set, which the batch records.
        From 2048 rows on, up to 2048 of them are solved first and the others start from polynomials fitted to these
        (of an ordered sweep, where a group or a new line of a grid begins): a row depends on them as well then, its
        answer to the tolerance only, and where the scene has several stable postures a row may show another one than
        `solve` finds from nothing.

        Parameters
        ----------
        pressures : array_like, shape (N, A) or (N, J, n)
            Gauge pressures [Pa], flat order.
        threads : int, optional
            How many rows are solved at once. Default: all cores that this process may use; with an executor, one a
            worker.
        executor : concurrent.futures.Executor, or a callable that makes one, optional
            Who works in place of this process: a pool of processes, ``client.get_executor()`` of Dask, mpi4py's
            ``MPIPoolExecutor``. A chunk of rows that dies with its worker is tried three times; rows that still fail
            have status "not_run" and the reason. A pool that breaks is followed by a new one where there is a way to
            one (a callable, or a `ProcessPoolExecutor`); otherwise this process solves the rest, and a RuntimeWarning
            says so.
        progress : bool
            Show a progress bar when tqdm is installed.
        ordered : bool
            Let each row start from where the rows before it lead, in groups of 32 rows, the first of which starts by
            itself: from the nearest, and along a line of rows by a parabola. For rows that are neighbours on a path or
            grid: several times faster, and on the path's side of two stable postures.
        file : str or path, optional
            Where the rows go as they are solved: a million take little memory, and a sweep that is killed goes on from
            its file when it is called again. The finished file is the same bit for bit.
        **scene
            Loads and options of `solve`, the same for all rows.

        Returns
        -------
        Batch
            Arrays with one row a posture, failures by row. Ctrl-C keeps the rows done so far, and `Batch.resume` solves
            the others. With ``file``, views of the file.

        Raises
        ------
        ValueError
            Pressures of a wrong shape, not finite or not real numbers; loads that `solve` refuses; ``threads`` below 1;
            a file that is no sweep, or that of another limb, scene, tolerance or other pressures.
        TypeError
            ``executor`` is none, ``file`` is no path, or `solve` has no such option.
        OSError
            The file cannot be written, or another process is filling it.
        RuntimeError
            The executor never returned anything.
        """
        from softlimb.sweep import sweep

        return sweep(
            self,
            pressures,
            threads=threads,
            executor=executor,
            progress=progress,
            ordered=ordered,
            file=file,
            **scene,
        )

    def workspace(
        self,
        *,
        max_pressure: ArrayLike | Sequence[ArrayLike],
        min_pressure: ArrayLike | Sequence[ArrayLike] = 0.0,
        samples: int = 100_000,
        sampling: Literal["halton", "uniform", "grid"] = "halton",
        at_bounds: float = 0.5,
        explore: float = 0.75,
        edge_directions: int = 64,
        seed: int = 0,
        min_clearance: float | None = None,
        threads: int | None = None,
        executor: Executor | Callable[[], Executor] | None = None,
        progress: bool = True,
        file: str | os.PathLike[str] | None = None,
        **scene: Any,
    ) -> Workspace:
        """Where the tip gets to at pressures between bounds, under a load.

        Parameters
        ----------
        max_pressure, min_pressure : float, or array_like as for pressures
            Bounds of the gauge pressures [Pa], for all actuators or one each; where an actuator balloons below the
            upper one, just short of that.
        samples : int
            How many postures are tried.
        sampling : {"halton", "uniform", "grid"}
            Pressures by a scrambled Halton sequence, at random, or all combinations of evenly spaced levels: the most
            whose number is at most ``samples``.
        at_bounds : float
            Share of the pressures that are put to one of their two bounds, each for itself, in [0, 1); not for a grid.
            The edge of a workspace has most pressures at bounds, where evenly spread ones hardly ever are.
        explore : float
            Share of the postures, in [0, 1), whose pressures are drawn near those of postures before them, from all
            voxels alike, so that the cloud fills where evenly spread pressures leave it thin. With ``at_bounds=0,
            explore=0`` `Workspace.regions` has the density of even pressures.
        edge_directions : int
            Besides the six axes: directions in which the cloud's edge is then searched for, starting from its
            postures, and added as further rows. 0 leaves the search out, along the axes too.
        seed : int
            The same seed gives the same postures.
        min_clearance : float, optional
            Rows whose tubes come nearer than this do not count [m]; contact is no part of the model.
        threads, executor, progress, file
            As for `sweep`. The rounds of exploring go to files of the same name with ``.1``, ``.2`` ... behind it; the
            edge rows are in none, `Workspace.save` writes all into one.
        **scene
            Loads and options of `solve`, the same for all postures.

        Returns
        -------
        Workspace
            With ``positions``, ``volume`` by voxels and its error, ``hull_volume``, ``box``, ``reach``, ``tilt_range``,
            ``regions()``, ``slice()``. Rows that failed or are not stable do not count; ``message`` says how many.

        Raises
        ------
        ValueError
            Bounds reversed, not finite or beyond what an actuator carries; no samples; an unknown sampling; a share
            outside its range; a grid of less than two levels; no actuators; loads that `solve` refuses.
        TypeError
            `solve` has no such option.

        Notes
        -----
        MECHANICS, "Workspace".
        """
        from softlimb.workspace import workspace

        return workspace(
            self,
            max_pressure=max_pressure,
            min_pressure=min_pressure,
            samples=samples,
            sampling=sampling,
            at_bounds=at_bounds,
            explore=explore,
            edge_directions=edge_directions,
            seed=seed,
            min_clearance=min_clearance,
            threads=threads,
            executor=executor,
            progress=progress,
            file=file,
            **scene,
        )

    def payload(
        self,
        direction: ArrayLike,
        *,
        max_force: float | None = None,
        max_deflection: float | None = None,
        max_pressure: float | None = None,
        tolerance: float = 1e-6,
        **scene: Any,
    ) -> Payload:
        """The largest force in a direction that the tip carries, and what limits it.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Of the force, base axes; its length does not matter.
        max_force : float, optional
            Where the search ends [N]. Default: the sum of EA of the weakest segment, which would double its length.
        max_deflection : float, optional
            Largest distance of the tip from where it is without the force [m].
        max_pressure : float, optional
            Lets the pressures move between zero and this [Pa], as little as possible, so that the tip stays where it
            is; without it the pressures stay and the tip moves.
        tolerance : float
            As for `solve`.
        **scene
            The arguments of `solve` for everything else; the force is added to ``tip_force``.

        Returns
        -------
        Payload
            ``force``, ``limit`` (fold, bifurcation, deflection, pressure, force or lost) and ``posture``.

        Raises
        ------
        ValueError
            The direction is zero, a limit is not positive, both a largest pressure and a largest deflection are given,
            or an argument is one that `solve` refuses.
        """
        from softlimb.payload import payload

        return payload(
            self,
            direction,
            max_force=max_force,
            max_deflection=max_deflection,
            max_pressure=max_pressure,
            tolerance=tolerance,
            **scene,
        )

    def reach(
        self,
        *,
        position: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        max_pressure: ArrayLike | Sequence[ArrayLike],
        min_pressure: ArrayLike | Sequence[ArrayLike] = 0.0,
        weights: ArrayLike | None = None,
        prefer: ArrayLike | Sequence[ArrayLike] | Posture | Reach | None = None,
        tolerance: float = 1e-6,
        start: Posture | Reach | None = None,
        starts: int = 16,
        method: Literal["search", "paper"] = "search",
        **scene: Any,
    ) -> Reach:
        """Find pressures within bounds that put the tip on a target, in a stable posture.

        Parameters
        ----------
        position : array_like, shape (3,), or pose : array_like, shape (4, 4)
            Where the tip is wanted, in the base frame [m]; exactly one of the two.
        max_pressure, min_pressure : float, or array_like as for pressures
            Bounds of the gauge pressures [Pa], for all actuators or one each.
        weights : array_like, shape (3,) for a position, (6,) for a pose, optional
            How much the tip's errors count: translations along base axes in units of ``limb.length``, then the rotation
            vector from target to tip, base axes [rad]. Zero leaves a freedom alone; the others, at least 1e-3 of the
            largest, matter where the target is out of reach, and only in proportion. Default: one each.
        prefer : array_like of pressures, a Posture or a Reach, optional
            Of all pressures that reach take those nearest to these [Pa], by the sum of squares. Default: zero, the
            least effort.
        tolerance : float
            Of the tip: distance relative to ``limb.length``, angle in radians; 1e-9 to 0.1.
        start : Posture or Reach, optional
            Where to start, a posture of this limb. On a path of targets the answer before, which is fast and stays on
            its side of several answers. Default, and where the start leads nowhere: several starts by constant
            curvature.
        starts : int
            How many starts from nothing there may be, at most 16. Zero: only from ``start``, whose answer a control
            loop has in milliseconds and a target out of reach does not turn into seconds; what is missed that way may
            still be in reach.
        method : {"search", "paper"}
            "paper": Algorithm 1 of Zhang et al., for a pose, with ``section="paper"``: lengths of the rods first, then
            pressures from them. To compare with: seconds, without preference, and from afar it seldom converges; it
            starts where the search ends, or at ``start``. A `PaperReach` with ``lengths``, ``rank``, ``condition``.
        **scene
            Loads, holds, ``section`` and ``valve`` as for `solve`.

        Returns
        -------
        Reach
            With ``pressures``, ``posture``, ``reached``, ``error``, ``active``. A target out of reach is answered by
            the nearest posture found, ``reached`` false. Nearest and least are local: better pressures far away are met
            only by chance.

        Raises
        ------
        ValueError
            Not exactly one target, a target that is not finite or no pose, weights that are negative, all zero or
            farther apart than a factor of 1000,
            bounds that are reversed or beyond what an actuator carries, an argument that `solve` refuses.
        TypeError
            An argument that `solve` does not have, or that does not apply: ``prefer_stable``, ``rest_lengths``.

        Notes
        -----
        MECHANICS, "Reach" and "The paper's Algorithm 1".
        """
        one_of("method", method, ("search", "paper"))
        if method == "paper":
            from softlimb.paper_reach import reach_by_paper

            if pose is None or position is not None or weights is not None or prefer is not None:
                raise ValueError('method="paper" takes a pose, and neither position, weights nor prefer')
            return reach_by_paper(
                self,
                pose=pose,
                max_pressure=max_pressure,
                min_pressure=min_pressure,
                tolerance=tolerance,
                start=start,
                **scene,
            )
        from softlimb.reach import reach

        return reach(
            self,
            position=position,
            pose=pose,
            max_pressure=max_pressure,
            min_pressure=min_pressure,
            weights=weights,
            prefer=prefer,
            tolerance=tolerance,
            start=start,
            starts=starts,
            **scene,
        )

    def sense(
        self,
        pressures: ArrayLike | Sequence[ArrayLike] | None = None,
        *,
        tip_pose: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        points: ArrayLike | None = None,
        at: ArrayLike | None = None,
        points_covariance: ArrayLike | None = None,
        unknown: Literal["wrench", "force"] = "wrench",
        largest_force: float | None = None,
        tolerance: float = 1e-9,
        start: Posture | None = None,
        **scene: Any,
    ) -> Sensed:
        """The wrench on the tip that explains a measured pose of the tip, measured points of the centreline, or both.

        Parameters
        ----------
        pressures : array_like
            As for `solve`.
        tip_pose : array_like, shape (4, 4), optional
            Measured pose of the tip.
        covariance : array_like, shape (6, 6), optional
            Of its position and rotation vector (the turn from the true to the measured orientation), base axes
            [m^2, m rad, rad^2]; with ``tip_pose``.
        points, at : array_like, shape (m, 3) and (m,), optional
            Measured points [m], and their shares of the centreline as `Posture.centreline` takes them.
        points_covariance : array_like, shape (3, 3), (m, 3, 3) or (3m, 3m), optional
            Of every point, of each point, or of all [m^2]; with ``points``.
        unknown : {"wrench", "force"}
            What acts on the tip: force and moment, or a force alone.
        largest_force : float, optional
            How large a force may be expected [N]; a moment: times the limb's length. It decides which directions count
            as seen (see `Sensed.unseen`) and nothing else. Default: what would bend the limb by its own length, were it
            linear.
        tolerance : float
            As for `solve`.
        start : Posture, optional
            Where to start. Default: the stable posture without the wrench.
        **scene
            The arguments of `solve` for everything else; what is sensed adds to ``tip_force`` and ``tip_moment``.

        Returns
        -------
        Sensed
            ``wrench``, its ``covariance``, the ``unseen`` directions, ``posture``, ``chi_square``, ``success``. Every
            posture on the way is stable; a measurement that no wrench explains has a large ``chi_square``.

        Raises
        ------
        ValueError
            Nothing was measured, a covariance is missing, not symmetric or not positive definite, a pose is not rigid,
            a number is not finite, a share is not within 0 and 1, or an argument is one that `solve` refuses.
        TypeError
            A hold or ``prefer_stable`` was given.

        Notes
        -----
        Gauss-Newton on the residual in standard deviations, with the exact derivatives and Levenberg's damping;
        MECHANICS, "Sensed force".
        """
        from softlimb.sense import sense

        return sense(
            self,
            pressures,
            tip_pose=tip_pose,
            covariance=covariance,
            points=points,
            at=at,
            points_covariance=points_covariance,
            unknown=unknown,
            largest_force=largest_force,
            tolerance=tolerance,
            start=start,
            **scene,
        )

    def _scene(
        self,
        first: _core.Posture | None,
        first_plates: Array | None,
        *,
        pressures: ArrayLike | Sequence[ArrayLike] | None = None,
        rest_lengths: ArrayLike | Sequence[ArrayLike] | None = None,
        gravity: ArrayLike = (0.0, 0.0, 0.0),
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        tip_moment: ArrayLike = (0.0, 0.0, 0.0),
        plate_wrenches: ArrayLike | None = None,
        frame: Frame = "base",
        rod_forces: ArrayLike | Sequence[ArrayLike] | None = None,
        rod_moments: ArrayLike | Sequence[ArrayLike] | None = None,
        tip_pose: ArrayLike | None = None,
        tip_held: Sequence[bool] | None = None,
        plate_poses: ArrayLike | None = None,
        plate_held: ArrayLike | None = None,
        section: SectionModel = "tangent",
        valve: Valve = "open",
    ) -> _Scene:
        """The arguments of `solve`, checked, as the core wants them."""
        one_of("frame", frame, ("base", "plate"))
        given, sections, lengths, refusal = self._rods_at(pressures, rest_lengths, section, valve)
        plates, rods = len(self.segments), len(self._members)
        loads: dict[str, Any] = {
            "gravity": finite_of_shape("gravity", gravity, (3,)),
            "tip_force": finite_of_shape("tip_force", tip_force, (3,)),
            "tip_moment": finite_of_shape("tip_moment", tip_moment, (3,)),
            "plate_wrenches": np.zeros((plates, 6))
            if plate_wrenches is None
            else finite_of_shape("plate_wrenches", plate_wrenches, (plates, 6)),
            "frame": frame,
            "rod_forces": self._per_rod("rod_forces", rod_forces),
            "rod_moments": self._per_rod("rod_moments", rod_moments),
        }
        wrenches = loads["plate_wrenches"].copy()
        wrenches[-1] += np.concatenate([loads["tip_force"], loads["tip_moment"]])
        held, poses = self._holds(tip_pose, tip_held, plate_poses, plate_held, first, first_plates)
        core = self._geometry.scene(
            sections=sections,
            rest_lengths=lengths,
            gravity=loads["gravity"],
            wrenches=wrenches,
            following=loads["frame"] == "plate",
            line_forces=loads["rod_forces"].reshape(rods, 3),
            line_moments=loads["rod_moments"].reshape(rods, 3),
            held=held,
            hold_poses=poses,
        )
        return _Scene(core, given, lengths, loads, (section, valve), refusal)

    def _common_scene(
        self,
        *,
        tolerance: float = 1e-6,
        start: Posture | ArrayLike | None = None,
        prefer_stable: bool = True,
        **scene: Any,
    ) -> _CommonScene:
        """The arguments of `solve` for rows of pressures, checked once."""
        allowed = self._scene.__kwdefaults__ or {}
        for name in scene:
            if name not in allowed or name == "pressures":
                raise TypeError(f"{name!r} is no option of rows of pressures: expected one of {', '.join(allowed)}")
        checked = truth("prefer_stable", prefer_stable), _tolerance(tolerance)
        first, first_plates = self._start(start)
        made = self._scene(first, first_plates, pressures=np.zeros(len(self._tubes)), **scene)
        return _CommonScene(made.core, made.model, checked[1], checked[0], first, first_plates)

    def _posture(self, scene: _Scene, solved: _core.Posture, tolerance: float) -> Posture:
        given = {"_solved_pressures": scene.pressures, "rest_lengths": scene.rest_lengths, "loads": scene.loads}
        return Posture(self, solved, tolerance, scene.model, given)

    def _rods_at(
        self,
        pressures: ArrayLike | Sequence[ArrayLike] | None,
        rest_lengths: ArrayLike | Sequence[ArrayLike] | None,
        model: SectionModel,
        valve: Valve,
    ) -> tuple[Array | None, list[Section], Array, tuple[str, str] | None]:
        """Pressures, sections and rest lengths of all rods, and the reason if a tube has no state there."""
        one_of("section", model, SECTION_MODELS)
        one_of("valve", valve, VALVES)
        if pressures is not None and rest_lengths is not None:
            raise ValueError("give either pressures or rest_lengths, got both")
        lengths = np.array([member.length for member in self._members])
        refusal: tuple[str, str] | None = None
        if rest_lengths is not None:
            counts = tuple(len(segment.members) for segment in self.segments)
            lengths = _flat("rest_lengths", rest_lengths, counts, "rods")
            if (lengths <= 0.0).any():
                raise ValueError(f"rest_lengths must be positive, got {lengths.tolist()}")
            if not self._tubes:
                return None, [m.section for m in self._members if isinstance(m, Rod)], lengths, None
            given = np.empty(len(self._tubes))
            driven = [
                (tube, length) for tube, length in zip(self._members, lengths, strict=True) if isinstance(tube, Tube)
            ]
            for number, (tube, length) in enumerate(driven):
                caps = 2.0 * tube.cap_length  # do not stretch
                stretch = (float(length) - caps) / (tube.length - caps)
                given[number] = tube.pressure_for(stretch) if np.isfinite(stretch) and stretch > 0.0 else np.nan
                if np.isnan(given[number]) and abs(stretch - 1.0) <= _ROUNDED_STRETCH:
                    given[number] = 0.0
                if not np.isfinite(given[number]):
                    refusal = ("limit_point", f"actuator {number} cannot reach a rest length of {length:.6g} m")
                    given[number] = 0.0
        elif pressures is not None:
            if not self._tubes:
                raise ValueError("pressures were given, but the limb has no actuators: its rods are given directly")
            given = _flat("pressures", pressures, self._counts, "actuators")
        elif self._tubes:
            raise ValueError(f"the limb has {len(self._tubes)} actuators: give their pressures or rest_lengths")
        else:
            return None, [m.section for m in self._members if isinstance(m, Rod)], lengths, None

        sections, rest, refused = self._core_members.at_pressures(given, model, valve)
        refusal = refused or refusal
        return given, sections, lengths if rest_lengths is not None and refusal is None else rest, refusal

    def _per_rod(self, name: str, value: ArrayLike | Sequence[ArrayLike] | None) -> Array:
        rods = len(self._members)
        if value is None:
            return np.zeros((rods, 3))
        rows = joined(name, value)
        if rows.size != 3 * rods or rows.shape[-1:] not in ((3,), (3 * rods,)):
            raise ValueError(f"{name} must hold 3 numbers for each of {rods} rods, got {rows.size} numbers")
        if not np.isfinite(rows).all():
            raise ValueError(f"{name} must be finite, got {rows.tolist()}")
        return rows.reshape(rods, 3)

    def _start(self, start: Posture | ArrayLike | None) -> tuple[_core.Posture | None, Array | None]:
        if start is None:
            return None, None
        if isinstance(start, RodPosture):
            start = start.posture
        if isinstance(start, Posture):
            if len(start.limb._members) != len(self._members) or len(start.plates) != len(self.segments):
                raise ValueError("start is the posture of another limb: numbers of rods or plates differ")
            return start._solved, None
        return None, _frames("start", start, len(self.segments))

    def _holds(
        self,
        tip_pose: ArrayLike | None,
        tip_held: Sequence[bool] | None,
        plate_poses: ArrayLike | None,
        plate_held: ArrayLike | None,
        start: _core.Posture | None,
        start_plates: Array | None,
    ) -> tuple[NDArray[np.bool_], Array]:
        plates = len(self.segments)
        held = np.zeros((plates, 6), dtype=bool)
        poses = np.tile(np.eye(4), (plates, 1, 1))
        if tip_pose is None and tip_held is None and plate_poses is None and plate_held is None:
            return held, poses
        if (plate_poses is not None or plate_held is not None) and (tip_pose is not None or tip_held is not None):
            raise ValueError("give either tip_pose and tip_held, or plate_poses and plate_held, got both")
        poses = self._unheld_plates(start, start_plates)
        if plate_poses is not None:
            poses = _frames("plate_poses", plate_poses, plates).copy()
            held[:] = True
        if plate_held is not None:
            held = truths("plate_held", plate_held, (plates, 6))
        if tip_pose is not None:
            pose = finite_of_shape("tip_pose", tip_pose, (4, 4))
            _require_pose("tip_pose", pose)
            poses[-1], held[-1] = pose, True
        if tip_held is not None:
            held[-1] = truths("tip_held", tip_held, (6,))  # three translations, three rotations
        return held, poses

    def _unheld_plates(self, start: _core.Posture | None, start_plates: Array | None) -> Array:
        if start is not None:
            return start.plates.copy()
        if start_plates is not None:
            return start_plates.copy()
        # The unpressurised limb: where constant curvature puts it at its own lengths.
        plates, rods = len(self.segments), len(self._members)
        sections = [m.section(0.0) if isinstance(m, Tube) else m.section for m in self._members]
        scene = self._geometry.scene(
            sections=sections,
            rest_lengths=np.array([member.length for member in self._members]),
            gravity=np.zeros(3),
            wrenches=np.zeros((plates, 6)),
            following=False,
            line_forces=np.zeros((rods, 3)),
            line_moments=np.zeros((rods, 3)),
            held=np.zeros((plates, 6), dtype=bool),
            hold_poses=np.tile(np.eye(4), (plates, 1, 1)),
        )
        return self._geometry.start_plates(scene)

    def __eq__(self, other: object) -> bool:
        return self.segments == other.segments if isinstance(other, Limb) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.segments)

    def __reduce__(self) -> tuple[Callable[..., Limb], tuple[Any, ...]]:
        return (Limb, (self.segments,))

    def __iter__(self) -> Iterator[Segment]:
        return iter(self.segments)

    def __len__(self) -> int:
        return len(self.segments)

    def __repr__(self) -> str:
        inside = ", ".join(repr(segment) for segment in self.segments)
        return f"Limb({len(self.segments)} segments, length={self.length:.6g}: {inside})"


def _tuple(name: str, value: Any) -> tuple[Any, ...]:
    try:
        return tuple(value)
    except TypeError:  # among what can be iterated are arrays without axes, which cannot
        raise TypeError(f"{name} must be a sequence, got {type(value).__name__}") from None


def _tolerance(value: float, least: float = 1e-12) -> float:
    tolerance = one_real("tolerance", value)
    if not least <= tolerance <= 0.1:
        raise ValueError(f"tolerance must be within {least:g} and 0.1 of the limb's length, got {tolerance!r}")
    return tolerance


def _flat(name: str, value: Any, counts: tuple[int, ...], what: str) -> Array:
    total = sum(counts)
    equal = len(set(counts)) == 1
    array = joined(name, value)
    shape = array.shape
    nested = not isinstance(value, np.ndarray) and array.size > 0 and array.ndim == 1 and np.ndim(value[0]) == 1
    if nested:
        lengths = tuple(len(part) for part in value)
        fits = lengths == counts
        shape_text = f"{lengths} numbers a segment"
    else:
        fits = shape == (total,) or (equal and shape == (len(counts), counts[0]))
        shape_text = f"shape {shape}"
    if not fits:
        have = f"{len(counts)} segments of {counts[0]} {what}" if equal else f"segments of {counts} {what}"
        expected = f"({len(counts)}, {counts[0]})" if equal and array.ndim == 2 else f"({total},)"
        raise ValueError(f"{name} has {shape_text} but the limb has {have}: expected {expected}")
    flat = array.reshape(total)
    if not np.isfinite(flat).all():
        raise ValueError(f"{name} must be finite, got {flat.tolist()}")
    return flat.copy()
