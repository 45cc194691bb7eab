"""Rods and limbs against the reference solutions: two methods each that share no code with ours.

Every tolerance that has no reason of its own beside it is what a solve at 1e-9 promises: positions within 1e-8 of the
length, rotations within 1e-8 rad, wrenches within 1e-6 of the largest, compliances within 1e-6 of the largest.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb import presets
from softlimb.units import kPa, mm

CANTILEVERS = (
    "mild: small tip force",
    "large: F=1 N transverse (FL2/EI=6.4)",
    "gravity along -z plus 3D tip force and moment",
    "pure moment 270 deg (circle arc)",
    "moment 240 deg plus transverse and out-of-plane force (rotation > 180 deg)",
    "soft: gravity transverse (heavy sag)",
    "soft: gravity, 3D force and moment",
)
PARALLEL_RODS = (
    "two rods, 10% length difference, no load",
    "six steel legs clamped at both ends, given lengths, platform force",
)
LIMB_POSTURES = (
    "complex posture of the paper, no load",
    "all nine at 55 kPa, hanging",
    "complex posture, hanging, tip force and tip moment",
    "gravity along x, wrench on the first plate",
    "hanging, wrench on the second plate and tip force",
)
STEP = 1e-3  # of the load scale: Richardson's error is then its fourth power, far below the solves' own 1e-12 over it


@pytest.fixture(scope="module")
def cases(shared: Path) -> Callable[[str], dict[str, dict[str, Any]]]:
    def read(name: str) -> dict[str, dict[str, Any]]:
        path = shared / "reference" / f"{name}.json"
        return {case["name"]: case for case in json.loads(path.read_text(encoding="utf-8"))["cases"]}

    return read


def section(rod: dict[str, Any]) -> sl.Section:
    if "Kse_diag" in rod:
        shear, _, axial = rod["Kse_diag"]
        bending, _, torsion = rod["Kbt_diag"]
    else:
        shear, axial, bending, torsion = rod["shear"], rod["axial"], rod["bending"], rod["torsion"]
    return sl.Section(
        axial=axial, shear=shear, bending=bending, torsion=torsion, mass_per_length=rod.get("mass_per_length", 0.0)
    )


def shifted(offsets: list[Any]) -> np.ndarray:
    frames = np.tile(np.eye(4), (len(offsets), 1, 1))
    frames[:, :3, 3] = offsets
    return frames


def pose(position: Any, rotation: Any) -> np.ndarray:
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = rotation, position
    return frame


def angle_between(first: Any, second: Any) -> float:
    # |R1 - R2| in the Frobenius norm is 2 sqrt(2) sin(angle/2): no loss of digits at small angles, unlike the trace.
    gap = np.linalg.norm(np.asarray(first) - np.asarray(second)) / np.sqrt(8.0)
    return float(2.0 * np.arcsin(min(gap, 1.0)))


def assert_pose(found: np.ndarray, position: Any, rotation: Any, length: float) -> None:
    assert np.linalg.norm(found[:3, 3] - position) <= 1e-8 * length
    # The references' own rotations are orthogonal to 1e-12 (limb postures are printed with 15 digits).
    assert angle_between(found[:3, :3], rotation) <= 1e-8


def assert_wrenches(found: Any, expected: Any) -> None:
    found, expected = np.reshape(found, (-1, 6)), np.reshape(expected, (-1, 6))
    for part in (slice(0, 3), slice(3, 6)):
        # Where there is no force (a pure moment) or no moment, both sides hold rounding: 1e-10 N, N m are zero.
        largest = max(np.abs(expected[:, part]).max(), 1e-4)
        assert_allclose(found[:, part], expected[:, part], rtol=0.0, atol=1e-6 * largest)


def assert_trusted(posture: sl.Posture) -> None:
    assert posture.success, posture.message
    check = posture.verify()
    assert check.success, check


def differences_of_the_tip(solve: Callable[[np.ndarray], sl.Posture], scale: np.ndarray) -> np.ndarray:
    """Tip (displacement, rotation) per change of each argument: central differences, one Richardson extrapolation."""

    def slope(k: int, step: float) -> np.ndarray:
        change = np.zeros(len(scale))
        change[k] = step * scale[k]
        plus, minus = solve(change).tip, solve(-change).tip
        spin = plus[:3, :3] @ minus[:3, :3].T  # twice the sine's axis: the log's error is of third order and known
        sine = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        norm = np.linalg.norm(sine)
        turn = sine if norm == 0.0 else sine * (np.arcsin(norm) / norm)
        return np.concatenate([plus[:3, 3] - minus[:3, 3], turn]) / (2.0 * step * scale[k])

    columns = [(4.0 * slope(k, 0.5 * STEP) - slope(k, STEP)) / 3.0 for k in range(len(scale))]
    return np.array(columns).T


@pytest.mark.parametrize("name", CANTILEVERS)
def test_cantilever_meets_the_reference(name: str, cases: Callable[[str], Any]) -> None:
    case = cases("cantilevers")[name]
    length = case["L"]
    found = sl.Rod(section(case), length).cantilever(
        case["tip_force"],
        case["tip_moment"],
        distributed_force=case["f_per_length"],
        distributed_moment=case["l_per_length"],
        tolerance=1e-9,
    )
    assert_trusted(found.posture)
    assert_pose(found.tip, case["tip_position"], case["tip_rotation"], length)
    assert_wrenches(found.base_wrench, case["base_force_n0"] + case["base_moment_m0"])
    along = found.centreline(21)  # equal steps of rest length: 0.05 of the length each, the samples lie on them
    for sample in case["samples"]:
        number = round(20 * sample["s"] / length)
        assert abs(number / 20 * length - sample["s"]) < 1e-12
        assert_allclose(along[number], sample["p"], rtol=0.0, atol=1e-8 * length)


def parallel_limb(case: dict[str, Any]) -> tuple[sl.Limb, np.ndarray, np.ndarray]:
    segments, wrenches, forces = [], [], []
    for given in case["segments"]:
        rods = given["rods"]
        segments.append(
            sl.Segment(
                rods=[sl.Rod(section(rod), rod["rest_length"]) for rod in rods],
                base_frames=shifted([rod["base_offset"] for rod in rods]),
                end_frames=shifted([rod["tip_offset"] for rod in rods]),
            )
        )
        wrenches.append(given["plate"]["force"] + given["plate"]["moment"])
        forces += [rod["f_per_length"] for rod in rods]
    return sl.Limb(segments), np.array(wrenches), np.array(forces)


@pytest.mark.parametrize("name", PARALLEL_RODS)
def test_parallel_rods_meet_the_reference(name: str, cases: Callable[[str], Any]) -> None:
    case = cases("parallel_rods")[name]
    limb, wrenches, forces = parallel_limb(case)
    found = limb.solve(plate_wrenches=wrenches, rod_forces=forces, tolerance=1e-9)
    assert_trusted(found)
    # The file's postures are stable, its README says.
    assert found.stable
    for plate, given in zip(found.plates, case["segments"], strict=True):
        assert_pose(plate, given["plate"]["position"], given["plate"]["rotation"], limb.length)
    listed = [rod for given in case["segments"] for rod in given["rods"]]
    posed = [rod for row in found.rods for rod in row]
    assert_wrenches([rod.base_wrench for rod in posed], [rod["n0"] + rod["m0"] for rod in listed])
    if all("nL" in rod for rod in listed):
        ends = [np.concatenate([rod.force[-1], rod.moment[-1]]) for rod in posed]
        assert_wrenches(ends, [rod["nL"] + rod["mL"] for rod in listed])


def test_compliance_of_two_rods_meets_the_reference(cases: Callable[[str], Any]) -> None:
    case = cases("parallel_rods")[PARALLEL_RODS[0]]
    limb, wrenches, forces = parallel_limb(case)
    found = limb.solve(plate_wrenches=wrenches, rod_forces=forces, tolerance=1e-9)
    expected = np.array(case["tip_compliance_6x6"])
    # The reference is unsymmetric by 8.6e-9 (relative): its differences' own error, far below the 1e-6 claimed.
    assert_allclose(found.compliance, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def limb_of_sections(case: dict[str, Any], geometry: list[dict[str, Any]]) -> sl.Limb:
    return sl.Limb(
        [
            sl.Segment(
                rods=[sl.Rod(section(rod), rod["rest_length"]) for rod in rods],
                ring_radius=part["ring_radius"],
                plate=sl.Plate(thickness=25 * mm, mass=0.14),
            )
            for rods, part in zip(case["rods"], geometry, strict=True)
        ]
    )


def solve_posture(case: dict[str, Any], geometry: list[dict[str, Any]], route: str) -> tuple[sl.Limb, sl.Posture]:
    wrenches = np.array(case["plate_wrenches"])
    if route == "sections":
        limb = limb_of_sections(case, geometry)
        return limb, limb.solve(gravity=case["gravity"], plate_wrenches=wrenches, tolerance=1e-9)
    limb = presets.reference_limb()
    pressures = np.array(case["pressures_kPa"]) * kPa
    return limb, limb.solve(pressures, gravity=case["gravity"], plate_wrenches=wrenches, tolerance=1e-9)


@pytest.fixture(scope="module")
def geometry(shared: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((shared / "reference/limb_postures.json").read_text("utf-8"))["geometry"]
    return found


@pytest.mark.parametrize("name", LIMB_POSTURES)
def test_sections_of_the_reference_limb_are_the_listed_ones(name: str, cases: Callable[[str], Any]) -> None:
    case = cases("limb_postures")[name]
    for segment, rods, pressures in zip(
        presets.reference_limb(), case["rods"], case["pressures_kPa"], strict=True
    ):
        for tube, listed, pressure in zip(segment.actuators, rods, pressures, strict=True):
            at = tube.section_at(pressure * kPa)
            found = {
                "rest_length": at.rest_length,
                "axial": at.section.axial,
                "shear": at.section.shear,
                "bending": at.section.bending,
                "torsion": at.section.torsion,
                "mass_per_length": at.section.mass_per_length,
            }
            for field, value in found.items():
                # The reference tubes are exact to 1e-9 in stretch; their tangents, one derivative further, to 1e-8.
                assert value == pytest.approx(listed[field], rel=1e-8), field


@pytest.mark.parametrize("route", ["sections", "pressures"])
@pytest.mark.parametrize("name", LIMB_POSTURES)
def test_limb_posture_meets_the_reference(
    name: str, route: str, cases: Callable[[str], Any], geometry: list[dict[str, Any]]
) -> None:
    case = cases("limb_postures")[name]
    _, found = solve_posture(case, geometry, route)
    assert_trusted(found)
    assert found.stable
    length = 0.65  # of the reference limb; the listed sections as rods would count their pressurised length
    for plate, given in zip(found.plates, case["plates"], strict=True):
        assert_pose(plate, given["position"], given["rotation"], length)
    assert_wrenches(
        [[rod.base_wrench for rod in row] for row in found.rods],
        [given["rod_base_wrenches"] for given in case["plates"]],
    )


@pytest.mark.parametrize("name", LIMB_POSTURES)
def test_limb_compliance_meets_the_reference_and_extrapolated_differences(
    name: str, cases: Callable[[str], Any], geometry: list[dict[str, Any]]
) -> None:
    case = cases("limb_postures")[name]
    limb, found = solve_posture(case, geometry, "sections")
    expected = np.array(case["tip_compliance"])
    # The file's differences are good to about 1e-6 themselves, each entry relative to the largest of its block.
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            block = expected[rows, columns]
            assert_allclose(found.compliance[rows, columns], block, rtol=0.0, atol=4e-6 * np.abs(block).max())

    def loaded(change: np.ndarray) -> sl.Posture:
        wrenches = np.array(case["plate_wrenches"], dtype=float)
        wrenches[-1] += change
        posture = limb.solve(gravity=case["gravity"], plate_wrenches=wrenches, tolerance=1e-12, start=found)
        assert posture.success, posture.message
        return posture

    scale = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])  # [N], [N m]: steps move the tip by millimetres
    sharper = differences_of_the_tip(loaded, scale)
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            block = sharper[rows, columns]
            assert_allclose(found.compliance[rows, columns], block, rtol=0.0, atol=1e-7 * np.abs(block).max())


def case_of_stability(case: dict[str, Any]) -> tuple[sl.Limb, dict[str, Any], np.ndarray]:
    """The limb, the arguments of its solve, and the listed plates."""
    segments, wrenches, forces, below = [], [], [], 0.0
    gravity = np.zeros(3)
    for given in case["segments"]:
        rods, plate = given["rods"], given["plate"]
        weight = np.array(plate["weight"])
        mass = float(np.linalg.norm(weight))  # under a gravity of 1 m/s^2 along the weight, the same for all plates
        if mass > 0.0:
            gravity = weight / mass
        bases = np.array([rod["base_offset"] for rod in rods], dtype=float)
        bases[:, 2] -= below  # the file counts the plate's thickness in, a Segment does not
        below = 2.0 * plate["weight_height"]
        segments.append(
            sl.Segment(
                rods=[sl.Rod(section(rod), rod["rest_length"]) for rod in rods],
                base_frames=shifted(list(bases)),
                end_frames=shifted([rod["end_offset"] for rod in rods]),
                plate=sl.Plate(thickness=below, mass=mass),
            )
        )
        wrenches.append(plate["force"] + plate["moment"])
        forces += [rod["force_per_length"] for rod in rods]
    plates = np.array([pose(plate["position"], plate["rotation"]) for plate in case["plates"]])
    arguments: dict[str, Any] = {
        "gravity": gravity,
        "plate_wrenches": np.array(wrenches),
        "rod_forces": np.array(forces),
        "tolerance": 1e-9,
    }
    if case["plate_free_dofs"] is not None:
        arguments |= {"plate_poses": plates, "plate_held": ~np.array(case["plate_free_dofs"], dtype=bool)}
    return sl.Limb(segments), arguments, plates


# Poses of plates do not tell how the rods between them are bent, and Newton's basin around an equilibrium with many
# unstable modes is small: from these cases' plates it goes to another equilibrium. Case number, to what stands there.
NOT_REACHED_FROM_PLATES = {
    19: "starts with the centre rod straight: the equilibrium of case 18, whose plates are near",
    21: "starts with the centre rod straight: the equilibrium of case 20, whose plates are near",
    24: "the listed stable posture has every rod far from constant strain: Newton alone ends elsewhere",
    25: "25 unstable modes, rods buckled within: Newton's first 60 steps leave, a descent finds a stable posture",
    26: "4 unstable modes, rods buckled within: Newton's first 60 steps leave, a descent finds a stable posture",
}
STARTS_FROM_DESCENT = (19, 21, 24)  # stable ones among these, which a stable solve finds after all
NUMBER_OF_STABILITY_CASES = 30


@pytest.fixture(scope="module")
def stability(cases: Callable[[str], Any]) -> list[dict[str, Any]]:
    found = list(cases("stability").values())
    assert len(found) == NUMBER_OF_STABILITY_CASES
    return found


def assert_listed_equilibrium(found: sl.Posture, case: dict[str, Any], limb: sl.Limb, plates: np.ndarray) -> None:
    assert_trusted(found)
    for plate, given in zip(found.plates, plates, strict=True):
        # The listed equilibria agree between the file's two methods to about 1e-9 where they are weakly stable or not.
        assert np.linalg.norm(plate[:3, 3] - given[:3, 3]) <= 1e-8 * limb.length
        assert angle_between(plate[:3, :3], given[:3, :3]) <= 1e-8
    wrenches = [[rod.base_wrench for rod in row] for row in found.rods]
    assert_wrenches(
        [wrench for row in wrenches for wrench in row],
        [wrench for plate in case["plates"] for wrench in plate["rod_base_wrenches"]],
    )
    assert found.unstable_modes == case["unstable_modes"]
    assert found.stable == (case["unstable_modes"] == 0)


@pytest.mark.parametrize("number", sorted(set(range(NUMBER_OF_STABILITY_CASES)) - set(NOT_REACHED_FROM_PLATES)))
def test_unstable_modes_are_counted_as_in_the_reference(number: int, stability: list[dict[str, Any]]) -> None:
    case = stability[number]
    limb, arguments, plates = case_of_stability(case)
    found = limb.solve(**arguments, start=plates, prefer_stable=False)
    assert_listed_equilibrium(found, case, limb, plates)


@pytest.mark.parametrize("number", STARTS_FROM_DESCENT)
def test_stable_postures_of_the_reference_are_found_by_descent(number: int, stability: list[dict[str, Any]]) -> None:
    case = stability[number]
    limb, arguments, plates = case_of_stability(case)
    # From the plates, because a straight limb has a ring of stable postures around it and this is one of them.
    found = limb.solve(**arguments, start=plates)
    if number == 19 and found.tip[1, 3] < 0.0:
        # The thin rod may buckle to either side. Turned by half a turn about z: x and y change sign, and the rods at
        # either side their places, which carry the same.
        half = np.diag([-1.0, -1.0, 1.0])
        plates = plates.copy()
        plates[0, :3, 3] = half @ plates[0, :3, 3]
        plates[0, :3, :3] = half @ plates[0, :3, :3] @ half
        listed = case["plates"][0]["rod_base_wrenches"]
        turned = [[*(half @ wrench[:3]), *(half @ wrench[3:])] for wrench in listed]
        case = case | {"plates": [{"rod_base_wrenches": turned}]}
    assert_listed_equilibrium(found, case, limb, plates)


@pytest.mark.parametrize("number", sorted(NOT_REACHED_FROM_PLATES))
def test_a_start_that_leads_elsewhere_still_gives_an_equilibrium(number: int, stability: list[dict[str, Any]]) -> None:
    case = stability[number]
    limb, arguments, plates = case_of_stability(case)
    found = limb.solve(**arguments, start=plates, prefer_stable=False)
    assert_trusted(found)


# Columns and frames of the file that are unstable, each with a stable posture within reach.
UNSTABLE = (1, 3, 5, 6, 7, 8, 9, 11, 13, 15, 16, 17, 18, 20, 23)


@pytest.mark.parametrize("number", UNSTABLE)
def test_an_unstable_equilibrium_is_left_for_a_stable_posture_and_the_message_says_so(
    number: int, stability: list[dict[str, Any]]
) -> None:
    case = stability[number]
    limb, arguments, plates = case_of_stability(case)
    found = limb.solve(**arguments, start=plates)
    assert_trusted(found)
    assert found.stable
    assert found.unstable_modes == 0
    assert "unstable" in found.message
