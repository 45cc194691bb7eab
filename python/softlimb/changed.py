"""A tube with some of its numbers changed, by the names that derivatives use for them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from softlimb import _core
from softlimb.arguments import shown
from softlimb.tube import Fibres, Layer, Tube

__all__ = ["FibreGroup", "changed_law", "changed_tube", "fibre_groups", "law_values", "tube_values"]

_INDEXED = re.compile(r"(\w+)\[(\d+)\]")


def law_values(law: Any) -> dict[str, float]:
    """Coefficients of a law by name, terms of Ogden's as ``mu[0]``; stresses in Pa."""
    found = {}
    for name in _core.law_coefficients(law):
        term = _INDEXED.fullmatch(name)
        found[name] = float(getattr(law, term[1])[int(term[2])] if term else getattr(law, name))
    return found


def changed_law(law: Any, values: Mapping[str, float]) -> Any:
    """The law with some coefficients, or its density, changed; ValueError where that makes no legal law."""
    given: dict[str, Any] = {"density": law.density, "max_strain": law.max_strain}
    for name, value in {**law_values(law), **values}.items():
        if term := _INDEXED.fullmatch(name):
            given.setdefault(term[1], list(getattr(law, term[1])))[int(term[2])] = value
        else:
            given[name] = value
    return type(law)(**given)


class FibreGroup(NamedTuple):
    """One family of fibres of a layer, or two that change together.

    ``twin`` is the family at the opposite angle, -1 where there is none; ``mark`` is what labels of the group end with,
    empty where the layer has no other group.
    """

    family: int
    twin: int
    mark: str


def fibre_groups(fibres: Sequence[Fibres]) -> list[FibreGroup]:
    """Families that change together: two at opposite angles and otherwise alike, the positive one first."""
    waiting, pairs = list(range(len(fibres))), []
    while waiting:
        k = waiting.pop(0)
        alike = [other for other in waiting if _given(fibres[other]) == _given(fibres[k])]
        twin = next((other for other in alike if fibres[other].angle == -fibres[k].angle), -1)
        if twin >= 0:
            waiting.remove(twin)
        pairs.append((twin, k) if twin >= 0 and fibres[k].angle < 0.0 else (k, twin))
    return [FibreGroup(*pair, f"[{count}]" if len(pairs) > 1 else "") for count, pair in enumerate(pairs)]


def _given(family: Fibres) -> dict[str, float]:
    """What a family was given by besides its angle: its stiffness, or modulus and fraction."""
    if family.modulus is None or family.fraction is None:
        return {"stiffness": family.stiffness}
    return {"modulus": family.modulus, "fraction": family.fraction}


def tube_values(tube: Tube) -> dict[str, float]:
    """Every number of a tube by the label that its column of a derivative has, as ``layers[0].c1``; SI.

    The angle of fibres is its size, that of both families of a pair.
    """
    values = {"length": tube.length, "cap_length": tube.cap_length}
    if tube._given_mass is not None:
        values["mass"] = tube._given_mass
    for k, radius in enumerate([tube.layers[0].inner, *(layer.outer for layer in tube.layers)]):
        values[f"radii[{k}]"] = radius
    for n, layer in enumerate(tube.layers):
        values |= {f"layers[{n}].{name}": value for name, value in law_values(layer.law).items()}
        values[f"layers[{n}].density"] = layer.law.density
        for group in fibre_groups(layer.fibres):
            family = layer.fibres[group.family]
            for name, value in {"angle": abs(family.angle), **_given(family)}.items():
                values[f"layers[{n}].fibre_{name}{group.mark}"] = value
    return values


def changed_tube(tube: Tube, values: Mapping[str, float]) -> Tube:
    """The tube with other values of some of its numbers, named as `tube_values` does.

    Raises
    ------
    ValueError
        A name is not one of the tube's, or the values make no tube.
    """
    own = tube_values(tube)
    for name in values:
        if name not in own:
            raise ValueError(f"a tube has no number {shown(name)}; this one has {', '.join(own)}")
    new = {**own, **values}
    radii = [new[f"radii[{k}]"] for k in range(len(tube.layers) + 1)]
    layers = []
    for n, (layer, (inner, outer)) in enumerate(zip(tube.layers, pairwise(radii), strict=True)):
        names = [*law_values(layer.law), "density"]
        law = changed_law(layer.law, {name: new[f"layers[{n}].{name}"] for name in names})
        fibres = list(layer.fibres)
        for group in fibre_groups(layer.fibres):
            family = layer.fibres[group.family]
            angle = new[f"layers[{n}].fibre_angle{group.mark}"] * (-1.0 if family.angle < 0.0 else 1.0)
            given = {name: new[f"layers[{n}].fibre_{name}{group.mark}"] for name in _given(family)}
            fibres[group.family] = Fibres(angle=angle, **given)
            if group.twin >= 0:
                fibres[group.twin] = Fibres(angle=-angle, **given)
        layers.append(Layer(inner, outer, law, fibres=fibres) if fibres else Layer(inner, outer, law))
    return Tube(
        length=new["length"],
        layers=layers,
        tension_only=tube.tension_only,
        ends="bonded" if tube.ends == "bonded" else "free",
        mass=new.get("mass"),
        cap_length=new["cap_length"],
    )
