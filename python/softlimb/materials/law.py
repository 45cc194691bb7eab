"""The material laws as one type. The list is the one of the C++ core; a test holds the two together."""

from __future__ import annotations

from typing import TypeAlias

from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Yeoh

Law: TypeAlias = NeoHookean | Yeoh | MooneyRivlin | Ogden | Gent

LAWS: tuple[type[Law], ...] = (NeoHookean, Yeoh, MooneyRivlin, Ogden, Gent)
