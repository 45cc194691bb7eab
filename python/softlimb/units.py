"""Factors to multiply with: ``20 * kPa`` is 20 000 Pa, ``28 * mm`` is 0.028 m, ``1.33 * deg`` is in radians."""

from math import pi

Pa = 1.0
kPa = 1e3
MPa = 1e6
GPa = 1e9
bar = 1e5
psi = 6894.757293168361  # lbf/in^2, exact from the definitions of pound, inch and standard gravity

m = 1.0
mm = 1e-3
cm = 1e-2
inch = 0.0254

N = 1.0
kN = 1e3
mN = 1e-3

kg = 1.0
g = 1e-3

rad = 1.0
deg = pi / 180.0

s = 1.0
ms = 1e-3
us = 1e-6
