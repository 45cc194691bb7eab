"""Pictures: files that can be opened, axes that say their unit, lengths that are equal in all directions."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb import Section, measured, plot, scenes
from softlimb.presets import reference_limb
from softlimb.units import kPa


@pytest.fixture(scope="module")
def posture():
    loads = {"gravity": (0.0, 0.0, 9.81), "tip_force": (0.5, 0.0, -0.2), "tip_moment": (0.0, 0.02, 0.0)}
    return reference_limb().solve(np.array([90, 60, 30, 60, 40, 20, 50, 50, 50]) * kPa, **loads)


def labels(figure: Figure) -> list[str]:
    found = []
    for ax in figure.axes:
        found += [ax.get_xlabel(), ax.get_ylabel(), *([ax.get_zlabel()] if hasattr(ax, "get_zlabel") else [])]
    return [label for label in found if label]


def texts(figure: Figure) -> str:
    return " | ".join(text.get_text() for ax in figure.axes for text in ax.texts)


def test_a_limb_is_drawn_to_a_file_with_units_on_all_axes(posture, tmp_path: Path) -> None:
    figure = plot.limb(posture)
    for ending in ("png", "pdf", "svg"):
        figure.savefig(tmp_path / f"limb.{ending}")
        assert (tmp_path / f"limb.{ending}").stat().st_size > 10_000
    assert labels(figure)
    assert all(label.endswith("]") for label in labels(figure)), labels(figure)


def test_space_and_side_views_have_equal_scales(posture) -> None:
    figure = plot.limb(posture)
    figure.draw_without_rendering()
    space, *views = [ax for ax in figure.axes if ax.get_ylabel() != "gauge pressure [kPa]"]
    spans = [abs(np.diff(getattr(space, f"get_{name}lim")())[0]) for name in "xyz"]
    # the box's sides must be as long as the limits are wide; matplotlib normalises them together
    assert_allclose(space._box_aspect / space._box_aspect.max(), np.array(spans) / max(spans), rtol=1e-12)
    for ax in views:
        assert ax.get_aspect() == 1.0


def test_a_hanging_limb_points_down_in_all_views(posture) -> None:
    figure = plot.limb(posture)
    space, *views = [ax for ax in figure.axes if ax.get_ylabel() != "gauge pressure [kPa]"]
    figure.draw_without_rendering()
    from mpl_toolkits.mplot3d import proj3d

    heights = [proj3d.proj_transform(0.0, 0.0, z, space.get_proj())[1] for z in (0.0, 100.0)]
    assert heights[1] < heights[0]
    for ax in views:
        assert ax.yaxis.get_inverted()


def test_loads_carry_their_value_and_unit(posture) -> None:
    said = texts(plot.limb(posture))
    assert "0.539 N" in said  # |(0.5, 0, -0.2)|
    assert "0.02 N m" in said
    assert "9.81 m/s²" in said
    assert texts(plot.limb(posture, figure_axes(), loads=False).figure) == ""


def figure_axes():
    return Figure().add_subplot(projection="3d")


def test_load_labels_do_not_cover_each_other(posture) -> None:
    figure = plot.limb(posture)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[i + 1 :])


def test_tick_labels_of_the_side_views_do_not_touch(posture) -> None:
    for pressures in (np.zeros(9), np.array([90, 60, 30, 60, 40, 20, 50, 50, 50]) * kPa):
        figure = plot.limb(reference_limb().solve(pressures, gravity=(0.0, 0.0, 9.81)))
        figure.draw_without_rendering()
        boxes = [
            label.get_window_extent()
            for ax in figure.axes[1:3]
            for label in ax.get_xticklabels()
            if label.get_text() and ax.get_xlim()[0] <= label.get_position()[0] <= ax.get_xlim()[1]
        ]
        for i, one in enumerate(boxes):
            assert not any(one.overlaps(other) for other in boxes[i + 1 :])


def test_rods_without_a_known_radius_are_drawn_as_well() -> None:
    from softlimb.limb import Limb, Plate, Rod, Segment

    rod = Rod(Section(axial=400.0, shear=130.0, bending=0.05, torsion=0.03), 0.2)
    limb = Limb([Segment(rods=[rod] * 3, ring_radius=0.03, plate=Plate(thickness=0.0, mass=0.0))])
    figure = plot.limb(limb.solve(tip_force=(0.1, 0.0, 0.0)))
    assert all(label.endswith("]") for label in labels(figure))


def test_curves_show_measured_points_beside_the_prediction() -> None:
    pressures = np.linspace(0.0, 55.0, 6) * kPa
    curve = measured.Curve("elongation", pressures, 0.001 * pressures / kPa)
    figure = plot.comparison(
        measured.compare_curve(curve, lambda p: 0.0011 * p / kPa, np.linspace(0.0, 55.0, 12) * kPa)
    )
    ax = figure.axes[0]
    assert ax.get_xlabel() == "gauge pressure [kPa]"
    assert ax.get_ylabel() == "elongation [mm]"
    shown = {line.get_label(): line.get_xydata() for line in ax.lines}
    assert_allclose(shown["measured"], np.stack([pressures / kPa, pressures / kPa], axis=1))
    assert_allclose(shown["predicted"][:, 1], 1.1 * shown["predicted"][:, 0])


def test_sweeps_and_centrelines_have_units_and_equal_scales(posture) -> None:
    scene = scenes.load_scene("bend-2")
    batch = scene.sweep(progress=False)
    for figure in (plot.sweep(batch, scene.sweep_axes), plot.sweep(batch)):
        assert all(label.endswith("]") for label in labels(figure)), labels(figure)
    result = measured.compare_centreline(measured.Centreline(posture.centreline(5)), posture)
    figure = plot.comparison(result)
    assert [ax.get_aspect() for ax in figure.axes] == [1.0, 1.0]
    assert "% of 650.0 mm" in figure.get_suptitle()


def test_a_notebook_shows_a_figure_as_a_picture(posture) -> None:
    import pickle

    figure = plot.limb(posture)
    assert figure._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    assert pickle.loads(pickle.dumps(figure)).axes


def test_pictures_leave_no_global_state(posture) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    plot.limb(posture)
    assert dict(matplotlib.rcParams) == before
    assert "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()


def test_a_picture_of_no_equilibrium_says_so() -> None:
    failed = reference_limb().solve(np.array([5000.0, *[0.0] * 8]) * kPa)
    assert plot.limb(failed).get_suptitle() == "not an equilibrium: limit_point"
    assert plot.limb(failed, figure_axes()).get_title() == "not an equilibrium: limit_point"


def tick_boxes(ax) -> list:
    # In space a label has its place only while drawn: asking the axis for its labels would put it back.
    axes = [ax.xaxis, ax.yaxis, *([ax.zaxis] if hasattr(ax, "zaxis") else [])]
    labels = [[tick.label1 for tick in axis.majorTicks] for axis in axes]
    return [[label.get_window_extent() for label in part if label.get_text()] for part in labels]


def test_every_axis_in_space_has_two_ticks_and_their_labels_are_free() -> None:
    for kPas in ([500] * 9, [90, 60, 30, 60, 40, 20, 50, 50, 50], [0] * 9):
        figure = plot.limb(reference_limb().solve(np.array(kPas) * kPa, gravity=(0.0, 0.0, 9.81)))
        figure.draw_without_rendering()
        space = figure.axes[0]
        ticks = tick_boxes(space)
        assert all(len(boxes) >= 2 for boxes in ticks)
        for view in figure.axes[1:3]:
            assert len(tick_boxes(view)[0]) >= 2
        boxes = [box for part in ticks for box in part] + [space.zaxis.label.get_window_extent()]
        for i, one in enumerate(boxes):
            assert not any(one.overlaps(other) for other in boxes[i + 1 :]), (kPas, i)


def test_labels_of_loads_on_several_plates_keep_off_each_other_and_off_the_ticks() -> None:
    wrenches = np.array([[0.5, 0, 0, 0, 0.02, 0], [0, 0.4, 0, 0.01, 0, 0], [0, 0, -0.3, 0, 0, 0.02]])
    pressures = np.array([90, 60, 30, 60, 40, 20, 50, 50, 50]) * kPa
    figure = plot.limb(reference_limb().solve(pressures, gravity=(0.0, 0.0, 9.81), plate_wrenches=wrenches))
    figure.draw_without_rendering()
    written = [text.get_window_extent() for text in figure.axes[0].texts]
    ticks = [box for part in tick_boxes(figure.axes[0]) for box in part]
    for i, one in enumerate(written):
        assert not any(one.overlaps(other) for other in written[i + 1 :] + ticks)


def test_rods_without_pressure_are_grey() -> None:
    from softlimb.limb import Limb, Plate, Rod, Segment
    from softlimb.plot.limb import _tubes

    rod = Rod(Section(axial=400.0, shear=130.0, bending=0.05, torsion=0.03), 0.2)
    limb = Limb([*reference_limb(["proximal"]), Segment(rods=[rod] * 3, ring_radius=0.02, plate=Plate(0.0, 0.0))])
    colours = [tube.colour for tube in _tubes(limb.solve(np.array([60.0, 30.0, 0.0]) * kPa))]
    assert all(len(set(colour)) == 1 for colour in colours[3:])
    assert all(len(set(colour)) == 3 for colour in colours[:3])


def test_a_sweep_with_one_good_row_or_none_has_readable_axes() -> None:
    limb = reference_limb(["proximal"])
    for values in ((10 * kPa, 9000 * kPa), (9000 * kPa,)):
        batch = limb.sweep([[p] * 3 for p in values], progress=False)
        axis = scenes.Axis(values, ((1, 1), (1, 2), (1, 3)))
        for figure in (plot.sweep(batch, [axis]), plot.sweep(batch)):
            figure.draw_without_rendering()
            # rounding alone, 1e-16 deg, must not fill an axis
            assert all(abs(np.diff(ax.get_ylim())[0]) > 0.5 for ax in figure.axes)


def test_a_path_is_drawn_with_its_stable_and_unstable_parts_and_its_fold():
    column = sl.Section(axial=1e5, shear=1e5, bending=1.0, torsion=0.8)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(column, 1.0)], ring_radius=0.0)])
    followed = limb.follow(lambda force: {"tip_force": (0.0, 0.0, -force)}, 0.0, 4.0)
    figure = plot.path(followed, "tip load [N]")
    axes = figure.axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["stable", "unstable", "bifurcation"]
    assert axes.get_xlabel() == "tip load [N]" and axes.get_ylabel() == "tip z [mm]"
    full, dashed, square = axes.get_lines()
    # Drawn to the bifurcation, in newtons and millimetres.
    assert full.get_xdata()[-1] == dashed.get_xdata()[0] == square.get_xdata()[0] == followed.events[0].parameter
    assert full.get_ydata()[0] == pytest.approx(1000.0)
    with pytest.raises(ValueError, match="coordinate"):
        plot.path(followed, "", coordinate="w")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="unit"):
        plot.path(followed, "", unit=0.0)


def test_the_box_in_space_has_its_upright_edge_on_the_right(posture) -> None:
    figure = plot.limb(posture)
    space = figure.axes[0]
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3].mean(axis=2)  # rows from below
    corners = np.array(np.meshgrid(*(getattr(space, f"get_{name}lim")() for name in "xyz"))).reshape(3, -1).T
    from mpl_toolkits.mplot3d import proj3d

    flat = np.array([proj3d.proj_transform(*corner, space.get_proj())[:2] for corner in corners])
    screen = space.transData.transform(flat)
    column = round(float(screen[:, 0].max()))
    rightmost = screen[screen[:, 0] > column - 1.0]
    low, high = int(rightmost[:, 1].min()), int(rightmost[:, 1].max())
    # A line half a point wide is a grey column of one or two pixels between the two corners; without it the page is
    # white but for the ends of a dozen grid lines.
    darkest = pixels[low + 2 : high - 2, column - 1 : column + 2].min(axis=1)
    assert np.mean(darkest < 250.0) > 0.95


@pytest.mark.parametrize("place", [(0.1, 0.05, 0.75), (0.6, 0.0, 0.9)])
def test_a_target_reached_or_missed_lies_in_both_views_at_one_scale(place, tmp_path: Path) -> None:
    found = reference_limb().reach(position=place, max_pressure=60 * kPa, gravity=(0.0, 0.0, 9.81))
    figure = plot.reach(found)
    figure.savefig(tmp_path / "reach.png")
    assert labels(figure) and all(label.endswith("]") or label == "segment.actuator" for label in labels(figure))
    front, side, _ = figure.axes
    scales = []
    for axis, ax in enumerate((front, side)):
        across, up = sorted(ax.get_xlim()), sorted(ax.get_ylim())
        assert across[0] < 1e3 * place[axis] < across[1] and up[0] < 1e3 * place[2] < up[1]
        box = ax.get_window_extent()
        scales += [box.width / np.ptp(across), box.height / np.ptp(up)]
    assert_allclose(scales, scales[0], rtol=1e-9)
    title = figure.get_suptitle()
    assert ("reached" in title) == found.reached and ("missed" in title) != found.reached


def test_a_target_s_cross_has_room_on_paper() -> None:
    limb = scenes.load_scene("bend-1").limb
    found = limb.reach(position=(0.1, 0.05, 0.72), max_pressure=100 * kPa, gravity=(0.0, 0.0, 9.81))
    figure = plot.reach(found)
    figure.draw_without_rendering()
    for axis, ax in enumerate(figure.axes[:2]):
        cross = ax.transData.transform(1e3 * found.target[[axis, 2], 3])
        box = ax.get_window_extent()
        room = min(*(cross - box.p0), *(box.p1 - cross)) / figure.dpi * 72.0  # points
        assert room > 5.0  # half of the cross, 8 points wide, and its line


@pytest.mark.parametrize("place", [(1e6, 0.0, 0.0), (0.0, 10.0, 0.0), (1e300, 1e300, 0.0)])
def test_a_far_target_is_an_arrow_in_the_limbs_own_view(place, tmp_path: Path) -> None:
    found = reference_limb().reach(position=place, max_pressure=60 * kPa, gravity=(0.0, 0.0, 9.81))
    figure = plot.reach(found)
    figure.savefig(tmp_path / "reach.png")
    for ax in figure.axes[:2]:
        assert np.ptp(ax.get_xlim()) < 2e3 and np.ptp(ax.get_ylim()) < 2e3  # [mm], of a limb of 650
        assert 1 < len(ax.get_xticks()) < 12
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    distance = f"{np.hypot(*place[:2]):.4g} m" if place[1] != 10.0 else "m"
    assert any(name.startswith("to the target, ") and distance in name for name in names)
