"""The pressure controllers: a freestanding header, the paper's two equations, and what was added to them."""

from __future__ import annotations

import pickle
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softlimb.control import PID, NeuralPID

INCLUDE = Path(__file__).parents[1] / "cpp" / "include"

PROGRAM = """
#include "softlimb/control/guard.hpp"
#include "softlimb/control/neural_pid.hpp"
using namespace softlimb::control;
extern "C" int printf(const char*, ...);
template <class Real> void run() {
    Common<Real> common;
    common.scale = Real(100);
    NeuralOptions<Real> options;
    for (int i = 0; i < 3; ++i) options.rates[i] = Real(0.01);
    const Real weights[3] = {Real(1.5), Real(2), Real(0.25)};
    NeuralPid<Real> neural(common, weights, options);
    Pid<Real> pid(common, weights);
    Guard<Real> guard{GuardOptions<Real>()};
    Real y = 0;
    for (int k = 0; k < 400; ++k) {
        const Real u = neural.step(Real(40), y);
        if (guard.step(Real(40), y, u, Real(1)) != Fault::none) printf("fault");
        y += Real(0.5) * u + Real(0.01) * pid.step(Real(40), y);
    }
    printf("%.17g %.17g %.17g %.17g\\n", (double)y, (double)neural.weights()[0], (double)neural.weights()[1],
           (double)neural.weights()[2]);
}
int main() { run<float>(); run<double>(); return 0; }
"""
FLAGS = ["-nostdinc++", "-fno-exceptions", "-fno-rtti", "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


def compiler() -> str:
    found = shutil.which("g++") or shutil.which("clang++")
    if found is None:
        pytest.skip("neither g++ nor clang++ is there")
    return found


def plant_of_the_program(neural: NeuralPID, pid: PID) -> list[float]:
    y = 0.0
    for _ in range(400):
        u = neural.step(40.0, y)
        y += 0.5 * u + 0.01 * pid.step(40.0, y)
    return [y, *neural.weights]


def test_the_header_compiles_without_a_standard_library_and_gives_what_python_gives(tmp_path: Path) -> None:
    source, program = tmp_path / "controller.cpp", tmp_path / "controller"
    source.write_text(PROGRAM, encoding="utf-8")
    command = [compiler(), *FLAGS, "-I", str(INCLUDE), str(source), "-o", str(program)]
    subprocess.run([*command, "-Wdouble-promotion"], check=True)  # a float must not become a double on its way
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.splitlines()
    in_float, in_double = ([float(x) for x in line.split()] for line in said)
    common = {"scale": 100.0, "weights": (1.5, 2.0, 0.25)}
    expected = plant_of_the_program(NeuralPID(**common, rates=0.01), PID(**common))
    # 400 steps that each round to 1e-16, once more where a compiler contracts a product and a sum; the loop is stable
    assert_allclose(in_double, expected, rtol=400 * 2e-16)
    # 400 steps that each round to 6e-8
    assert_allclose(in_float, expected, rtol=400 * 6e-8)


def test_the_header_needs_no_symbol_of_any_library(tmp_path: Path) -> None:
    if shutil.which("nm") is None:
        pytest.skip("nm is not there")
    source, made = tmp_path / "one.cpp", tmp_path / "one.o"
    classes = [f"{name}<{real}>" for name in ("Pid", "NeuralPid", "Guard") for real in ("float", "double")]
    lines = [f"template class softlimb::control::{name};" for name in classes]
    includes = ['#include "softlimb/control/guard.hpp"', '#include "softlimb/control/neural_pid.hpp"']
    source.write_text("\n".join([*includes, *lines, ""]), encoding="utf-8")
    command = [
        compiler(),
        *FLAGS,
        "-O2",
        "-fno-stack-protector",
        "-I",
        str(INCLUDE),
        "-c",
        str(source),
        "-o",
        str(made),
    ]
    subprocess.run(command, check=True)
    undefined = subprocess.run(["nm", "-u", str(made)], capture_output=True, text=True, check=True).stdout
    # without optimisation of that away, a copy of a struct may be a call of memcpy
    assert set(undefined.split()) - {"U", "memcpy", "_memcpy"} == set()


def sequences(seed: int, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, n), rng.uniform(-1.0, 1.0, n)


WIDE = {"scale": 1.0, "limits": (-1e9, 1e9), "anti_windup": "none", "period": 0.25}


def test_the_pid_is_the_sum_that_the_paper_prints() -> None:
    targets, readings = sequences(1)
    weights = (1.3, 0.7, -0.4)
    pid = PID(weights, sign="printed", **WIDE)
    e = readings - targets
    x = np.stack([e, 0.25 * np.cumsum(e), np.diff(e, prepend=e[0])])
    found = [pid.step(a, b) for a, b in zip(targets, readings, strict=True)]
    assert_allclose(found, weights @ x, rtol=0, atol=60 * 1e-16 * 60)  # sums of sixty numbers near one


@pytest.mark.parametrize("sign", ["printed", "descending"])
def test_the_neural_pid_is_the_two_printed_equations(sign: str) -> None:
    targets, readings = sequences(2)
    rates, w = np.array([0.3, 0.1, 0.2]), np.array([1.0, 0.5, 0.2])
    neural = NeuralPID(w, rates=rates, sign=sign, lowest=-1e6, highest=1e6, **WIDE)
    total, before = 0.0, None
    for target, reading in zip(targets, readings, strict=True):
        e = reading - target if sign == "printed" else target - reading
        total += 0.25 * e
        x = np.array([e, total, 0.0 if before is None else e - before])
        before = e
        # the same operations in another order: rounding of sixty steps
        assert_allclose(neural.step(target, reading), w @ x, rtol=0, atol=1e-12)
        w = w + rates * e * x
        assert_allclose(neural.weights, w, rtol=0, atol=1e-12)


def squared_errors(sign: str, steps: int = 30) -> np.ndarray:
    """A static plant, measured = command of the step before, learning the first weight alone."""
    neural = NeuralPID((0.1, 0.0, 0.0), rates=(0.05, 0.0, 0.0), sign=sign, lowest=-1e6, highest=1e6, **WIDE)
    found = []
    for _ in range(steps):
        # The measurement that this step's weights would lead to, were the target one and the reading zero.
        neural_command = neural.weights[0] * (1.0 if sign == "descending" else -1.0)
        found.append((1.0 - neural_command) ** 2)
        neural.step(1.0, 0.0)
    return np.array(found)


def test_the_update_goes_down_the_squared_error_with_our_sign_and_up_with_the_printed_one() -> None:
    assert (np.diff(squared_errors("descending")[:15]) < 0.0).all()
    assert (np.diff(squared_errors("printed")) > 0.0).all()


def integrated(controller: PID | NeuralPID, steps: int = 3000) -> np.ndarray:
    """An integrator as plant, target 1."""
    y, found = 0.2, []
    for _ in range(steps):
        y += 0.01 * controller.step(1.0, y)
        found.append(y)
    return np.array(found)


def test_positive_weights_settle_with_our_sign_and_run_away_with_the_printed_one() -> None:
    options = {"scale": 1.0, "period": 0.01}
    for make in (lambda **k: PID((2.0, 0.2, 0.0), **k), lambda **k: NeuralPID((2.0, 0.2, 0.0), rates=1e-3, **k)):
        # two time constants 0.5 s and 10 s, thirty seconds: e^-3 of the slow one's share, a tenth
        assert abs(integrated(make(**options))[-1] - 1.0) < 0.02
        # away from the target at the limit of the command: 1 per second for thirty seconds
        assert integrated(make(sign="printed", **options))[-1] < -25.0


def test_the_normalised_rule_learns_the_same_from_small_errors_as_from_large_ones() -> None:
    changes = []
    for size in (1.0, 1e-3):
        neural = NeuralPID((1.0, 1.0, 1.0), rates=0.1, learning="normalised", epsilon=1e-18, **WIDE)
        for k in range(3):
            neural.step(size * (1.0 + k), 0.0)
        changes.append(np.array(neural.weights) - 1.0)
    assert_allclose(changes[0], changes[1], rtol=1e-9)  # epsilon over the smallest |x|^2, 1e-6, three times
    assert (np.abs(changes[0]) > 1e-3).any()


@pytest.mark.parametrize("seed", range(5))
def test_weights_and_commands_stay_within_their_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    neural = NeuralPID((1.0, 1.0, 1.0), rates=1e3, lowest=(0.0, 0.5, -1.0), highest=(2.0, 3.0, 4.0), scale=1.0)
    for _ in range(300):
        command = neural.step(*(rng.standard_cauchy(2) * 10.0 ** rng.integers(-3, 100)))
        assert -1.0 <= command <= 1.0
        assert all(a <= w <= b for a, w, b in zip((0.0, 0.5, -1.0), neural.weights, (2.0, 3.0, 4.0), strict=True))


def test_a_command_at_its_limit_teaches_nothing() -> None:
    neural = NeuralPID((10.0, 0.0, 0.0), rates=1.0, scale=1.0)
    assert neural.step(1.0, 0.0) == 1.0
    assert neural.weights == (10.0, 0.0, 0.0)


def time_back(anti_windup: str) -> int:
    """Steps until the command leaves its limit, after a target that was out of reach for a while."""
    pid = PID((1.0, 5.0, 0.0), scale=1.0, period=0.01, anti_windup=anti_windup)
    for _ in range(500):
        pid.step(5.0, 1.0)
    for step in range(2000):
        if pid.step(0.5, 1.0) < 1.0:
            return step
    return 2000


def test_anti_windup_lets_the_command_leave_its_limit_at_once() -> None:
    # the sum grew to 4 * 5 s * 5 1/s = 100 and falls by 2.5 a second
    assert time_back("none") > 1900
    # 1 x1 + 5 x2 stood at one within one step's growth of 0.2: the error's jump alone takes it off
    assert time_back("conditional") <= 1
    # drawn back with 0.1 s, it stood (4 + 20 * 0.1) / 1 = 2 above the limit; the error's jump of 4.5 is more
    assert time_back("back_calculation") <= 1


def test_the_filter_spreads_the_difference_of_a_jump_geometrically() -> None:
    period, time = 0.1, 0.3
    pid = PID((0.0, 0.0, 1.0), scale=1.0, limits=(-9, 9), period=period, filter_time=time)
    pid.step(0.0, 0.0)
    found = np.array([pid.step(1.0, 0.0) for _ in range(10)])
    share = period / (time + period)
    assert_allclose(found, share * (1.0 - share) ** np.arange(10), rtol=1e-12)
    assert PID((0.0, 0.0, 1.0), scale=1.0).step(1.0, 0.0) == 0.0  # no jump at the first step


@pytest.mark.parametrize("bad", [(np.nan, 0.0), (0.0, np.inf), (np.inf, np.inf)])
@pytest.mark.parametrize(
    "make", [lambda: PID((1, 1, 1), scale=1.0), lambda: NeuralPID((1, 1, 1), rates=0.1, scale=1.0)]
)
def test_what_is_no_number_repeats_the_command_and_changes_nothing(make, bad: tuple[float, float]) -> None:
    one, other = make(), make()
    first = one.step(0.3, 0.1), other.step(0.3, 0.1)
    assert first[0] == one.step(*bad)
    assert one.weights == other.weights
    assert one.step(0.4, 0.1) == other.step(0.4, 0.1)


def test_the_secant_finds_the_slope_of_a_static_plant() -> None:
    # With a given slope of 3 and with the secant of a plant of slope 3 the weights learn alike.
    learned = []
    for slope in ("given", "secant"):
        neural = NeuralPID((0.2, 0.1, 0.0), rates=0.01, slope=slope, **WIDE)
        rng, measured = np.random.default_rng(7), 0.0
        for k in range(40):
            if k == 3:  # by then the secant has been read
                start = np.array(neural.weights)
            measured = 3.0 * neural.step(rng.uniform(0.5, 1.0), measured, 3.0)
        learned.append((start, np.array(neural.weights)))
    # the first steps, taken with a slope of one, leave other weights; what is learned later is nearly the same
    assert_allclose(learned[1][1] - learned[1][0], learned[0][1] - learned[0][0], rtol=0.1)


def test_a_reset_controller_is_a_fresh_one_and_a_pickled_one_too() -> None:
    for fresh in (PID((1, 2, 3)), NeuralPID((1, 2, 3), rates=0.5, learning="normalised")):
        used = fresh.replaced()
        for k in range(5):
            used.step(1e4 * k, 100.0)
        used.reset()
        copy = pickle.loads(pickle.dumps(fresh))
        assert copy == fresh and hash(copy) == hash(fresh) and copy.options == fresh.options
        assert used.step(3e4, 1e4) == fresh.step(3e4, 1e4) == copy.step(3e4, 1e4)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: PID((1, 2)), "weights"),
        (lambda: PID((1, np.nan, 0)), "weights"),
        (lambda: PID((1, 1, 1), period=0.0), "period"),
        (lambda: PID((1, 1, 1), limits=(1, -1)), "limits must rise"),
        (lambda: PID((1, 1, 1), sign="up"), "sign must be one of"),
        (lambda: PID((1, 1, 1), anti_windup="yes"), "anti_windup must be one of"),
        (lambda: PID((1, 1, 1), filter_time=-1.0), "filter_time"),
        (lambda: NeuralPID((1, 1, 1), rates=-1.0), "rates must not be negative"),
        (lambda: NeuralPID((1, 1, 1), rates=1.0, lowest=2.0, highest=1.0), "lowest must not exceed"),
        (lambda: NeuralPID((1, 1, 1), rates=1.0, learning="deep"), "learning must be one of"),
        (lambda: NeuralPID((1, 1, 1), rates=1.0, epsilon=0.0), "epsilon"),
    ],
)
def test_bad_options_are_refused_by_name(make, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        make()
