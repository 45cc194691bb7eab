"""A tube with some of its numbers changed, by the names that derivatives use for them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from softlimb import _core
from softlimb.arguments import shown
from softlimb.tube import Fibres, Layer, Tube

__all__ = ["changed_law", "changed_tube", "law_values", "tube_values"]

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


def _families(fibres: Any) -> list[list[int]]:
    """Families that change together: those of one size of angle."""
    sizes = list(dict.fromkeys(abs(family.angle) for family in fibres))
    return [[k for k, family in enumerate(fibres) if abs(family.angle) == size] for size in sizes]


def tube_values(tube: Tube) -> dict[str, float]:
    """Every number of a tube by the label that its column of a derivative has, as ``layers[0].c1``; SI.

    The angle of a group of fibres is its size, that of both families of a pair.
    """
    values = {"length": tube.length, "cap_length": tube.cap_length}
    if tube._given_mass is not None:
        values["mass"] = tube._given_mass
    for k, radius in enumerate([tube.layers[0].inner, *(layer.outer for layer in tube.layers)]):
        values[f"radii[{k}]"] = radius
    for n, layer in enumerate(tube.layers):
        values |= {f"layers[{n}].{name}": value for name, value in law_values(layer.law).items()}
        values[f"layers[{n}].density"] = layer.law.density
        groups = _families(layer.fibres)
        for count, group in enumerate(groups):
            which = f"[{count}]" if len(groups) > 1 else ""
            family = layer.fibres[group[0]]
            by_modulus = family.modulus is not None
            values[f"layers[{n}].fibre_angle{which}"] = abs(family.angle)
            for name in ("modulus", "fraction") if by_modulus else ("stiffness",):
                values[f"layers[{n}].fibre_{name}{which}"] = getattr(family, name)
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
        groups, fibres = _families(layer.fibres), list(layer.fibres)
        for count, group in enumerate(groups):
            which = f"[{count}]" if len(groups) > 1 else ""
            for k in group:
                family = layer.fibres[k]
                given = {"angle": new[f"layers[{n}].fibre_angle{which}"] * (-1.0 if family.angle < 0.0 else 1.0)}
                by_modulus = family.modulus is not None
                for name in ("modulus", "fraction") if by_modulus else ("stiffness",):
                    # Families of one angle may differ in stiffness: they change by the same amount.
                    own_value, first = getattr(family, name), getattr(layer.fibres[group[0]], name)
                    given[name] = own_value + new[f"layers[{n}].fibre_{name}{which}"] - first
                fibres[k] = Fibres(**given)
        layers.append(Layer(inner, outer, law, fibres=fibres) if fibres else Layer(inner, outer, law))
    return Tube(
        length=new["length"],
        layers=layers,
        tension_only=tube.tension_only,
        ends="bonded" if tube.ends == "bonded" else "free",
        mass=new.get("mass"),
        cap_length=new["cap_length"],
    )
