"""The pneumatic plant: closed forms of its parts, mass, an independent integration, and the size of its steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from softlimb import _core
from softlimb.control import Chamber, Gas, Line, Pneumatics, Sensor, Supply, Valve
from softlimb.presets import reference_limb
from softlimb.units import kPa, mm, ms

AIR = 1.185  # [kg/m^3], the reference density of ISO 6358
ATMOSPHERE = 101325.0
ROOM = 287.05 * 293.15  # R T
EXACT = Sensor(noise=0.0, bits=0)
PLAIN = Valve(time_constant=0.0, dead_time=0.0, dead_band=0.0, hysteresis=0.0)


def rigid(volume: float) -> Chamber:
    return Chamber(np.array([0.0, 500 * kPa]), np.full(2, volume))


def run(plant: _core.Plant, commands: np.ndarray) -> np.ndarray:
    """Chamber pressures after each row of commands."""
    found = []
    for row in commands:
        assert plant.advance(row)
        found.append(plant.pressures)
    return np.array(found)


# Orifice


def test_a_choked_orifice_passes_its_conductance_times_the_pressure_upstream() -> None:
    rate, d_first, d_second = _core.orifice_flow(2e-9, 0.3, 400 * kPa, 100 * kPa)
    assert_allclose([rate, d_first, d_second], [2e-9 * AIR * 400 * kPa, 2e-9 * AIR, 0.0], rtol=1e-15)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9])
def test_a_subsonic_orifice_follows_the_ellipse(ratio: float) -> None:
    share = 1.0 if ratio <= 0.3 else np.sqrt(1.0 - ((ratio - 0.3) / 0.7) ** 2)
    rate = _core.orifice_flow(2e-9, 0.3, 4e5, ratio * 4e5)[0]
    assert_allclose(rate, 2e-9 * AIR * 4e5 * share, rtol=1e-14)


def test_the_flow_is_continuous_and_runs_the_other_way_when_the_pressures_change_places() -> None:
    for ratio in (0.3, 0.999, 1.0):
        below, above = (_core.orifice_flow(1e-9, 0.3, 2e5, 2e5 * (ratio + h))[0] for h in (-1e-10, 1e-10))
        # over 2e-10 of the ratio the flow changes by its slope: of the linear part 54 times the choked flow
        assert abs(below - above) < 60 * 2e-10 * 1e-9 * AIR * 2e5
    forth, back = _core.orifice_flow(1e-9, 0.3, 2e5, 1.5e5), _core.orifice_flow(1e-9, 0.3, 1.5e5, 2e5)
    assert forth[0] == -back[0] and forth[1] == -back[2] and forth[2] == -back[1]


@pytest.mark.parametrize("pressures", [(3e5, 1e5), (3e5, 1.8e5), (3e5, 2.9995e5), (1.2e5, 2e5)])
def test_the_slopes_of_the_flow_are_its_differences(pressures: tuple[float, float]) -> None:
    flow = _core.orifice_flow(1e-9, 0.3, *pressures)
    for place in (0, 1):
        h = np.zeros(2)
        h[place] = 1.0
        up, down = (_core.orifice_flow(1e-9, 0.3, *(np.array(pressures) + side * h))[0] for side in (1, -1))
        # h = 1 Pa: the third derivative's share is 1e-10, rounding of flows of 4e-4 some 1e-13 of it
        assert_allclose(flow[1 + place], (up - down) / 2.0, rtol=1e-7, atol=1e-21)


# Valve and sensor


def openings(valve: Valve, commands: np.ndarray, substeps: int = 1) -> np.ndarray:
    plant = Pneumatics([rigid(1e-3)], valve=valve, substeps=substeps).plant()
    found = []
    for command in commands:
        plant.advance(np.array([command]))
        found.append(plant.openings[0])
    return np.array(found)


def test_the_spool_waits_its_dead_time_and_then_follows_its_differential_equation_exactly() -> None:
    valve = Valve(time_constant=8 * ms, dead_time=5 * ms, dead_band=0.0, hysteresis=0.0)
    found = openings(valve, np.full(40, 0.6), substeps=4)
    after = np.maximum(np.arange(1, 41) - 5, 0)
    assert_allclose(found, 0.6 * -np.expm1(-after / 8.0), rtol=0, atol=1e-14)


def test_the_dead_band_opens_nothing_and_the_full_command_everything() -> None:
    valve = Valve(time_constant=0.0, dead_time=0.0, dead_band=0.1, hysteresis=0.0)
    assert_allclose(openings(valve, np.array([0.09, -0.1, 0.55, 1.0, -3.0])), [0, 0, 0.5, 1, -1], atol=1e-15)


def test_the_play_is_as_wide_as_its_hysteresis() -> None:
    valve = Valve(time_constant=0.0, dead_time=0.0, dead_band=0.0, hysteresis=0.1)
    up, down = np.linspace(0.0, 0.8, 81), np.linspace(0.8, 0.0, 81)
    found = openings(valve, np.concatenate([up, down]))
    assert_allclose(found[40] - up[40], -0.05, atol=1e-15)
    assert_allclose(found[81 + 40] - down[40], 0.05, atol=1e-15)


def test_a_command_that_is_no_number_exhausts() -> None:
    assert openings(PLAIN, np.array([np.nan]))[0] == -1.0


def test_a_converter_of_ten_bits_gives_whole_codes_and_the_noise_its_deviation() -> None:
    sensor = Sensor(low=0.0, high=200 * kPa, noise=2 * kPa, offset=50 * kPa, bits=10)
    plant = Pneumatics([rigid(1e-3)] * 50, sensor=sensor, supply=Supply(volume=1.0), seed=3).plant()
    readings = np.concatenate([plant.read() for _ in range(200)])
    codes = readings / (200 * kPa) * 1023
    assert_allclose(codes, np.round(codes), atol=1e-9)
    # 10 000 readings: the mean is known to 2 kPa / 100, the deviation to 0.7 % of it; five times that
    assert abs(readings.mean() - 50 * kPa) < 5 * 2 * kPa / 100
    assert abs(readings.std() / (2 * kPa) - 1.0) < 5 * 0.007


def test_a_seed_gives_the_same_readings_and_another_seed_others() -> None:
    first, again, other = (Pneumatics([rigid(1e-3)], seed=seed).plant() for seed in (5, 5, 6))
    rows = [np.concatenate([plant.read() for _ in range(30)]) for plant in (first, again, other)]
    assert (rows[0] == rows[1]).all() and (rows[0] != rows[2]).any()


def test_a_broken_sensor_gives_no_number_or_its_last_one_and_a_bias_adds() -> None:
    plant = Pneumatics([rigid(1e-3)], sensor=EXACT).plant()
    plant.set_sensor(0, bias=3 * kPa)
    assert plant.read()[0] == 3 * kPa
    plant.set_sensor(0, fault="stuck")
    plant.advance(np.array([1.0]))
    assert plant.read()[0] == 3 * kPa
    plant.set_sensor(0, fault="not_finite")
    assert np.isnan(plant.read()[0])


# Chambers and gas


def test_a_chamber_has_the_volume_of_its_tube_at_its_pressure() -> None:
    limb = reference_limb()
    plant = Pneumatics(limb).plant()
    for _ in range(900):
        plant.advance(np.linspace(0.15, 1.0, 9))
    tubes = [tube for segment in limb.segments for tube in segment.actuators]
    expected = [tube.inflate(p).volume for tube, p in zip(tubes, plant.pressures, strict=True)]
    assert np.ptp(plant.pressures) > 30 * kPa  # that a wide range was looked at
    # monotone cubic pieces of width h are of order h^3: 2 kPa of the 100 kPa over which the volume doubles
    assert_allclose(plant.volumes, expected, rtol=(2 / 100) ** 3)


def test_a_finer_table_of_volumes_changes_little() -> None:
    tube = reference_limb().segments[2].actuators[0]
    coarse, fine = Chamber.of(tube), Chamber.of(tube, points=251)
    plants = [Pneumatics([chamber], sensor=EXACT).plant() for chamber in (coarse, fine)]
    found = [run(plant, np.full((300, 1), 0.5)) for plant in plants]
    assert_allclose(found[0], found[1], rtol=0, atol=(2 / 100) ** 3 * 150 * kPa)  # as above, of the pressure


@pytest.mark.parametrize("exponent", [1.0, 1.2, 1.4])
def test_air_that_is_squeezed_in_a_closed_chamber_follows_its_polytrope(exponent: float) -> None:
    gas, line = Gas(exponent=exponent), Line(length=1.0, diameter=4 * mm)
    plant = Pneumatics([rigid(2e-4)], valve=PLAIN, line=line, gas=gas).plant()
    plant.set_volume_scale(0, 0.8)
    plant.advance(np.zeros(1))
    for _ in range(300):
        plant.advance(np.zeros(1))
    in_line = np.pi / 4 * 0.004**2
    ratio = (2e-4 + in_line) / (0.8 * 2e-4 + in_line)
    # 300 ms are some hundred time constants of line and chamber
    assert_allclose(plant.pressures[0] + ATMOSPHERE, ATMOSPHERE * ratio**exponent, rtol=1e-9)


def test_a_choked_feed_fills_a_rigid_chamber_at_a_constant_rate() -> None:
    supply = Supply(volume=1e3, pressure=400 * kPa)  # so large that its pressure stands still
    plant = Pneumatics([rigid(1e-3)], valve=PLAIN, gas=Gas(exponent=1.0), supply=supply).plant()
    pressures = run(plant, np.ones((900, 1)))[:, 0]
    in_line = np.pi / 4 * 0.0025**2
    rate = 1e-9 * AIR * (400 * kPa + ATMOSPHERE) * ROOM / (1e-3 + in_line)
    slopes = np.diff(pressures[100:]) / 1e-3
    # The line's own pressure lags behind by a drop that changes with the pressure: some 0.1 % of the flow goes there.
    assert_allclose(slopes, rate, rtol=3e-3)
    assert pressures[-1] + ATMOSPHERE < 0.3 * (400 * kPa + ATMOSPHERE)  # choked all the way


# Mass


@pytest.mark.parametrize("exponent", [1.0, 1.3])
def test_no_air_is_made_or_lost(exponent: float) -> None:
    plant = Pneumatics(reference_limb(), gas=Gas(exponent=exponent)).plant()
    rng = np.random.default_rng(11)
    steps = 3000
    for k in range(steps):
        if k % 200 == 0:
            commands = rng.uniform(-1.2, 1.2, 9)
            plant.set_leak(k // 200 % 9, float(rng.uniform(0.0, 1e-10)))
            plant.set_volume_scale(k // 200 % 9, float(rng.uniform(0.8, 1.2)))
        if k == 2000:
            plant.set_supply(pump_share=0.0, leak=1e-8)
        if k == 2500:
            plant.set_dumped(True)
        plant.advance(commands)
    air = plant.ledger
    assert air["pumped"] > 1e-4 and air["lost"] > 1e-3  # that something went in and out
    # 12 000 sub-steps of nine channels each add a few numbers to sums of 0.02 kg: a random walk of roundings of 3e-18,
    # and straight on were all of them to the same side
    assert abs(air["stored"] - (air["at_start"] + air["pumped"] - air["lost"])) < 12_000 * 9 * 3e-18
    # Newton ends at 1e-12 of a channel's air, and the line has a fiftieth of it or more
    assert plant.mass_defect < 1e-10


def test_vented_lines_come_down_to_the_atmosphere_and_the_supply_is_kept() -> None:
    plant = Pneumatics(reference_limb()).plant()
    run(plant, np.ones((500, 9)))
    assert plant.pressures.min() > 40 * kPa
    plant.set_dumped(True)
    plant.set_valve_stuck(3, True)  # open to the supply, which is cut off
    supply = plant.supply_pressure
    run(plant, np.full((4000, 9), -1.0))
    assert np.abs(plant.pressures).max() < 0.1 * kPa
    assert plant.supply_pressure >= supply


def test_the_pump_refills_the_reservoir_at_its_flow() -> None:
    supply = Supply(pressure=250 * kPa, volume=5e-3, flow=1e-4, band=1.0)
    plant = Pneumatics([rigid(1e-3)], valve=PLAIN, supply=supply, gas=Gas(exponent=1.0)).plant()
    run(plant, np.ones((1000, 1)))
    low = plant.supply_pressure
    assert low < 249 * kPa
    run(plant, np.zeros((100, 1)))
    assert_allclose(plant.supply_pressure - low, 0.1 * 1e-4 * ROOM / 5e-3, rtol=1e-3)  # what was in the valve's way


def test_a_reservoir_with_a_leak_and_no_pump_loses_its_pressure() -> None:
    plant = Pneumatics([rigid(1e-4)]).plant()
    plant.set_supply(pump_share=0.0, leak=1e-6)
    run(plant, np.zeros((1000, 1)))
    assert 0.0 <= plant.supply_pressure < 1 * kPa


# Integration


def reference(volume: float, opening: float, seconds: float, exponent: float) -> float:
    """The same equations by Radau's method of scipy at 1e-9, written out once more: chamber pressure at the end."""
    conductance, b, lam, supply = 1e-9, 0.3, 0.999, 250 * kPa + ATMOSPHERE
    in_line = np.pi / 4 * 0.0025**2
    factor = np.pi * 0.0025**4 / (256 * 1.82e-5 * 1.0 * ROOM)
    rho = ATMOSPHERE / ROOM

    def pressure(mass: float, size: float) -> float:
        return ATMOSPHERE * (mass / size / rho) ** exponent

    def flow(p1: float, p2: float) -> float:
        ratio = p2 / p1
        full = conductance * opening * AIR * p1
        if ratio <= b:
            return full
        if ratio < lam:
            return full * np.sqrt(1 - ((ratio - b) / (1 - b)) ** 2)
        return full * np.sqrt(1 - ((lam - b) / (1 - b)) ** 2) * (1 - ratio) / (1 - lam)

    def rates(_: float, masses: np.ndarray) -> list[float]:
        line, chamber = pressure(masses[0], in_line), pressure(masses[1], volume)
        along = factor * (line**2 - chamber**2)
        return [flow(supply, line) - along, along]

    start = [rho * in_line, rho * volume]
    found = solve_ivp(rates, (0.0, seconds), start, method="Radau", rtol=1e-9, atol=1e-18)
    return pressure(found.y[1, -1], volume) - ATMOSPHERE


@pytest.mark.parametrize(("volume", "opening", "seconds"), [(2e-4, 0.7, 0.4), (2e-5, 1.0, 0.05), (5e-5, 0.1, 0.8)])
def test_the_plant_agrees_with_another_integration_of_the_same_equations(
    volume: float, opening: float, seconds: float
) -> None:
    expected = reference(volume, opening, seconds, 1.2)
    steps = round(seconds / 1e-3)
    errors = []
    for substeps in (8, 16, 32):
        pneumatics = Pneumatics([rigid(volume)], valve=PLAIN, supply=Supply(volume=1e3), substeps=substeps)
        errors.append(run(pneumatics.plant(), np.full((steps, 1), opening))[-1, 0] - expected)
    # Of first order: what the extrapolation leaves is of second order, (h/tau)^2 with tau of 5 ms and more
    assert_allclose(2 * errors[2] - errors[1], 0.0, atol=(1e-3 / 16 / 5e-3) ** 2 * 250 * kPa)
    assert abs(errors[2]) < 100.0


def study(substeps: int) -> np.ndarray:
    """Nine chambers filled, held, exhausted: pressures every millisecond."""
    plant = Pneumatics(reference_limb(), substeps=substeps).plant()
    commands = np.repeat([0.6, 0.0, -0.5], (300, 100, 200))
    return run(plant, np.tile(commands[:, None], 9))


def test_halving_the_sub_step_halves_the_error_and_the_default_is_a_fifth_of_a_converter_code() -> None:
    fine = study(64)
    errors = [float(np.abs(study(n) - fine).max()) for n in (2, 4, 8)]
    # First order; the finest has an error of its own, an eighth of the last one.
    for coarse, half in pairwise(errors):
        assert 1.8 < coarse / half < 2.4
    assert errors[1] < 200 * kPa / 1023 / 5


def test_explicit_steps_of_the_same_size_would_leave_the_physical_range() -> None:
    """Why the steps are implicit: line and laminar flow have a time constant of half a millisecond at 250 kPa."""
    in_line, volume = np.pi / 4 * 0.0025**2, 2e-5
    factor = np.pi * 0.0025**4 / (256 * 1.82e-5 * ROOM)
    masses = np.array([in_line, volume]) * ATMOSPHERE / ROOM
    steps = 0
    while steps < 200 and 0.0 < masses.min() and masses.max() < 1.0:
        line, chamber = masses / [in_line, volume] * ROOM
        along = factor * (line**2 - chamber**2)
        fed = _core.orifice_flow(1e-9, 0.3, 250 * kPa + ATMOSPHERE, line)[0]
        masses = masses + 1e-3 * np.array([fed - along, along])
        steps += 1
    assert steps < 200  # within a fifth of a second an air mass was negative, or without bound
    plant = Pneumatics([rigid(volume)], valve=PLAIN, substeps=1).plant()
    assert run(plant, np.ones((200, 1))).min() >= 0.0


# Arguments


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Gas(exponent=1.5), "exponent of a Gas must be within"),
        (lambda: Valve(conductance=0.0), "conductance of a Valve"),
        (lambda: Valve(dead_band=1.0), "dead_band of a Valve"),
        (lambda: Line(diameter=-1.0), "diameter of a Line"),
        (lambda: Sensor(low=1.0, high=0.0), "high of a Sensor must be above low"),
        (lambda: Sensor(bits=30), "bits of a Sensor"),
        (lambda: Supply(volume=np.nan), "volume of a Supply"),
        (lambda: Chamber(np.array([0.0, 1.0]), np.array([2.0, 1.0])), "must not fall"),
        (lambda: Chamber(np.array([1.0, 0.0]), np.array([1.0, 2.0])), "must rise"),
        (lambda: Pneumatics([]), "chambers must be at least one"),
        (lambda: Pneumatics([rigid(1e-4)], valve=[Valve()] * 2), "valve must be a Valve, or one for each of 1"),
        (lambda: Pneumatics([rigid(1e-4)], substeps=0), "substeps"),
        (lambda: Pneumatics([rigid(1e-4)], substeps=10**7), "substeps must be a whole number of at least 1 and at"),
        (lambda: Pneumatics([rigid(1e-4)], supply=Supply(volume=1e-6)).plant(), "take a larger reservoir"),
        (lambda: Pneumatics([rigid(1e-4)]).plant().set_leak(0, -1.0), "conductance of a leak"),
        (lambda: Pneumatics([rigid(1e-4)]).plant().set_sensor(0, fault="odd"), "fault must be one of"),
        (lambda: Pneumatics([rigid(1e-4)]).plant().advance(np.zeros(2)), "commands must be one number a channel"),
    ],
)
def test_bad_numbers_are_refused_by_name(make, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        make()


def test_a_channel_that_is_not_there_is_refused() -> None:
    with pytest.raises(IndexError, match="channel 4 of 1"):
        Pneumatics([rigid(1e-4)]).plant().set_leak(4, 0.0)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Pneumatics([rigid(1e-4)], gas=1.2), "gas must be of type Gas, got 1.2"),
        (lambda: Pneumatics([rigid(1e-4)], supply=250e3), "supply must be of type Supply, got 250000.0"),
        (lambda: Pneumatics(None), "chambers must be of type Limb or Sequence, got None"),
    ],
)
def test_other_types_are_refused_by_name(make, says: str) -> None:
    with pytest.raises(TypeError, match=says):
        make()
