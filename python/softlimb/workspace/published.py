"""The workspace of a limb beside Table II of Zhang et al.: their limb and three others, as printed there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from softlimb.text_tables import aligned, number
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.payload import Payload
    from softlimb.workspace.cloud import Workspace

__all__ = ["PUBLISHED", "PublishedLimb", "beside_published"]


@dataclass(frozen=True)
class PublishedLimb:
    """A row of Table II.

    Parameters
    ----------
    name : str
    workspace : tuple of float, optional
        Extents x, y, z [m]; None where the table has none, as for the others.
    mass, payload : float
        [kg], [N]
    tip_error : float, optional
        Error of the model's tip, as a part of a length.
    """

    name: str
    workspace: tuple[float, float, float] | None
    mass: float
    payload: float
    tip_error: float | None


PUBLISHED = (
    PublishedLimb("Zhang et al.", (0.52, 0.74, 0.66), 1.08, 3.73, 0.0202),
    PublishedLimb("Soft Poly-Limb", (0.55, 0.69, 0.72), 1.6, 3.43, 0.0469),
    PublishedLimb("Fabric SPL", (0.63, 0.69, 0.28), 1.1, 14.72, 0.0390),
    PublishedLimb("flippers", None, 0.46, 113.0, None),
)
"""Table II of Zhang et al., "Design and Control of a Soft Supernumerary Robotic Limb Based on Fiber-Reinforced
Actuator"."""

_NOTES = (
    "Measured: the rows of Zhang et al. and of the three others, as Table II prints them; a tip error there is that "
    "of the authors' model.",
    "Computed: the row of this limb. Nothing was measured on it, so it has no tip error. The reference limb shares "
    "with the paper's limb materials, fibres, masses and pressures; its geometry is ours. Its mass "
    "leaves the base plate out.",
    "Not comparable: pressures, gravity, loads and postures under which the published extents and payloads were "
    "measured are not known here, nor what ended a payload. Extents of this limb are those of its tip over all "
    "pressures within the bounds, along the base frame's axes, which need not be theirs.",
    "Lengths: the paper's 13.45 mm = 2.02 % and 17.96 mm = 2.43 % imply 666 and 739 mm.",
)


def beside_published(workspace: Workspace, payloads: Mapping[str, Payload] | None = None) -> str:
    """A table for print: this limb, computed, beside Table II, measured.

    Parameters
    ----------
    workspace : Workspace
    payloads : mapping of str to Payload, optional
        Payloads of the limb by a name of their direction; the table prints the smallest and the largest.

    Returns
    -------
    str
        Table, what the computed row rests on, reference length, and what cannot be compared.
    """
    limb = workspace.batch.limb
    headings = ["limb", "", "x [m]", "y [m]", "z [m]", "mass [kg]", "payload [N]", "tip error [%]"]
    carried = sorted((payloads or {}).items(), key=lambda item: item[1].force)
    span = "-"
    if carried:
        least, most = carried[0][1].force, carried[-1][1].force
        span = f"{least:.3g}" if len(carried) == 1 else f"{least:.3g} .. {most:.3g}"
    extents = [number(side, 2) for side in workspace.extents]
    rows = [["this limb", "computed", *extents, f"{limb.mass:.2f}", span, "-"]]
    for other in PUBLISHED:
        sides = ["-"] * 3 if other.workspace is None else [number(side, 2) for side in other.workspace]
        error = "-" if other.tip_error is None else number(100.0 * other.tip_error, 2)
        rows.append([other.name, "measured", *sides, f"{other.mass:.2f}", f"{other.payload:.2f}", error])
    low, high = (bound / kPa for bound in workspace.pressure_range)
    about = [
        f"reference length {limb.length / mm:.1f} mm: unpressurised tubes and the plates between them",
        f"this limb: {workspace.message}; pressures {low.min():.4g} to {high.max():.4g} kPa; "
        f"{_loads(workspace)}; tilt of the tip {_tilt(workspace)}",
    ]
    if carried:
        each = ", ".join(f"{name} {found.force:.3g} ({found.limit})" for name, found in (payloads or {}).items())
        at = carried[0][1].unloaded.pressures
        where = "" if at is None else f" at {' '.join(f'{pressure / kPa:.4g}' for pressure in at)} kPa"
        about.append(f"payload of this limb{where} [N], with what ends it: {each}")
    return "\n".join([aligned(headings, rows), "", *about, *_NOTES])


def _loads(workspace: Workspace) -> str:
    gravity = [float(g) for g in workspace.batch.scene.get("gravity", (0.0, 0.0, 0.0))]
    force = [float(f) for f in workspace.batch.scene.get("tip_force", (0.0, 0.0, 0.0))]
    parts = [f"gravity ({', '.join(f'{g:g}' for g in gravity)}) m/s^2"] if any(gravity) else ["no gravity"]
    if any(force):
        parts.append(f"tip force ({', '.join(f'{f:g}' for f in force)}) N")
    return ", ".join(parts)


def _tilt(workspace: Workspace) -> str:
    low, high = workspace.tilt_range
    return f"{number(low / deg, 1)} to {number(high / deg, 1)} deg"
