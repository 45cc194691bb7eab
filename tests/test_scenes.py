"""Limbs and scenes as TOML: nothing changes on the way to a file and back, and every mistake is named."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import softlimb as sl
from softlimb import scenes
from softlimb.limb import Limb, Plate, Rod, Segment
from softlimb.presets import REFERENCE_SEGMENTS, reference_limb
from softlimb.scenes import Axis, Scene
from softlimb.tube import Fibres, Layer, Tube
from softlimb.units import kPa, mm

# Round trips must hold for any bits, so the numbers are not rounded to what people type.
moduli = st.floats(1e3, 1e7)
laws = st.one_of(
    st.builds(sl.NeoHookean, c1=moduli, density=st.floats(500.0, 2000.0), max_strain=st.floats(0.0, 5.0)),
    st.builds(sl.Yeoh, c1=moduli, c2=moduli, c3=moduli),
    st.builds(sl.MooneyRivlin, c10=moduli, c01=moduli),
    st.builds(sl.Gent, mu=moduli, jm=st.floats(1.0, 100.0)),
    st.lists(st.tuples(moduli, st.floats(0.5, 10.0)), min_size=1, max_size=3).map(
        lambda terms: sl.Ogden(mu=[m for m, _ in terms], alpha=[a for _, a in terms])
    ),
)
angles = st.floats(-1.5, 1.5)
fibres = st.one_of(
    st.builds(Fibres, angle=angles, stiffness=st.floats(1e3, 1e9)),
    st.builds(Fibres, angle=angles, modulus=st.floats(1e9, 1e11), fraction=st.floats(1e-4, 0.05)),
)


@st.composite
def tubes(draw: st.DrawFn) -> Tube:
    inner = draw(st.floats(1e-3, 3e-2))
    bounds = [inner]
    for _ in range(draw(st.integers(1, 3))):
        bounds.append(bounds[-1] + draw(st.floats(1e-4, 5e-3)))
    layers = [Layer(a, b, draw(laws), fibres=draw(st.lists(fibres, max_size=2))) for a, b in itertools.pairwise(bounds)]
    return Tube(
        length=draw(st.floats(0.05, 0.5)),
        layers=layers,
        tension_only=draw(st.booleans()),
        ends=draw(st.sampled_from(["free", "bonded"])),
        mass=draw(st.none() | st.floats(1e-3, 1.0)),
        cap_length=draw(st.just(0.0) | st.floats(1e-4, 0.02)),
    )


stiffnesses = st.floats(1e-3, 1e5)
rods = st.builds(
    Rod,
    st.builds(
        sl.Section,
        axial=stiffnesses,
        shear=stiffnesses,
        bending=stiffnesses,
        torsion=stiffnesses,
        mass_per_length=st.floats(0.0, 5.0),
        rest_twist=st.floats(-3.0, 3.0),
    ),
    st.floats(0.05, 0.5),
    st.none() | st.floats(1e-3, 0.05),
)


@st.composite
def frames(draw: st.DrawFn, count: int) -> np.ndarray:
    """Anywhere on the plate, turned by anything."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    for pose in poses:
        pose[:3, 3] = [draw(st.floats(-0.1, 0.1)) for _ in range(3)]
        axis = np.array([draw(st.floats(-1.0, 1.0)) for _ in range(3)])
        angle = float(np.linalg.norm(axis))
        if angle > 1e-3:
            x, y, z = axis / angle
            hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            pose[:3, :3] = np.eye(3) + math.sin(angle) * hat + (1.0 - math.cos(angle)) * hat @ hat
    return poses


@st.composite
def limbs(draw: st.DrawFn) -> Limb:
    segments = []
    for _ in range(draw(st.integers(1, 3))):
        count = draw(st.integers(1, 4))
        plate = Plate(thickness=draw(st.floats(0.0, 0.05)), mass=draw(st.floats(0.0, 1.0)))
        if draw(st.booleans()):
            parts = {"actuators": [draw(tubes())] * count}
        else:
            parts = {"rods": [draw(rods) for _ in range(count)]}
        if draw(st.booleans()):
            parts |= {"ring_radius": draw(st.floats(1e-3, 0.1))}
        else:
            parts |= {"base_frames": draw(frames(count)), "end_frames": draw(frames(count))}
        segments.append(Segment(plate=plate, **parts))
    return Limb(segments)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(limb=limbs())
def test_a_limb_comes_back_from_its_file_bit_for_bit(limb: Limb, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("limb") / "limb.toml"
    scenes.write_limb(limb, path)
    again = scenes.read_limb(path)
    assert again == limb
    for one, other in zip(limb.segments, again.segments, strict=True):
        assert np.array_equal(one.base_frames, other.base_frames)
        assert np.array_equal(one.end_frames, other.end_frames)


@pytest.mark.parametrize("model", ["tangent", "nonlinear", "paper"])
def test_rods_taken_from_a_tube_come_back_with_all_that_the_tube_knew(model: str, tmp_path: Path) -> None:
    tube = reference_limb().segments[1].actuators[0]
    rods = [Rod(tube.section(pressure, model=model), 0.25, 0.016) for pressure in (0.0, 30e3, 60e3)]
    limb = Limb([Segment(rods=rods, ring_radius=21 * mm)])
    scenes.write_limb(limb, tmp_path / "limb.toml")
    again = scenes.read_limb(tmp_path / "limb.toml")
    assert again == limb
    assert np.array_equal(again.solve(tip_force=(0.5, 0, 1)).tip, limb.solve(tip_force=(0.5, 0, 1)).tip)


def test_the_reference_limb_is_that_of_its_table() -> None:
    limb = reference_limb()
    assert limb.length == pytest.approx(0.65, rel=1e-12)
    mass = sum(sum(tube.mass for tube in s.actuators) + s.plate.mass for s in limb.segments)
    # 1.08 kg with the base plate, which is not part of the limb: 3 (98 + 52 + 23.5) g + 4 x 140 g = 1080.5 g
    assert mass + 0.14 == pytest.approx(1.0805, rel=1e-12)
    outer = [[tube.outer_radius for tube in s.actuators] for s in limb.segments]
    assert outer == [[21.5 * mm] * 3, [16.1 * mm] * 3, [10.75 * mm] * 3]
    # The radius reduction ratio: distal over proximal radius.
    assert limb.segments[2].ring_radius / limb.segments[0].ring_radius == pytest.approx(0.5)


def test_a_tube_may_be_given_by_its_winding() -> None:
    tube = {"length_mm": 200, "radii_mm": [9, 10.25, 10.75], "core": "dragon-skin-30", "skin": "dragon-skin-30"}
    tube |= {"thread_diameter_mm": 0.18, "pitch_mm": 3}
    segment = {"actuators": ["t", "t", "t"], "ring_radius_mm": 14}
    limb = scenes.limb_from_dict({"tubes": {"t": tube}, "segments": [segment]})
    law = sl.materials.get("dragon-skin-30")
    radii = (9 * mm, 10.25 * mm, 10.75 * mm)
    options = {"core": law, "skin": law, "thread_diameter": 0.18 * mm, "pitch": 3 * mm}
    assert limb.segments[0].actuators[0] == Tube.fibre_reinforced(200 * mm, radii=radii, **options)
    with pytest.raises(ValueError, match="by `layers` or by its winding"):
        scenes.limb_from_dict({"tubes": {"t": tube | {"layers": []}}, "segments": [segment]})


def test_single_segments_of_the_reference_limb_are_those_of_the_whole() -> None:
    whole = reference_limb()
    for j, name in enumerate(REFERENCE_SEGMENTS):
        assert reference_limb([name]).segments[0] == whole.segments[j]
    with pytest.raises(ValueError, match="no segment 'proximall'"):
        reference_limb(["proximall"])


def full_scene() -> Scene:
    rng = np.random.default_rng(5)
    pose = np.eye(4)
    pose[:3, 3] = [0.1, 0.02, 0.6]
    return Scene(
        limb=reference_limb(),
        pressures=rng.uniform(0.0, 9e4, 9),
        gravity=np.array([0.0, 0.1, 9.81]),
        tip_force=rng.normal(size=3),
        tip_moment=rng.normal(size=3),
        plate_wrenches=rng.normal(size=(3, 6)),
        rod_forces=tuple(rng.normal(size=(3, 3)) for _ in range(3)),
        rod_moments=tuple(rng.normal(size=(3, 3)) for _ in range(3)),
        tip_pose=pose,
        tip_held=(True, False, True, False, False, True),
        frame="plate",
        tolerance=1e-7,
        section="paper",
        valve="locked",
        prefer_stable=False,
        sweep_axes=(Axis((0.0, 0.5, 1.0)), Axis((1.0 * kPa, 3.3 * kPa), ((1, 1), (2, 3)))),
        title="all there is",
        description='quotes "inside", [brackets] and\ntwo lines',
    )


def test_a_scene_comes_back_from_its_file_bit_for_bit(tmp_path: Path) -> None:
    scene = full_scene()
    scene.to_toml(tmp_path / "scene.toml")
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert again.limb == scene.limb
    for name in (
        "pressures",
        "gravity",
        "tip_force",
        "tip_moment",
        "plate_wrenches",
        "tip_pose",
        "rod_forces",
        "rod_moments",
    ):
        assert np.array_equal(getattr(again, name), getattr(scene, name)), name
    for name in ("tip_held", "frame", "tolerance", "section", "valve", "prefer_stable", "sweep_axes", "title"):
        assert getattr(again, name) == getattr(scene, name), name
    assert again.description == scene.description


def test_the_example_in_the_documentation_is_a_scene_that_solves(tmp_path: Path) -> None:
    import softlimb.scenes.scene

    example = softlimb.scenes.scene.__doc__.partition("::\n")[2]
    (tmp_path / "scene.toml").write_text("\n".join(line[4:] for line in example.splitlines()), encoding="utf-8")
    scene = Scene.from_toml(tmp_path / "scene.toml")
    assert scene.sweep_pressures().shape == (26, 9)
    posture = scene.solve()
    assert posture.success
    np.testing.assert_allclose(posture.tip[:3, 3], [0.1, 0.0, 0.7], atol=1e-5)  # ten times the tolerance times 0.65 m


def test_the_example_of_a_limb_in_the_documentation_can_be_read() -> None:
    import softlimb.scenes.limb_file

    example = softlimb.scenes.limb_file.__doc__.partition("::\n")[2].rpartition("A material that")[0]
    text = "\n".join(line[4:] for line in example.splitlines())
    limb = scenes.limb_from_dict(_parsed(text))
    assert limb.segments[0].ring_radius == 28 * mm


def _parsed(text: str) -> dict:
    try:
        import tomllib
    except ModuleNotFoundError:
        import tomli as tomllib
    return tomllib.loads(text)


def test_a_limb_may_stand_in_a_file_beside_the_scene(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    scenes.write_limb(reference_limb(), tmp_path / "parts" / "limb.toml")
    (tmp_path / "scene.toml").write_text(
        "[limb]\nfile = 'parts/limb.toml'\n[scene]\npressures_kPa = [1,2,3,4,5,6,7,8,9]\n"
    )
    assert Scene.from_toml(tmp_path / "scene.toml").limb == reference_limb()


def test_pressures_may_be_flat_or_one_list_a_segment_in_any_unit() -> None:
    limb = {"preset": "reference-limb"}
    flat = Scene.from_dict({"limb": limb, "scene": {"pressures_Pa": [1000.0 * i for i in range(9)]}})
    rows = Scene.from_dict({"limb": limb, "scene": {"pressures_kPa": [[0, 1, 2], [3, 4, 5], [6, 7, 8]]}})
    assert np.array_equal(flat.pressures, rows.pressures)


def test_the_last_range_of_a_sweep_runs_fastest_and_pressures_overrule_factors() -> None:
    scene = Scene.from_dict(
        {
            "limb": {"preset": "reference-limb", "segments": ["middle"]},
            "scene": {
                "pressures_kPa": [10, 20, 30],
                "sweep": [{"factors": [0.5, 1.0]}, {"actuators": [[1, 3]], "from_kPa": 1, "to_kPa": 3, "points": 3}],
            },
        }
    )
    expected = [[5, 10, 1], [5, 10, 2], [5, 10, 3], [10, 20, 1], [10, 20, 2], [10, 20, 3]]
    np.testing.assert_allclose(scene.sweep_pressures(), np.array(expected) * kPa, rtol=1e-15)


PRESET = "[limb]\npreset = 'reference-limb'\n"
SEGMENT = "[[limb.segments]]\nactuators = ['a']\nring_radius_mm = 3\n"
TUBE = "[limb.tubes.a]\nlength_mm = 200\n"
LAYER = "[[limb.tubes.a.layers]]\ninner_radius_mm = 9\nouter_radius_mm = 11\nmaterial = 'dragon-skin-30'\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            PRESET + "[scene]\npresures_kPa = [1]",
            "unknown key `presures_kPa` in [scene]: did you mean `pressures_kPa`?",
        ),
        (PRESET + "[scene]\npressures = [1]", "key `pressures` in [scene] needs its unit in the name"),
        (PRESET + "[scene]\npressures_N = [1]", "`N` is not a unit of pressure"),
        (PRESET + "[scene]\npressures_kPa = 'a'", "`pressures_kPa` must be a number, got a string, 'a', in [scene]"),
        (PRESET + "[scene]\npressures_kPa = [true]", "must be a number, got a boolean"),
        (PRESET + "[scene]\npressures_kPa = [nan]", "must be finite, got nan"),
        (PRESET + "[scene]\npressures_MPa = [1e308]", "`pressures_MPa` is too large"),
        (PRESET + "[scene]\npressures_kPa = [1, 2]", "has 2 numbers, expected 9"),
        (PRESET + "[scene]\npressures_kPa = [[1], [2]]", "has [1, 1] numbers a segment, expected [3, 3, 3]"),
        (PRESET + "[scene]\npressures_kPa = [1, [2]]", "one list of numbers a segment"),
        (PRESET + "[scene]\npressures_kPa = [1]\npressures_Pa = [1]", "give the same thing"),
        (
            PRESET + "[scene]\npressures_kPa = [1,1,1,1,1,1,1,1,1]\ngravity_m_s2 = [0, 9.81]",
            "has shape (2,), expected (3,)",
        ),
        (PRESET + "[scene]\npressures_kPa = [1,1,1,1,1,1,1,1,1]\nframe = 'tip'", "must be one of 'base', 'plate'"),
        (PRESET + "[scene]\npressures_kPa = [1,1,1,1,1,1,1,1,1]\ntolerance = '1'", "`tolerance` must be a number"),
        (
            PRESET
            + "[scene]\npressures_kPa = [1,1,1,1,1,1,1,1,1]\n[[scene.plate_loads]]\nplate = 4\nforce_N = [0,0,1]",
            "`plate` must be within [1, 3]",
        ),
        (PRESET + "[[scene.sweep]]\nsegment = 4\nvalues_kPa = [1]", "`segment` must be within [1, 3]"),
        (PRESET + "[[scene.sweep]]\nactuators = [[1, 4]]\nvalues_kPa = [1]", "`actuators` lists [1, 4]"),
        (PRESET + "[[scene.sweep]]\nsegment = 1\nfrom_kPa = 0\nto_kPa = 1\npoints = 1", "`points` must be within"),
        (PRESET + "[[scene.sweep]]\nsegment = 1\nfrom_kPa = 0\nto_kPa = 1", "missing key `points`"),
        (PRESET + "[[scene.sweep]]\nsegment = 1\nfactors = [1]", "takes neither actuators nor pressures"),
        ("[limb]\npreset = 'reference-lim'", "unknown preset 'reference-lim': did you mean 'reference-limb'?"),
        ("[limb]\npreset = 'reference-limb'\nsegments = ['tip']", "no segment 'tip'"),
        ("[limb]\nfile = 'no.toml'", "there is no file"),
        ("[scene]\n", "missing table [limb]"),
        ("[limb]\n", "at least one table `[[segments]]`"),
        ("[limb\n", "is not valid TOML"),
        ("limb = 3", "`limb` must be a table"),
        (SEGMENT, "there is no table [tubes.a]"),
        (TUBE.replace("200", "'x'") + SEGMENT, "`length_mm` must be a number, got a string, 'x', in [limb.tubes.a]"),
        (TUBE.replace("200", "-1") + LAYER + SEGMENT, "[limb.tubes.a]"),
        (TUBE + LAYER.replace("= 9", "= 12") + SEGMENT, "[limb.tubes.a"),
        (TUBE + LAYER.replace("'dragon", "'dragoon") + SEGMENT, "material 'dragoon-skin-30'"),
        (TUBE + LAYER.replace("inner_radius", "iner_radius") + SEGMENT, "did you mean `inner_radius_mm`?"),
        (TUBE + LAYER + SEGMENT.replace("ring_radius_mm = 3", ""), "placed either by `ring_radius_mm`"),
        (
            "[limb.materials.m]\nlaw = 'yeoh'\nc1_kPa = 1\n" + SEGMENT,
            "takes the coefficients c1, c2, c3; given: `c1_kPa`",
        ),
        ("[limb.materials.m]\nlaw = 'yeo'\n" + SEGMENT, "`law` must be one of"),
        ("[limb.materials.m]\nlaw = 'neo-hooke'\nc1_kPa = -1\n" + SEGMENT, "[limb.materials.m]"),
        ("[limb.materials.m]\nlaw = 'neo-hooke'\nc1 = 1\n" + SEGMENT, "key `c1` in [limb.materials.m] needs its unit"),
    ],
)
def test_a_mistake_in_a_scene_is_named_with_its_table(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((ValueError, FileNotFoundError)) as caught:
        Scene.from_toml(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_scene_may_be_loads_alone_but_is_not_solved_without_pressures() -> None:
    scene = Scene.from_dict({"limb": {"preset": "reference-limb"}, "scene": {"gravity_m_s2": [0, 0, 9.81]}})
    with pytest.raises(ValueError, match="no pressures: add `pressures_kPa`"):
        scene.solve()


def test_a_missing_scene_lists_what_there_is() -> None:
    with pytest.raises(FileNotFoundError, match="did you mean `complex-posture`"):
        scenes.load_scene("comlex-posture")


@pytest.mark.parametrize("name", scenes.available_scenes())
def test_the_scenes_of_the_package_load_and_say_what_is_theirs(name: str) -> None:
    scene = scenes.load_scene(name)
    assert scene.title
    assert scene.sweep_axes
    assert np.array_equal(scene.gravity, [0.0, 0.0, 9.81])


def test_the_papers_four_experiments_are_there() -> None:
    assert set(scenes.available_scenes()) >= {"bend-1", "bend-2", "complex-posture", "elongation-proximal"}
    expected = np.array([90, 60, 30, 60, 40, 20, 50, 50, 50]) * kPa
    assert np.array_equal(scenes.load_scene("complex-posture").pressures, expected)


def test_two_ranges_of_one_actuator_are_refused_by_its_name() -> None:
    limb = {"preset": "reference-limb"}
    one, two = {"actuators": [[1, 2], [2, 1]], "values_kPa": [1, 2]}, {"segment": 1, "values_kPa": [3]}
    with pytest.raises(ValueError, match=r"actuator \[1, 2\] is in ranges 1 and 2 of the sweep"):
        Scene.from_dict({"limb": limb, "scene": {"sweep": [one, two]}})
    with pytest.raises(ValueError, match=r"actuator \[2, 1\] is twice in range 1"):
        Scene(limb=reference_limb(), sweep_axes=(Axis((1.0,), ((2, 1), (2, 1))),))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[limb.materials.m]\nlaw = 'yeoh'\nc1_MPa = [1.0]\n" + SEGMENT,
            "`c1_MPa` must be a number, got a list, in [limb.materials.m]",
        ),
        (
            TUBE + LAYER + SEGMENT.replace("['a']", "[1.0]"),
            "`actuators` must be a list of strings, but holds a number, 1.0, in [limb.segments",
        ),
        (
            PRESET + "[scene.held_tip]\nposition_mm = [0, 0, 700]\nfreedoms = ['x', 'x']\n",
            "`freedoms` lists 'x' 2 times",
        ),
    ],
)
def test_a_value_of_a_wrong_type_or_given_twice_is_named(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        Scene.from_toml(tmp_path / "scene.toml")
    assert message in str(caught.value)


def test_a_scene_without_a_limb_is_refused() -> None:
    with pytest.raises(ValueError, match="limb must be a Limb, got None"):
        Scene(limb=None)


def test_a_reloaded_scene_equals_the_original(tmp_path: Path) -> None:
    for name, scene in (("full", full_scene()), ("bare", Scene(limb=reference_limb()))):
        scene.to_toml(tmp_path / f"{name}.toml")
        again = Scene.from_toml(tmp_path / f"{name}.toml")
        assert again == scene
        assert hash(again) == hash(scene)
        assert again.replaced(tip_force=np.array([9.0, 0.0, 0.0])) != scene
        assert again.replaced(pressures=np.ones(9)) != scene


def test_factors_that_make_a_pressure_infinite_are_refused() -> None:
    scene = scenes.load_scene("complex-posture").replaced(sweep_axes=(Axis((1.0, 1e308)),))
    with pytest.raises(ValueError, match=r"factors of a sweep must leave pressures finite, got 1e\+308"):
        scene.sweep_pressures()
