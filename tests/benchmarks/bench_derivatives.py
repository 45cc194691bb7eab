"""Are the derivatives right, and what does a gradient cost? Against Richardson's central differences, on random scenes.

Scenes, seeded. Of three, two are limbs of tubes: the reference limb with its radii, lengths, rings, plates, angles and
laws changed by up to 15 %, pressures of 5 to 60 kPa, any gravity direction, up to 0.5 N at the tip, some with a dead
moment at the tip, following loads, a held tip, the nonlinear section, tension-only or bonded tubes. The third is a limb
of rods with any sections. Away from folds: stable, and no softer at the tip than `SOFTEST` times the same limb without
loads. Solved to 1e-12 of the limb's length.

Columns: of each scene some, drawn from all that can be differentiated to. Differences with eight steps, 4 % of the
number (of a load: of its usual size; of a coefficient: of the shear modulus) and halves of it, 16 solves a column, of
which Richardson's table keeps the entry that agrees best with its neighbours. Error: norm of a column's error over the
norm of the column, separately for all plates (translations over the limb's length), eleven points of the centreline and
the energy. The energy's column is no less than 1e-3 of the energy over the number, where it is a small difference of
large terms; a column that moves nothing by 1e-10 of the length for the whole number (a moment about an axis that is
held) is zero.

Cost: gradients of the tip's height to 30 parameters on the reference limb in the paper's complex posture, linearisation
included, beside solves of it: from the posture at pressures 1 % lower, and cold. Alternately, medians and spread.

Run: python tests/benchmarks/bench_derivatives.py [--scenes 500] [--columns 4] [--first 0] [--only cost]
"""

import argparse
import platform
import sys
import time
from pathlib import Path

import numpy as np

import softlimb as sl
from softlimb import presets
from softlimb.units import kPa

sys.path.insert(0, str(Path(__file__).parents[1]))
import perturbed

POINTS = 11
SOFTEST = 10.0
SHARE = 0.04
FIBRES = ("fibre_angle", "fibre_fraction", "fibre_modulus")
TUBES = ("pressures", "length", "radii", "law", "density", "cap_length", *FIBRES)
RODS = ("length", "section", "rod_forces")
ANY = ("gravity", "tip_force", "tip_moment", "plate_wrenches", "ring_radius", "plate_mass", "plate_thickness")
SIZES = {"gravity": 9.81, "tip_force": 0.5, "tip_moment": 0.02, "plate_wrenches": 0.1, "rod_forces": 0.5}


def direction(generator):
    vector = generator.normal(size=3)
    return vector / np.linalg.norm(vector)


def tube_like(tube, generator):
    """A tube of other radii, angle and materials, within 15 %."""

    def near(value, part=0.15):
        return float(value * generator.uniform(1.0 - part, 1.0 + part))

    scale = near(1.0)
    radii = np.array([tube.layers[0].inner, *(layer.outer for layer in tube.layers)]) * scale
    radii[1:-1] += 0.2 * generator.uniform(-1.0, 1.0) * np.diff(radii).min()
    laws = [
        sl.Yeoh(c1=near(86.1e3), c2=near(13.6e3), c3=float(generator.uniform(0.0, 500.0))),
        generator.choice(
            [
                sl.NeoHookean(c1=near(340e3)),
                sl.Gent(mu=near(6e5), jm=near(20.0)),
                sl.Ogden(mu=[near(3e5), -near(5e4)], alpha=[near(2.2), -near(1.5)]),
                sl.MooneyRivlin(c10=near(2e5), c01=near(1e5)),
            ]
        ),
    ]
    family = tube.layers[1].fibres[0]
    fibres = sl.Fibres.pair(angle=near(2.0 * abs(family.angle)), modulus=31.067e9, fraction=near(family.fraction))
    return sl.Tube(
        near(tube.length),
        [sl.Layer(radii[0], radii[1], laws[0]), sl.Layer(radii[1], radii[2], laws[1], fibres=fibres)],
        tension_only=bool(generator.random() < 0.1),
        ends="bonded" if generator.random() < 0.2 else "free",
        cap_length=float(generator.uniform(0.0, 0.01)),
    )


def of_tubes(generator):
    segments = []
    for old in presets.reference_limb().segments[: generator.integers(1, 4)]:
        plate = sl.Plate(thickness=generator.uniform(0.01, 0.03), mass=generator.uniform(0.05, 0.2))
        ring = old.ring_radius * generator.uniform(0.9, 1.3)
        segments.append(sl.Segment([tube_like(old.actuators[0], generator)] * 3, ring_radius=ring, plate=plate))
    limb = sl.Limb(segments)
    options = {
        "pressures": generator.uniform(5.0 * kPa, 60.0 * kPa, 3 * len(limb)),
        "gravity": 9.81 * direction(generator),
        "tip_force": generator.uniform(0.0, 0.5) * direction(generator),
    }
    if generator.random() < 0.2:
        options["section"] = "nonlinear"
    return limb, options


def of_rods(generator):
    segments = []
    for _ in range(generator.integers(1, 4)):
        bending = 10.0 ** generator.uniform(-2.5, -1.5)
        section = sl.Section(
            axial=(stiff := 1e3 * 10.0 ** generator.uniform(-1.0, 1.5)),
            shear=stiff * generator.uniform(0.2, 1.0),
            bending=bending,
            torsion=bending * generator.uniform(0.4, 1.0),
            mass_per_length=generator.uniform(0.1, 0.4),
            rest_twist=generator.normal(),
            extension_twist=generator.uniform(-0.3, 0.3) / np.sqrt(stiff * bending),
        )
        rods = [sl.Rod(section, 0.2 * (1.0 + generator.uniform(-0.1, 0.1))) for _ in range(generator.integers(2, 5))]
        plate = sl.Plate(thickness=generator.uniform(0.0, 0.03), mass=generator.uniform(0.0, 0.1))
        segments.append(sl.Segment(rods=rods, ring_radius=generator.uniform(0.015, 0.04), plate=plate))
    limb = sl.Limb(segments)
    options = {
        "gravity": 9.81 * direction(generator),
        "tip_force": generator.uniform(0.0, 0.5) * direction(generator),
        "rod_forces": 0.3 * generator.normal(size=(len(limb._members), 3)),
    }
    return limb, options


def scene(number):
    """Limb, arguments of its solve, and the generator for what is drawn next."""
    generator = np.random.default_rng([20261122, 6, number])
    limb, options = of_rods(generator) if number % 3 == 2 else of_tubes(generator)
    kind = generator.integers(0, 8)
    if kind == 0:
        options["tip_moment"] = 0.02 * generator.uniform() * direction(generator)
    elif kind == 1:
        options["frame"] = "plate"
    elif kind == 2:
        # Where the free limb's tip is, and a little beside.
        pose = limb.solve(**options).tip.copy()
        pose[:3, 3] += 0.02 * limb.length * direction(generator)
        options |= {"tip_pose": pose, "tip_held": (generator.random(6) < 0.5).tolist()}
    return limb, {**options, "tolerance": 1e-12}, generator


def described(number):
    limb, options, _ = scene(number)
    tubes = [segment.actuators[0] for segment in limb if segment.actuators]
    words = [f"{len(limb)} segments of {'tubes' if tubes else 'rods'}"]
    words += ["tension-only"] * any(tube.tension_only for tube in tubes)
    words += [name for name in ("section", "frame", "tip_moment", "tip_held") if name in options]
    return ", ".join(words)


def step_of(label, value):
    """The largest step: a share of a number; of a load, of its usual size."""
    name = label.split(".")[0].split("[")[0]
    if name in SIZES:
        return SHARE * SIZES[name]
    return SHARE * abs(value)


def value_of(posture, label):
    """The size of the number that a column is the derivative to; zero where it is no number of the limb's own."""
    if label.startswith("pressures"):
        return posture.pressures[int(label[10:-1])]
    _, _, what = label.partition(".")
    segment = posture.limb.segments[int(label[9])] if label.startswith("segments") else None
    if segment is None:
        return 0.0
    member = segment.members[0]
    if what in ("ring_radius",):
        return segment.ring_radius
    if what.startswith("plate_"):
        return getattr(segment.plate, what.removeprefix("plate_")) or 0.01
    if what.startswith("section."):
        own = getattr(member.section, what.removeprefix("section."))
        natural = {"rest_twist": 1.0, "extension_twist": 1.0 / np.sqrt(member.section.axial * member.section.bending)}
        # Shear and extension of a slender rod move the tip by little: larger steps lift them above the rounding.
        return 5.0 * max(abs(own), natural.get(what.removeprefix("section."), 0.0))
    if what.startswith("radii"):
        return member.layers[0].outer - member.layers[0].inner
    if what.startswith("layers"):
        layer = member.layers[int(what[7])]
        field = what[10:]
        if field.startswith("fibre_"):
            values = [getattr(family, field.removeprefix("fibre_").split("[")[0]) for family in layer.fibres]
            return next(abs(value) for value in values if value)
        if field.startswith("alpha"):
            return layer.law.alpha[int(field[-2])]
        if field == "density":
            return layer.law.density
        return layer.law.jm if field == "jm" else layer.law.shear_modulus
    return getattr(member, what) or 0.005


def away_from_folds(posture, options):
    bare = {k: v for k, v in options.items() if k in ("pressures", "section", "tip_held", "tolerance")}
    free = posture.limb.solve(**bare)
    scale = np.array([posture.limb.length] * 3 + [1.0] * 3)

    def softness(p):
        return np.abs(scale[:, None] * p.compliance * scale).max()

    return free.success and softness(posture) <= SOFTEST * max(softness(free), 1e-300)


def measure(number, count):
    """Errors of some columns, as (label, plates, centreline, energy); None where the scene is not one to judge."""
    limb, options, generator = scene(number)
    posture = limb.solve(**options)
    if not (posture.success and posture.stable) or not away_from_folds(posture, options):
        return None
    names = [*(TUBES if limb._tubes else RODS), *ANY]
    energy = posture.conservative
    found = posture.derivative(("plates", "centreline"), names, n=POINTS)
    plates = 6 * len(limb)
    scale = np.array(([limb.length] * 3 + [1.0] * 3) * len(limb) + [limb.length] * (3 * POINTS) + [1.0])
    outcomes = []
    for k in generator.choice(len(found.columns), size=min(count, len(found.columns)), replace=False):
        label = found.columns[k]
        value = value_of(posture, label)
        step = step_of(label, value)
        # A wrench that has no potential has no energy, and a moment would give it one that has none.
        of_energy = energy and not label.startswith(("tip_moment", "plate_wrenches"))
        of_energy = of_energy and not (options.get("frame") == "plate" and "force" in label)
        exact = np.append(found.matrix[:, k], 0.0)
        if of_energy:
            name = found.column_names[k]
            exact[-1] = posture.derivative("energy", name)[label][0]
        expected = perturbed.slope(posture, options, label, step, POINTS, of_energy)
        error, size = (exact - expected) / scale, exact / scale
        whole = step / SHARE
        least = 1e-3 * abs(posture.energy) / whole if of_energy else 1.0
        nothing = max(np.linalg.norm(size[:-1]), np.linalg.norm((expected / scale)[:plates])) * whole < 1e-10
        outcomes.append(
            (
                label,
                *(
                    float(np.linalg.norm(error[part]) / max(np.linalg.norm(size[part]), floor))
                    for part, floor in (
                        (slice(0, plates), np.inf if nothing else 1e-300),
                        (slice(plates, -1), np.inf if nothing else 1e-300),
                        (slice(-1, None), max(least, 1e-300)),
                    )
                ),
            )
        )
    return outcomes


def accuracy(arguments):
    worst, judged, left_out = [], 0, 0
    for number in range(arguments.first, arguments.first + arguments.scenes):
        outcomes = measure(number, arguments.columns)
        if outcomes is None:
            left_out += 1
            continue
        judged += 1
        worst += [(np.nanmax(o[1:]), number, *o) for o in outcomes]
    errors = np.array([o[3:] for o in worst])
    print(f"scenes judged: {judged}, near a fold, unstable or not found: {left_out}; columns: {len(worst)}")
    for name, column in zip(("plates", "centreline", "energy"), errors.T, strict=True):
        middle, high, top = np.nanpercentile(column, [50, 99, 100])
        print(f"  error of {name:<10} over the column's norm: median {middle:.1e}, 99 % {high:.1e}, largest {top:.1e}")
    for _, number, label, *parts in sorted(worst, reverse=True)[:8]:
        parts_text = " ".join(f"{part:.0e}" for part in parts)
        print(f"  scene {number} ({described(number)}), {label}: {parts_text}")
    print(f"  centrelines left out because a point passed a joint: {np.isnan(errors).sum()}")
    return float(np.nanmax(errors))


def cost(rounds=300):
    limb = presets.reference_limb()
    pressures = np.array([90, 60, 30, 60, 40, 20, 50, 50, 50]) * kPa
    loads = {"gravity": (0.0, 0.0, 9.81)}
    start = limb.solve(0.99 * pressures, **loads)
    posture = limb.solve(pressures, **loads, start=start)
    to = ("pressures", "radii", "fibre_angle", "fibre_fraction", "ring_radius", "plate_mass")
    height = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])

    def gradient():
        posture.__dict__.pop("_linear", None)
        return posture.gradient(to, tip=height)

    def second():
        return posture.gradient(to, tip=height)

    jobs = {
        "gradient to 30 parameters": gradient,
        "another of the same posture": second,
        "warm solve": lambda: limb.solve(pressures, **loads, start=start),
        "cold solve": lambda: limb.solve(pressures, **loads),
    }
    assert len(gradient().values) == 30
    times = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, job in jobs.items():
            began = time.perf_counter()
            job()
            times[name].append(1e6 * (time.perf_counter() - began))
    for name, spent in times.items():
        low, middle, high = np.percentile(spent, [5, 50, 95])
        print(f"  {name:<28} {middle:8.0f} us (5 % {low:.0f}, 95 % {high:.0f})")
    median = {name: np.median(spent) for name, spent in times.items()}
    best = {name: min(spent) for name, spent in times.items()}
    for solve in ("warm solve", "cold solve"):
        ratio = median["gradient to 30 parameters"] / median[solve]
        least = best["gradient to 30 parameters"] / best[solve]
        print(f"  a gradient costs {ratio:.2f} {solve}s (of the shortest times {least:.2f})")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--columns", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", choices=("cost", "accuracy"))
    arguments = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, one core")
    if arguments.only != "accuracy":
        cost()
    if arguments.only != "cost":
        return 1 if accuracy(arguments) > 1e-7 else 0
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
