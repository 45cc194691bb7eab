"""Limbs by name. The reference limb has the paper's materials, fibres, masses and pressures; its geometry is ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from softlimb.units import deg, g, mm

if TYPE_CHECKING:
    from softlimb.limb import Limb

REFERENCE_SEGMENTS = ("proximal", "middle", "distal")
"""Segments of `reference_limb`, from base to tip."""

_KEVLAR_MODULUS = 31.067e9  # [Pa], Zhang et al.
_LENGTH = 200 * mm  # of each unpressurised actuator
# R_i, R_m, R_o, fibre angle from the circumferential direction, volume fraction of each of the two families in the
# skin, ring radius, mass of one actuator with its fittings. Angles and fractions follow from Kevlar thread of 0.18 mm
# at a pitch of 3 mm and count exactly as printed here.
_GEOMETRY = {
    "proximal": (18 * mm, 20.5 * mm, 21.5 * mm, 1.33 * deg, 0.0083, 28 * mm, 98 * g),
    "middle": (13.5 * mm, 15.4 * mm, 16.1 * mm, 1.78 * deg, 0.0119, 21 * mm, 52 * g),
    "distal": (9 * mm, 10.25 * mm, 10.75 * mm, 2.67 * deg, 0.0166, 14 * mm, 23.5 * g),
}


def reference_limb(segments: Sequence[str] = REFERENCE_SEGMENTS) -> Limb:
    """The limb that examples, scenes and tests speak of: three segments of three FRAs, 1.08 kg, 0.65 m.

    Parameters
    ----------
    segments : sequence of str
        Which of "proximal", "middle" and "distal" to take, from base to tip.

    Returns
    -------
    Limb
        Unpressurised actuators 0.2 m long, radius reduction ratio 0.5. Plates 25 mm thick, 0.14 kg each.

    Raises
    ------
    ValueError
        A segment is not known, or there is none.

    Notes
    -----
    Zhang et al. print materials (Dragon Skin 30, SmoothSil 950, Kevlar), pressures and mass but no geometry; radii,
    lengths and ring radii are ours. The paper's connectors are four plates; the base plate does not move and is not
    part of the limb.
    """
    from softlimb import materials
    from softlimb.limb import Limb, Plate, Segment
    from softlimb.tube import Fibres, Layer, Tube

    if isinstance(segments, str) or not segments:
        raise ValueError(f"segments must be a list of names out of {REFERENCE_SEGMENTS}, got {segments!r}")
    built = []
    for name in segments:
        if name not in _GEOMETRY:
            raise ValueError(f"the reference limb has no segment {name!r}; it has {', '.join(REFERENCE_SEGMENTS)}")
        inner, middle, outer, angle, fraction, ring_radius, mass = _GEOMETRY[name]
        # The skin holds the fibres: SmoothSil 950 for the proximal segment, the core's own silicone elsewhere.
        skin = materials.SMOOTHSIL_950 if name == "proximal" else materials.DRAGON_SKIN_30
        fibres = Fibres.pair(angle=angle, modulus=_KEVLAR_MODULUS, fraction=fraction)
        layers = [Layer(inner, middle, materials.DRAGON_SKIN_30), Layer(middle, outer, skin, fibres=fibres)]
        tube = Tube(length=_LENGTH, layers=layers, mass=mass)
        plate = Plate(thickness=25 * mm, mass=140 * g)
        built.append(Segment(actuators=[tube] * 3, ring_radius=ring_radius, plate=plate))
    return Limb(built)


PRESETS: dict[str, Callable[..., Limb]] = {"reference-limb": reference_limb}
"""Name in files, to the function that builds the limb."""
