"""What breaks each method: single shooting, the paper's algorithm, constant curvature, and softlimb, scene by scene.

Scenes: `methods/scenes.py`. Methods: `softlimb.bench.methods`, each a plain implementation of its own on the same
equations; sections, rest lengths and loads are those of the package's posture. The paper's algorithm is given the true
pose of the tip and has to find the rods' lengths.

Truth: the package's posture at tolerance 1e-10 (or the finest that it reaches, then shown), checked by an independent
re-integration (`posture.verify`); scenes marked * are compared with a closed form too. Columns:
  outcome    "right": converged to the truth; "right, coarse": nearly, off by more than 1e-4. "other equilibrium (k)":
             converged to a true equilibrium with k unstable modes (counted by methods/modes.py); "other lengths (k)":
             the same for the paper's algorithm; "no equilibrium": converged, but finer RK4 steps find none there
             "(0)" is a stable posture too, of a scene that has several
  error      of the plates' poses: the larger of distance over the limb's length and angle [rad]; for the paper's
             algorithm of the rods' lengths as well, over the limb's length. Ours: at tolerance 1e-6
  condition  of the Jacobian (ours: condensed stiffness) at the truth, with lengths in limb lengths and wrenches in
             EI/l^2 and EI/l, or its rank where that is not full; "scaled": after rows and columns were scaled to one
  time       median; the compared methods run in numpy, so the ratio also holds the language. Iterations do not.

Run: python tests/benchmarks/bench_methods.py [--scenes NAME ...] [--limit SECONDS]; NAME is any part of a name.
"""

import argparse
import platform
import statistics
import time
from dataclasses import replace

import numpy as np
from methods import modes
from methods.scenes import scenes

from softlimb.bench.methods import constant_curvature, single_shooting
from softlimb.bench.methods.judging import equilibrated, pose_error
from softlimb.paper import algorithm
from softlimb.paper.problem import Problem, condition

_SAME = 1e-2  # plates closer than this are of one equilibrium; RK4 of 40 steps errs by less on all but wild scenes
_RIGHT = 1e-4  # error of an answer that a user would call right


def timed(call, least=3, span=0.3):
    """Result and median time [ms] of some calls within a span of time."""
    times, began = [], time.perf_counter()
    while len(times) < least or time.perf_counter() - began < span:
        started = time.perf_counter()
        result = call()
        times.append(1e3 * (time.perf_counter() - started))
        if time.perf_counter() - began > 1.0 or len(times) > 200:
            break
    return result, statistics.median(times)


def from_axis(plate):
    """A pose turned about z so that the tip lies in the half plane x > 0."""
    azimuth = np.arctan2(plate[1, 3], plate[0, 3]) if np.hypot(plate[0, 3], plate[1, 3]) > 0.0 else 0.0
    cosine, sine = np.cos(azimuth), np.sin(azimuth)
    back = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    turned = plate.copy()
    turned[:3, 3] = back @ plate[:3, 3]
    turned[:3, :3] = back @ plate[:3, :3] @ back.T  # both ends of a round rod are free to choose their x axis
    return turned


def error_of(scene, plates, true_plates, length):
    """Largest error of the plates, up to a turn about z where every such turn is an equal answer."""
    pairs = zip(plates, true_plates, strict=True)
    if scene.round:
        return max(pose_error(from_axis(a), from_axis(b), length) for a, b in pairs)
    return max(pose_error(a, b, length) for a, b in pairs)


def equilibrium_at(scene, truth, problem, answer):
    """What is where a method ended: "(k)" unstable modes, or None where RK4 of finer steps finds no equilibrium."""
    fine = single_shooting.refine(problem, answer)
    if not fine.converged or error_of(scene, answer.plates, fine.plates, problem.scale) > _SAME:
        return None
    return f"({modes.unstable_modes(problem, fine.plates, fine.wrenches)})" if truth.conservative else "(?)"


def judge(scene, truth, problem, answer, error, other):
    if not answer.converged:
        return answer.outcome
    if error <= _RIGHT:
        return "right"
    if answer.lengths.min() < 1e-3 * problem.scale:
        return "a rod without length"
    near = equilibrium_at(scene, truth, replace(problem, lengths=answer.lengths), answer)
    if near is None:
        return "no equilibrium"
    return "right, coarse" if error <= _SAME else f"{other} {near}"


def row(method, outcome, error, cond, iterations, milliseconds, ours):
    shown = "" if error is None else f"{error:.1e}"
    best, scaled = cond
    ratio = f"{milliseconds / ours:.3g}"
    print(
        f"  {method:<20}{outcome:<27}{shown:>9}{best:>13}{scaled:>13}{iterations:>7}{milliseconds:>11.3g}{ratio:>10}",
        flush=True,
    )


def conditions(matrix):
    """Condition number or rank, as it is and after scaling."""
    texts = []
    for version in (matrix, equilibrated(matrix) if np.isfinite(matrix).all() else matrix):
        value, rank = condition(version)
        columns = matrix.shape[1]
        texts.append("overflow" if rank == 0 else f"rank {rank}/{columns}" if rank < columns else f"{value:.1e}")
    return texts


def finest(limb, options):
    """The posture at the finest tolerance at which the package finds a stable one, or else one at all."""
    found = None
    for tolerance in (1e-10, 1e-9, 1e-8, 1e-7, 1e-6):
        posture = limb.solve(**options, tolerance=tolerance)
        if posture.success and (posture.stable or not posture.conservative):
            return posture
        if posture.success and found is None:
            found = posture
    return posture if found is None else found


def run(scene, limit):
    limb = scene.limb()
    truth = finest(limb, scene.options)
    check = truth.verify()
    posture, ours = timed(lambda: limb.solve(**scene.options))
    note = f"verified to {check.largest_error:.0e}" if truth.success and check.success else "TRUTH NOT VERIFIED"
    if truth.tolerance > 1e-10:
        note += f" (no stable answer finer than {truth.tolerance:.0e})"
    if scene.exact is not None:
        tip = from_axis(truth.tip) if scene.round else truth.tip
        note += f", closed form to {np.linalg.norm(tip[:3, 3] - scene.exact) / limb.length:.0e} *"
    axes = np.vstack([[0.0, 0.0, 1.0], truth.plates[:, :3, 2]])
    turn = np.degrees(np.arccos(np.clip((axes[1:] * axes[:-1]).sum(axis=1), -1.0, 1.0))).sum()
    print(f"{scene.name}: {note}; turns by {turn:.0f} deg from plate to plate; {truth.message}")
    problem = Problem.of(truth)
    true_wrenches = np.array([rod.base_wrench for row in truth.rods for rod in row])

    error = error_of(scene, posture.plates, truth.plates, limb.length)
    outcome = "right" if error <= 1e-5 else f"other equilibrium ({posture.unstable_modes})"
    if not posture.success:
        outcome = posture.status
    elif not posture.verify().success:
        outcome = "wrong"
    elif not posture.stable:
        outcome += ", unstable"
    move = np.tile([limb.length] * 3 + [1.0] * 3, len(limb))
    cond = conditions(move[:, None] * truth.plate_stiffness * move)
    row("softlimb", outcome, error, cond, posture.iterations + posture.descent_iterations, ours, ours)

    answer, milliseconds = timed(lambda: single_shooting.solve(problem, limit))
    error = error_of(scene, answer.plates, truth.plates, limb.length) if answer.converged else None
    outcome = judge(scene, truth, problem, answer, error, "other equilibrium")
    with np.errstate(all="ignore"):
        cond = conditions(single_shooting.scaled_jacobian(problem, truth.plates, true_wrenches))
    row("single shooting", outcome, error, cond, answer.iterations, milliseconds, ours)

    # What is known before the lengths are: how long a segment is without pressure.
    rests = np.concatenate([[segment.length] * len(segment.members) for segment in limb])
    answer, milliseconds = timed(lambda: algorithm.solve(problem, truth.tip, rests, limit))
    error = None
    if answer.converged:
        lengths = np.abs(answer.lengths - problem.lengths).max() / limb.length
        error = max(error_of(scene, answer.plates, truth.plates, limb.length), lengths)
    outcome = judge(scene, truth, problem, answer, error, "other lengths")
    with np.errstate(all="ignore"):
        true = np.concatenate([problem.lengths, true_wrenches.ravel()])
        cond = conditions(algorithm.scaled_jacobian(problem, truth.tip, true))
    row("paper's algorithm", outcome, error, cond, answer.iterations, milliseconds, ours)

    answer, milliseconds = timed(lambda: constant_curvature.solve(problem))
    error = error_of(scene, answer.plates, truth.plates, limb.length) if answer.converged else None
    outcome = answer.outcome if not answer.converged else "right" if error <= _RIGHT else "off"
    row("constant curvature", outcome, error, ("-", "-"), "-", milliseconds, ours)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="*", default=None, help="parts of names; default: all")
    parser.add_argument("--limit", type=float, default=10.0, help="seconds for each compared method and scene")
    arguments = parser.parse_args()
    chosen = [s for s in scenes() if arguments.scenes is None or any(part in s.name for part in arguments.scenes)]
    if not chosen:
        parser.error(f"no scene has one of {arguments.scenes} in its name; there are {[s.name for s in scenes()]}")
    print(f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}, one core")
    print(f"  {'method':<20}{'outcome':<27}{'error':>9}{'condition':>13}{'scaled':>13}", end="")
    print(f"{'iter.':>7}{'time [ms]':>11}{'x ours':>10}")
    for scene in chosen:
        run(scene, arguments.limit)


if __name__ == "__main__":
    main()
