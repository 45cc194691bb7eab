"""The workspace: known shapes and their volumes, a cloud that settles, symmetry, and what is refused."""

from __future__ import annotations

import itertools
import math
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import softlimb as sl
from frames import pose, turn
from softlimb import plot
from softlimb.cli import main
from softlimb.design import DesignFailure, PressureSet, WorkspaceVolume
from softlimb.presets import reference_limb
from softlimb.units import kPa, mm
from softlimb.workspace import PUBLISHED, Workspace, beside_published
from softlimb.workspace.edges import directions
from softlimb.workspace.samples import pressure_samples
from softlimb.workspace.voxels import cells_of, occupancy
from sweep_examples import same_bits, small_limb

HANGING = (0.0, 0.0, 9.81)


def workspace_of(limb, pressures, **scene):
    return Workspace(limb.sweep(pressures, progress=False, **scene))


@pytest.fixture(scope="module")
def cloud():
    """The reference limb, unloaded; two seconds."""
    return reference_limb().workspace(max_pressure=80 * kPa, samples=4000, progress=False, edge_directions=10)


# --- pressures ------------------------------------------------------------------------------------------------------


def test_halton_pressures_fill_every_part_of_each_axis_evenly():
    # The radical inverse in base b puts one of b**k successive points into each b**k-th part, scrambled or not.
    places = pressure_samples(np.zeros(4), np.ones(4), 7**4, sampling="halton", seed=3, at_bounds=0.0)
    for axis, base in enumerate((2, 3, 5, 7)):
        parts = base ** int(math.log(7**4, base) + 1e-9)
        counts = np.bincount((places[:parts, axis] * parts).astype(int), minlength=parts)
        assert_array_equal(counts, 1)


def test_more_samples_go_on_where_fewer_stopped_and_a_seed_decides():
    low, high = np.zeros(3), np.full(3, 60e3)
    for sampling in ("halton", "uniform"):
        few = pressure_samples(low, high, 50, sampling=sampling, seed=5, at_bounds=0.3)
        many = pressure_samples(low, high, 100, sampling=sampling, seed=5, at_bounds=0.3)
        assert_array_equal(few, many[:50])
        other = pressure_samples(low, high, 50, sampling=sampling, seed=6, at_bounds=0.3)
        assert (few != other).any()


def test_a_share_of_the_pressures_is_at_bounds_exactly_and_the_rest_is_even():
    low, high = np.array([0.1e3, 3e3]), np.array([70.3e3, 50e3])
    rows = pressure_samples(low, high, 6000, sampling="uniform", seed=1, at_bounds=0.4)
    at = (rows == low) | (rows == high)
    # binomial: 0.4 of 6000, standard deviation 38; 5 of them
    assert (np.abs(at.sum(axis=0) - 2400) < 190).all()
    inside = (rows[~at[:, 0], 0] - low[0]) / (high[0] - low[0])
    assert abs(inside.mean() - 0.5) < 5.0 / math.sqrt(12.0 * len(inside))  # of an even spread
    assert ((rows >= low) & (rows <= high)).all()


def test_a_grid_has_all_combinations_of_its_levels():
    rows = pressure_samples(np.zeros(2), np.array([1.0, 10.0]), 15, sampling="grid", seed=0, at_bounds=0.5)
    assert_array_equal(rows, [[a, b] for a in (0.0, 0.5, 1.0) for b in (0.0, 5.0, 10.0)])


# --- volumes of known clouds ----------------------------------------------------------------------------------------


def test_cells_count_points_and_know_their_neighbours():
    points = np.array([*itertools.product([0.5, 1.5, 2.5], repeat=3), [1.2, 1.7, 1.9], [-7.5, 0.5, 0.5]])
    cells = cells_of(points, 1.0)
    assert len(cells.counts) == 28
    assert cells.counts.sum() == len(points)
    middle = np.flatnonzero((cells.index == 1).all(axis=1))
    assert_array_equal(np.flatnonzero(cells.inside), middle)
    assert cells.counts[middle] == 2
    assert_array_equal(cells.centres[cells.of_point[-1]], [-7.5, 0.5, 0.5])


@pytest.mark.parametrize("seed", range(5))
def test_the_bracket_holds_the_volume_of_a_ball_and_of_a_hollow_one(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(20_000, 3))
    points *= (rng.random(len(points)) ** (1 / 3) / np.linalg.norm(points, axis=1))[:, None]
    for inner in (0.0, 0.7):
        shell = points[np.linalg.norm(points, axis=1) >= inner]
        found, true = occupancy(shell), 4.0 / 3.0 * math.pi * (1.0 - inner**3)
        assert found.lower < true < found.upper
        assert abs(found.size - true) < found.error
        # a voxel at the edge is half full on average: the middle is better than the bracket says
        assert found.error < 0.6 * true


def test_the_error_of_a_volume_shrinks_with_the_number_of_points():
    points = np.random.default_rng(2).random((64_000, 3))
    errors = [occupancy(points[:count]).error for count in (1_000, 8_000, 64_000)]
    assert errors[2] < errors[1] < errors[0]


def test_flat_clouds_have_no_volume_within_their_error():
    rng = np.random.default_rng(3)
    plane = np.column_stack([rng.random((5000, 2)), np.full(5000, 0.3)])
    for points in (plane, np.full((40, 3), 0.2), plane[:1]):
        found = occupancy(points)
        assert found.lower == 0.0 and found.size <= found.error * (1.0 + 1e-15)  # rounding of the half sum
    assert math.isnan(occupancy(plane[:0]).size)  # of nothing, nothing is known


def test_the_estimate_of_unseen_cells_is_chaos_and_no_less_than_those_hit_once():
    # Chao 1984, bias-corrected: f1 (f1 - 1) / (2 (f2 + 1))
    places = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 7.5, 7.6]
    found = occupancy(np.array(places)[:, None], 1.0)
    assert (found.once, found.twice, found.occupied) == (6, 1, 7)
    assert found.unseen == 6 * 5 / (2 * 2) and not found.dense
    found = occupancy(np.array([0.5, 1.5, 1.6])[:, None], 1.0)
    assert (found.once, found.twice, found.unseen) == (1, 1, 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_twice_as_many_points_add_no_more_cells_than_were_hit_once(seed):
    # Of a cell with l points in the mean: e^-l (1 - e^-l) is new in the second half, l e^-l was hit once in the first.
    # Points that crowd in the middle, as tips do: sums of three even numbers.
    points = np.random.default_rng(seed).random((8000, 3, 3)).sum(axis=2)
    few, many = occupancy(points[:4000], 0.1), occupancy(points, 0.1)
    new = many.occupied - few.occupied
    assert 0.3 * few.once < new <= few.once + 4.0 * math.sqrt(few.once)  # four standard deviations of a count
    assert many.occupied < few.occupied + few.unseen


def test_the_hull_of_a_box_of_tips_is_the_box():
    pytest.importorskip("scipy")
    batch = small_limb().sweep(np.zeros((40, 3)), progress=False)
    rng = np.random.default_rng(0)
    corners = np.array(list(itertools.product([0.0, 0.2], [0.0, 0.3], [0.1, 0.5])))
    batch.tip[:, :3, 3] = np.concatenate([corners, rng.uniform([0, 0, 0.1], [0.2, 0.3, 0.5], (32, 3))])
    found = Workspace(batch)
    assert_allclose(found.hull_volume, 0.2 * 0.3 * 0.4, rtol=1e-12)  # rounding
    assert_allclose(found.extents, [0.2, 0.3, 0.4], rtol=1e-15)
    assert_allclose(found.reach, math.sqrt(0.2**2 + 0.3**2 + 0.5**2), rtol=1e-15)
    batch.tip[:, 2, 3] = 0.1
    assert Workspace(batch).hull_volume == 0.0
    with pytest.raises(DesignFailure, match="enclose no volume"):
        WorkspaceVolume(PressureSet(55 * kPa))._of_tips(batch.tip, slopes=False)


def test_hulls_without_scipy_say_how_to_get_it(monkeypatch):
    batch = small_limb().sweep(np.zeros((4, 3)), progress=False)
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)  # an import of it fails as if it were not there
    for ask in (
        lambda: Workspace(batch).hull_volume,
        lambda: WorkspaceVolume(PressureSet(55 * kPa))._of_tips(batch.tip, slopes=False),
    ):
        with pytest.raises(ModuleNotFoundError, match=r"needs scipy: pip install 'softlimb\[workspace\]'"):
            ask()


# --- workspaces of known limbs --------------------------------------------------------------------------------------


def test_equal_pressures_move_the_tip_along_a_line_of_known_length():
    limb = small_limb()
    tube = limb.segments[0].actuators[0]
    pressures = np.linspace(0.0, 55 * kPa, 40)
    found = workspace_of(limb, np.repeat(pressures[:, None], 3, axis=1))
    # The tube alone at no load says how long: the workspace is the segment between its lengths, to the tolerance.
    ends = [tube.length * tube.inflate(p).stretch for p in (0.0, 55 * kPa)]
    assert_allclose(found.box, [[0.0, 0.0, ends[0]], [0.0, 0.0, ends[1]]], atol=1e-6 * limb.length)
    assert_allclose(found.reach, ends[1], atol=1e-6 * limb.length)
    assert found.tilt_range[1] < 1e-6 and found.volume.lower == 0.0


def test_two_tubes_move_the_tip_on_the_arcs_of_constant_curvature():
    # A pair of tubes bends in its plane; without load each tube has one curvature, so that the tip's place follows from
    # its tilt and the plane's middle length s alone: x = s (1 - cos t) / t, z = s sin(t) / t.
    tube = reference_limb().segments[0].actuators[0]
    limb = sl.Limb([sl.Segment(actuators=[tube] * 2, ring_radius=28 * mm)])
    found = limb.workspace(max_pressure=60 * kPa, samples=300, edge_directions=0, progress=False)
    assert len(found) == 300
    # The plane holds x and z, and nothing leaves it.
    assert np.abs(found.positions[:, 1]).max() < 1e-6 * limb.length
    x, _, z = found.positions.T
    # x / z = tan(t / 2) of an arc that starts along z
    assert_allclose(2.0 * np.arctan2(np.abs(x), z), found.tilt, atol=1e-5)  # ten times the tolerance
    assert found.volume.lower == 0.0
    pytest.importorskip("scipy")
    assert found.hull_volume < 1e-6 * limb.length**3


def test_rotating_base_and_gravity_together_rotates_the_cloud():
    # Rods on a turned ring under turned gravity are the same limb seen from another frame.
    limb, rotation = reference_limb(["middle"]), turn([0.0, 0.0, 0.7])
    segment = limb.segments[0]
    turned = sl.Limb(
        [
            sl.Segment(
                actuators=segment.actuators,
                base_frames=pose(rotation=rotation) @ segment.base_frames,
                end_frames=pose(rotation=rotation) @ segment.end_frames,
                plate=segment.plate,
            )
        ]
    )
    pressures = pressure_samples(np.zeros(3), np.full(3, 60e3), 200, sampling="halton", seed=1, at_bounds=0.5)
    gravity = np.array([2.0, 1.0, 9.0])
    one = workspace_of(limb, pressures, gravity=gravity)
    other = workspace_of(turned, pressures, gravity=rotation @ gravity)
    atol = 1e-5 * limb.length  # ten times the tolerance of each
    assert_allclose(other.positions, one.positions @ rotation.T, atol=atol)
    assert_allclose(other.tilt, one.tilt, atol=1e-5)
    assert_allclose(other.reach, one.reach, atol=atol)
    if pytest.importorskip("scipy"):
        # the hull moves with its points: relative change three times theirs
        assert_allclose(other.hull_volume, one.hull_volume, rtol=1e-3)


def test_a_workspace_does_not_know_the_order_of_its_rows():
    limb = small_limb()
    pressures = np.random.default_rng(4).uniform(0.0, 60e3, (300, 3))
    order = np.random.default_rng(5).permutation(300)
    one, other = workspace_of(limb, pressures), workspace_of(limb, pressures[order])
    assert_array_equal(other.box, one.box)
    assert other.volume == one.volume
    assert_array_equal(other.regions().counts, one.regions().counts)


# --- the reference limb ---------------------------------------------------------------------------------------------


def test_the_cloud_is_what_the_sweep_found(cloud):
    assert len(cloud.batch) == cloud.samples + cloud.edge_rows and cloud.samples == 4000 and cloud.edge_rows > 6
    assert cloud.message.startswith(f"{len(cloud)} of {len(cloud.batch)} postures count")
    row = cloud.rows[17]
    posture = cloud.batch.limb.solve(cloud.batch.pressures[row])
    assert_array_equal(cloud.positions[17], posture.tip[:3, 3])
    low, high = cloud.pressure_range
    assert_array_equal(low, 0.0)
    assert_array_equal(high, 80 * kPa)


def test_the_stated_error_covers_what_twice_as_many_postures_change(cloud):
    for samples in (500, 1000, 2000):
        few, many = cloud.first(samples).volume, cloud.first(2 * samples).volume
        assert abs(many.size - few.size) < few.error
        assert few.lower < many.upper and many.lower < few.upper
    # and with the same voxels
    for samples in (500, 1000, 2000):
        few = cloud.first(samples).voxel_volume(cloud.volume.cell)
        many = cloud.first(2 * samples).voxel_volume(cloud.volume.cell)
        assert few.lower <= many.lower <= many.size < few.upper


def test_box_and_hull_only_grow_and_settle(cloud):
    pytest.importorskip("scipy")
    parts = [cloud.first(samples) for samples in (500, 1000, 2000, 4000)]
    for few, many in itertools.pairwise([*parts, cloud]):
        assert (many.box[0] <= few.box[0]).all() and (many.box[1] >= few.box[1]).all()
        assert many.hull_volume >= few.hull_volume * (1.0 - 1e-12)  # rounding
    growth = [many.hull_volume / few.hull_volume for few, many in itertools.pairwise(parts)]
    assert growth[-1] < growth[0]


def test_the_search_for_the_edge_finds_what_samples_miss(cloud):
    samples = cloud.first(cloud.samples)
    assert (cloud.extents > samples.extents + 1e-3).any()
    edge = cloud.batch.pressures[cloud.samples :]
    assert ((edge >= 0.0) & (edge <= 80 * kPa)).all()
    along = directions(10)
    assert_allclose(np.linalg.norm(along, axis=1), 1.0, rtol=1e-12)
    support = (cloud.positions @ along.T).max(axis=0) - (samples.positions @ along.T).max(axis=0)
    assert (support >= 0.0).all() and support.max() > 10 * mm


def test_exploring_fills_what_even_pressures_leave_thin(cloud):
    even = cloud.batch.limb.workspace(
        max_pressure=80 * kPa, samples=cloud.samples, progress=False, edge_directions=0, explore=0.0
    )
    # The same rows first; each sweep surveys some of its own, so postures agree to the tolerance of both.
    one, other = even.batch.head(1000), cloud.batch.head(1000)
    assert_array_equal(one.pressures, other.pressures)
    assert_allclose(one.tip, other.tip, rtol=0.0, atol=2e-6)
    explored, spread = (found.voxel_volume(0.08) for found in (cloud.first(cloud.samples), even))
    # more than chance: four standard deviations of the cells that one more posture could change
    assert explored.occupied > spread.occupied + 4.0 * math.sqrt(spread.once)
    assert explored.lower > spread.lower


def test_reach_confirms_the_volume():
    """Of one segment, whose workspace is so thin that voxels say little."""
    found = reference_limb(["middle"]).workspace(max_pressure=60 * kPa, samples=3000, progress=False)
    asked = found.volume_by_reach(60, seed=2)
    assert asked.points == 60 and 0 < asked.reached < 60
    voxels = found.volume
    assert voxels.lower - 3.0 * asked.standard_error < asked.value < voxels.upper + 3.0 * asked.standard_error
    assert asked.value < float(np.prod(found.extents))


def test_regions_hold_the_density_and_the_tilt_of_their_tips(cloud):
    regions = cloud.regions(0.1)
    assert regions.counts.sum() == len(cloud)
    assert_allclose((regions.density * regions.cell**3).sum(), 1.0, rtol=1e-12)
    fullest = int(np.argmax(regions.counts))
    inside = (np.abs(cloud.positions - regions.centres[fullest]) < 0.05).all(axis=1)
    assert inside.sum() == regions.counts[fullest]
    assert (regions.tilt_min[fullest], regions.tilt_max[fullest]) == (
        cloud.tilt[inside].min(),
        cloud.tilt[inside].max(),
    )
    mean = cloud.axes[inside].sum(axis=0)
    angles = np.arccos(np.clip(cloud.axes[inside] @ mean / np.linalg.norm(mean), -1.0, 1.0))
    assert_allclose(regions.spread[fullest], angles.max(), atol=1e-7)  # of the arc cosine
    assert regions.spread.max() <= math.pi


def test_a_slice_has_the_tips_of_its_slab(cloud):
    part = cloud.slice("x", 0.1, thickness=0.06)
    tips = cloud.batch.tip[part.rows, :3, 3]
    assert len(part.rows) == (np.abs(cloud.positions[:, 0] - 0.1) <= 0.03).sum() > 0
    assert_array_equal(part.points, tips[:, 1:])
    assert part.area.dimensions == 2 and part.area.lower <= part.area.size <= part.area.upper
    assert cloud.slice().at == pytest.approx(cloud.box[:, 2].mean())
    empty = cloud.slice("z", 5.0)
    assert len(empty.rows) == 0 and empty.area.size == 0.0


# --- failures -------------------------------------------------------------------------------------------------------


def test_rows_that_fail_or_fall_over_do_not_count_and_are_named():
    batch = small_limb().sweep(np.full((6, 3), 20e3), progress=False)
    batch.success[1] = batch.stable[1] = False
    batch.tip[1] = np.nan
    batch.stable[2] = False
    batch.clearance[3:5] = [-1e-3, 2e-3]
    found = Workspace(batch)
    assert_array_equal(found.rows, [0, 3, 4, 5])
    assert (found.failed, found.unstable, found.touching) == (1, 1, 1)
    assert "1 failed (row 1" in found.message and "1 are not stable" in found.message
    assert "tubes touch in 1" in found.message
    apart = Workspace(batch, min_clearance=5 * mm)
    assert_array_equal(apart.rows, [0, 5])
    assert "2 have tubes nearer than 5 mm" in apart.message and "touch" not in apart.message


def test_a_workspace_without_a_posture_says_so_and_has_no_size():
    batch = small_limb().sweep(np.full((4, 3), 20e3), progress=False)
    batch.success[:] = False
    found = Workspace(batch)
    assert len(found) == 0 and found.message.startswith("0 of 4 postures count; 4 failed")
    assert np.isnan(found.box).all() and math.isnan(found.reach) and math.isnan(found.tilt_range[0])
    assert math.isnan(found.volume.size) and math.isnan(found.volume.error) and math.isnan(found.hull_volume)
    assert "an empty workspace has no size" in found.message and len(found.regions().counts) == 0
    with pytest.raises(ValueError, match="an empty workspace has no slice: 0 of 4 postures count"):
        found.slice("z")
    with pytest.raises(ValueError, match="empty workspace"):
        found.volume_by_reach(3)


def test_bounds_end_just_short_of_where_an_actuator_balloons():
    limb = reference_limb()
    limits = [tube.inflate(1e9).limit_pressure for tube in limb._tubes]  # stiff fibres: known only from beyond
    found = limb.workspace(max_pressure=1e9, samples=20, edge_directions=0, progress=False)
    assert len(found) > 0
    assert (found.pressure_range[1] < limits).all()
    assert found.pressure_range[1].max() == pytest.approx(max(limits), rel=0.1)  # half of the pressures are at bounds
    far = limb.reach(position=(0.0, 0.0, 10.0), max_pressure=1e9)  # m, out of reach
    assert far.max_pressures == pytest.approx(limits, rel=2e-3)
    assert "actuator 0 carries no more than" in far.message


def test_the_standing_limb_loses_what_its_weight_topples():
    # Unpressurised and upright the reference limb is unstable; what a descent finds in its place counts.
    found = reference_limb().workspace(
        max_pressure=30 * kPa, samples=64, gravity=(0, 0, -9.81), progress=False, edge_directions=0
    )
    assert found.failed + found.unstable + len(found) == 64
    assert found.batch.stable[found.rows].all()


# --- files ----------------------------------------------------------------------------------------------------------


def test_a_workspace_comes_back_from_its_file_and_a_file_goes_on(tmp_path):
    limb, file = small_limb(), tmp_path / "rows.sweep"
    asked = {"max_pressure": 50 * kPa, "samples": 80, "gravity": HANGING, "progress": False, "edge_directions": 4}
    found = limb.workspace(**asked, file=file)
    assert same_bits(sl.Batch.load(file), found.batch.head(20))
    parts = sorted(tmp_path.iterdir())
    assert [len(sl.Batch.load(part)) for part in parts] == [20, 8, 8, 8, 8, 7, 7, 7, 7]
    parts[-1].unlink()  # as if it had been killed before the last round
    again = limb.workspace(**asked, file=file)
    assert same_bits(again.batch, found.batch)
    found.save(tmp_path / "all.sweep")
    read = Workspace.load(tmp_path / "all.sweep", edge_rows=found.edge_rows)
    assert same_bits(read.batch, found.batch)
    assert read.volume == found.volume and read.message == found.message
    with pytest.raises(ValueError, match="holds other pressures"):
        limb.workspace(**asked | {"seed": 1}, file=file)


def test_threads_do_not_change_a_bit_and_another_seed_does():
    limb = small_limb()
    asked = {"max_pressure": 50 * kPa, "samples": 60, "progress": False, "edge_directions": 4}
    one, two = limb.workspace(**asked, threads=1), limb.workspace(**asked, threads=2)
    assert same_bits(one.batch, two.batch)
    assert (limb.workspace(**asked, seed=1).batch.pressures[:60] != one.batch.pressures[:60]).any()


def test_the_dataset_tells_which_rows_count(cloud):
    pytest.importorskip("xarray")
    data = cloud.to_xarray()
    assert int(data.counts.sum()) == len(cloud)
    assert data.attrs["voxel_m"] == cloud.volume.cell and data.tip_position.attrs["units"] == "m"


# --- bad input ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"max_pressure": -1.0}, "min_pressure must not exceed max_pressure"),
        ({"min_pressure": 90e3}, "min_pressure must not exceed max_pressure"),
        ({"max_pressure": float("nan")}, "max_pressure must be finite"),
        ({"max_pressure": [1e3, 2e3]}, "max_pressure"),
        ({"max_pressure": "much"}, "max_pressure must be"),
        ({"samples": 0}, "samples must be a whole number of at least 1, got 0"),
        ({"samples": 10.5}, "samples must be a whole number"),
        ({"samples": True}, "samples must be a whole number"),
        ({"seed": -1}, "seed must be a whole number of at least 0"),
        ({"sampling": "sobol"}, 'sampling must be one of "halton", "uniform", "grid"'),
        ({"sampling": "grid", "samples": 7, "explore": 0.0}, "samples must be at least 8 for a grid"),
        ({"sampling": "grid", "samples": 20}, "got 20, of which explore=0.75 leaves 5 to the grid"),
        ({"at_bounds": 1.0}, r"at_bounds must be within \[0, 1\)"),
        ({"at_bounds": float("nan")}, r"at_bounds must be within \[0, 1\)"),
        ({"explore": 1.0}, r"explore must be within \[0, 1\)"),
        ({"explore": "much"}, "explore must be a number"),
        ({"edge_directions": -1}, "edge_directions must be a whole number"),
        ({"min_clearance": float("nan")}, "min_clearance must be finite"),
        ({"gravity": (0.0, 9.81)}, "gravity"),
        ({"threads": 0}, "threads must be a whole number"),
    ],
)
def test_bad_arguments_raise_and_are_named(change, match):
    asked = {"max_pressure": 50e3, "samples": 8, "progress": False, "edge_directions": 0} | change
    with pytest.raises(ValueError, match=match):
        small_limb().workspace(**asked)


def test_unknown_options_and_limbs_of_rods_are_refused():
    with pytest.raises(TypeError, match="gravitty"):
        small_limb().workspace(max_pressure=50e3, samples=8, gravitty=(0, 0, 9.81), progress=False)
    with pytest.raises(TypeError, match="ordered"):
        small_limb().workspace(max_pressure=50e3, samples=8, ordered=True, progress=False)
    rod = sl.Rod(sl.Section(axial=1e3, shear=1e3, bending=0.1, torsion=0.1), 0.2)
    rods = sl.Limb([sl.Segment(rods=[rod] * 3, ring_radius=0.02)])
    with pytest.raises(ValueError, match="no actuators"):
        rods.workspace(max_pressure=50e3)


def test_bad_questions_to_a_workspace_raise(cloud):
    with pytest.raises(ValueError, match='axis must be one of "x", "y", "z"'):
        cloud.slice("w")
    with pytest.raises(ValueError, match="thickness must be finite and positive"):
        cloud.slice("x", thickness=0.0)
    with pytest.raises(ValueError, match="at must be finite"):
        cloud.slice("x", float("nan"))
    for cell in (0.0, -0.1, float("inf")):
        with pytest.raises(ValueError, match="cell must be finite and positive"):
            cloud.voxel_volume(cell)
    with pytest.raises(ValueError, match="at least a millionth"):
        cloud.voxel_volume(1e-12)
    with pytest.raises(ValueError, match="samples must be at most 4000"):
        cloud.first(4001)
    with pytest.raises(ValueError, match="points must be a whole number"):
        cloud.volume_by_reach(0)
    with pytest.raises(ValueError, match="edge_rows must be at most"):
        Workspace(cloud.batch, 10**6)
    with pytest.raises(TypeError, match="batch must be a Batch"):
        Workspace(cloud.positions)
    with pytest.raises(ValueError, match="same"):
        cloud.batch.followed_by(small_limb().sweep(np.zeros((1, 3)), progress=False))


# --- pictures and the command ---------------------------------------------------------------------------------------


def words_of(figure):
    """Labels of all axes, titles of the figure and its axes."""
    axes = [ax for ax in figure.axes if ax.get_visible()]
    labels = [label for ax in axes for label in (ax.get_xlabel(), ax.get_ylabel()) if label]
    return labels, [ax.get_title() for ax in axes]


def test_the_picture_has_units_equal_scales_and_hangs_where_the_limb_does(cloud, tmp_path):
    figure = plot.workspace(cloud)
    labels, titles = words_of(figure)
    assert all(label.endswith("]") or label == "postures in a column" for label in labels), labels
    assert sum("m²" in title for title in titles) == 3
    figure.savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000
    flat = [ax for ax in figure.axes if ax.get_xlabel().startswith("tip")]
    assert len(flat) == 5 and all(ax.get_aspect() == 1.0 for ax in flat)
    assert not any(ax.yaxis_inverted() for ax in flat)
    hanging = workspace_of(small_limb(), np.diag([20e3, 30e3, 40e3]), gravity=HANGING)
    turned = [ax.yaxis_inverted() for ax in plot.workspace(hanging).axes if ax.get_xlabel().startswith("tip")]
    assert turned == [True, True, False, False, False]  # two views from the side, three slices from above


def test_every_tip_is_in_the_density_picture(cloud):
    figure = plot.workspace(cloud)
    meshes = [ax.collections[0].get_array() for ax in figure.axes if ax.get_title().startswith("density")]
    assert [int(mesh.sum()) for mesh in meshes] == [len(cloud)] * 2


def test_a_slice_of_very_many_tips_is_drawn_with_its_steepest(cloud, monkeypatch):
    monkeypatch.setattr(sys.modules["softlimb.plot.workspace"], "_DRAWN", 40)
    figure = plot.workspace(cloud)
    low, high = cloud.box[:, 2]
    for number, ax in enumerate([ax for ax in figure.axes if "m²" in ax.get_title()], start=1):
        shown = np.asarray(ax.collections[0].get_array())
        part = cloud.slice("z", low + 0.25 * number * (high - low))
        tilt = np.rad2deg(cloud.tilt[np.searchsorted(cloud.rows, part.rows)])
        assert len(shown) == 40 < len(tilt) and (np.diff(shown) >= 0.0).all()
        # the median of 40 drawn evenly leaves this range less often than once in 10^5 (binomial)
        assert np.quantile(tilt, 0.2) < np.median(shown) < np.quantile(tilt, 0.8)


def test_settling_and_roses_are_drawn_and_refuse_what_they_cannot_show(cloud):
    labels, _ = words_of(plot.settling(cloud, steps=2))
    assert labels == ["samples", "volume [m³]", "samples", "side of the box [mm]"]
    limb = small_limb()
    options = {"pressures": np.full(3, 30e3), "max_deflection": 10 * mm}
    rose = sl.payload_rose(limb, "xy", count=3, **options)
    assert_allclose(rose.directions[1], [-0.5, math.sqrt(0.75), 0.0], atol=1e-15)
    # three tubes at equal pressures: a third of a turn changes nothing; the payload is found to 1e-9 of its bracket,
    # each posture to 1e-6 of the length, which is 2e-5 of the deflection
    assert_allclose(rose.forces, rose.forces[0], rtol=1e-4)
    assert rose.weakest.force == rose.forces.min()
    assert len(plot.payload_rose(rose, names=["a"]).axes) == 1
    with pytest.raises(ValueError, match="at least one rose"):
        plot.payload_rose()
    with pytest.raises(ValueError, match="one a rose"):
        plot.payload_rose(rose, names=["a", "b"])
    with pytest.raises(ValueError, match="in one plane"):
        plot.payload_rose(rose, sl.payload_rose(limb, "xz", count=3, **options))
    with pytest.raises(ValueError, match="plane must be one of"):
        sl.payload_rose(limb, "zx", **options)
    with pytest.raises(ValueError, match="count must be a whole number of at least 3"):
        sl.payload_rose(limb, "xz", count=2, **options)
    empty = workspace_of(limb, np.zeros((1, 3)))
    empty.batch.success[:] = False
    with pytest.raises(ValueError, match="empty workspace"):
        plot.workspace(Workspace(empty.batch))


def test_the_command_prints_both_tables_and_writes_its_files(tmp_path, capsys):
    picture, table = tmp_path / "w.png", tmp_path / "w.csv"
    arguments = ["workspace", "bend-1", "--samples", "200", "--max-pressure-kPa", "50", "--no-progress", "--payload"]
    assert main([*arguments, "--output", str(picture), "--table", str(table), "--check", "5"]) == 0
    said = capsys.readouterr().out
    for words in ("postures count", "hull [m^3]", "volume by reach", "of 5 points", "reference length", "Fabric SPL"):
        assert words in said
    assert "payload of this limb" in said and picture.stat().st_size > 10_000
    assert table.read_text(encoding="utf-8").startswith("samples,box x [mm]")


def test_the_command_knows_the_reference_limb_and_loads_in_place_of_the_scenes(capsys):
    arguments = ["workspace", "reference", "--samples", "64", "--no-progress", "--even"]
    assert main([*arguments, "--gravity-m-s2", "0", "0", "9.81", "--tip-force-N", "0.1", "0", "0"]) == 0
    said = capsys.readouterr().out
    assert "gravity (0, 0, 9.81) m/s^2; tip force (0.1, 0, 0) N" in said and "reference length: 650.0 mm" in said


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (["--samples", "0"], "samples must be a whole number of at least 1"),
        (["--max-pressure-kPa", "-5"], "min_pressure must not exceed max_pressure"),
        (["--max-pressure-kPa", "nan"], "max_pressure must be finite"),
        (["--gravity-m-s2", "0", "nan", "0"], "gravity must be finite"),
        (["--sampling", "sobol"], "invalid choice"),
        (["--output", "picture.txt"], "must end in one of"),
    ],
)
def test_the_command_refuses_bad_arguments_in_one_line(change, words, capsys):
    assert main(["workspace", "bend-1", "--samples", "8", "--no-progress", *change]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1


# --- beside the literature ------------------------------------------------------------------------------------------


def test_the_table_has_the_papers_rows_and_says_what_cannot_be_compared(cloud):
    limb = cloud.batch.limb
    carried = {"+x": limb.payload((1, 0, 0), pressures=np.full(9, 40 * kPa), max_deflection=20 * mm)}
    said = beside_published(cloud, carried)
    for limb_of_others in PUBLISHED:
        assert limb_of_others.name in said and f"{limb_of_others.payload:.2f}" in said
    for words in ("reference length 650.0 mm", "computed", "measured", "Not comparable", "(deflection)", "no gravity"):
        assert words in said
    x, y, z = cloud.extents
    row = next(line for line in said.splitlines() if "this limb  computed" in line)
    assert row.split()[3:6] == [f"{x:.2f}", f"{y:.2f}", f"{z:.2f}"] and f"{carried['+x'].force:.3g}" in said
    assert "payload of this limb" not in beside_published(cloud)
