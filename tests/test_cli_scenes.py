"""The subcommands posture, reach, sweep and compare, as a user types them."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softlimb import Batch, rows, scenes
from softlimb.cli import SUBCOMMANDS, main
from sweep_examples import KnownRows


def columns_of(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def is_picture(path: Path) -> bool:
    return path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and path.stat().st_size > 10_000


def test_posture_prints_a_table_and_writes_picture_and_files(tmp_path: Path, capsys) -> None:
    picture, table, line = tmp_path / "limb.png", tmp_path / "plates.csv", tmp_path / "line.csv"
    arguments = [
        "posture",
        "complex-posture",
        "--output",
        str(picture),
        "--table",
        str(table),
        "--centreline",
        str(line),
    ]
    assert main(arguments) == 0
    said = capsys.readouterr().out
    assert "90.0 60.0 30.0" in said
    assert "status: converged" in said
    assert "reference length: 650.0 mm" in said
    assert is_picture(picture)
    columns = columns_of(table)
    posture = scenes.load_scene("complex-posture").solve()
    # the file holds twelve digits
    assert_allclose([float(z) for z in columns["z_mm"]], posture.plates[:, 2, 3] * 1e3, rtol=1e-11)
    assert_allclose([float(p) for p in columns["pressure_1_kPa"]], [90.0, 60.0, 50.0], rtol=1e-12)
    points = columns_of(line)
    assert_allclose(float(points["x_mm"][-1]), posture.tip[0, 3] * 1e3, atol=1e-6)  # six decimals


def test_posture_takes_pressures_from_the_command_line(capsys) -> None:
    assert main(["posture", "elongation-proximal", "--pressures-kPa", "10", "10", "10"]) == 0
    assert "10.0 10.0 10.0" in capsys.readouterr().out


RODS = """
[limb.rods.leg]
length_mm = 300
radius_mm = 3
section = {axial_N = 4000, shear_N = 1500, bending_Nm2 = 0.05, torsion_Nm2 = 0.04, mass_per_length_kg_m = 0.03}

[[limb.segments]]
rods = ["leg", "leg", "leg", "leg", "leg", "leg"]
ring_radius_mm = 60
plate = {thickness_mm = 5, mass_g = 100}

[scene]
rest_lengths_mm = [320, 310, 300, 290, 300, 310]
"""


def test_a_limb_of_rods_is_driven_by_their_lengths_and_may_be_held(tmp_path: Path, capsys) -> None:
    path, picture = tmp_path / "rods.toml", tmp_path / "rods.png"
    path.write_text(RODS, encoding="utf-8")
    assert main(["posture", str(path), "--output", str(picture), "--table", str(tmp_path / "a.csv")]) == 0
    assert "320.0 310.0 300.0 290.0 300.0 310.0" in capsys.readouterr().out
    assert columns_of(tmp_path / "a.csv")["rod_length_6_mm"] == ["310"]
    assert is_picture(picture)
    path.write_text(
        RODS + '[scene.held_tip]\nposition_mm = [0, 0, 310]\nfreedoms = ["x", "y", "z"]\n', encoding="utf-8"
    )
    assert main(["posture", str(path)]) == 0
    said = capsys.readouterr().out
    assert "hold on tip: force" in said
    posture = scenes.Scene.from_toml(path).solve()
    assert_allclose(posture.tip[:3, 3], [0.0, 0.0, 0.31], atol=1e-6 * 0.3)  # the tolerance asked for


def test_a_posture_that_does_not_exist_ends_with_code_one_and_its_status(tmp_path: Path, capsys) -> None:
    # Without fibres this neo-Hookean tube balloons at 90.6 kPa; 500 kPa is far beyond.
    path = tmp_path / "balloon.toml"
    path.write_text(
        """
        [limb.tubes.bare]
        length_mm = 200
        layers = [{inner_radius_mm = 18, outer_radius_mm = 21.5, material = "smoothsil-950"}]
        [[limb.segments]]
        actuators = ["bare", "bare", "bare"]
        ring_radius_mm = 28
        [scene]
        pressures_kPa = [500, 500, 500]
        [[scene.sweep]]
        segment = 1
        values_kPa = [10, 500]
        """,
        encoding="utf-8",
    )
    assert main(["posture", str(path)]) == 1
    assert "status: converged" not in capsys.readouterr().out
    table = tmp_path / "a.csv"
    assert main(["sweep", str(path), "--no-progress", "--table", str(table)]) == 1
    said = capsys.readouterr().out
    assert "2 postures, 1 successful" in said
    assert "row 2: " in said
    assert columns_of(table)["tip_z_mm"][1] == ""


def test_sweep_writes_csv_netcdf_and_a_picture(tmp_path: Path, capsys) -> None:
    xarray = pytest.importorskip("xarray")
    table, data, picture = tmp_path / "a.csv", tmp_path / "a.nc", tmp_path / "a.png"
    arguments = ["sweep", "bend-1", "--table", str(table), "--netcdf", str(data), "--output", str(picture)]
    assert main([*arguments, "--no-progress"]) == 0
    assert "13 postures, 13 successful" in capsys.readouterr().out
    columns = columns_of(table)
    assert_allclose([float(p) for p in columns["pressure_1_1_kPa"]], np.linspace(0.0, 60.0, 13), rtol=1e-12)
    assert set(columns["success"]) == {"True"}
    with xarray.open_dataset(data) as read:
        assert read.pressure.attrs["units"] == "Pa"
        assert read.tip_position.attrs["units"] == "m"
        assert_allclose(read.tip_position.values[:, 2] * 1e3, [float(z) for z in columns["tip_z_mm"]], rtol=1e-11)
        again = scenes.Scene.from_dict(_parsed(read.attrs["scene"]))
    assert again.limb == scenes.load_scene("bend-1").limb
    assert is_picture(picture)


def _parsed(text: str) -> dict:
    try:
        import tomllib
    except ModuleNotFoundError:
        import tomli as tomllib
    return tomllib.loads(text)


def test_a_predicted_centreline_compared_with_itself_has_no_error(tmp_path: Path, capsys) -> None:
    line = tmp_path / "line.csv"
    assert main(["posture", "complex-posture", "--centreline", str(line)]) == 0
    capsys.readouterr()
    picture = tmp_path / "a.png"
    assert main(["compare", "complex-posture", str(line), "--output", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "tip error: 0.00 mm = 0.00 % of the reference length 650.0 mm" in said
    assert "R^2 of the positions: 1.0000" in said
    assert is_picture(picture)


def test_a_shifted_tip_is_reported_in_mm_and_per_cent_of_the_length_asked_for(tmp_path: Path, capsys) -> None:
    tip = [float(1e3 * x) for x in scenes.load_scene("complex-posture").solve().tip[:3, 3]]
    path = tmp_path / "a.csv"
    path.write_text(f"x_mm,y_mm,z_mm\n0,0,0\n{tip[0] + 13.45!r},{tip[1]!r},{tip[2]!r}\n", encoding="utf-8")
    assert main(["compare", "complex-posture", str(path), "--reference-length-mm", "666"]) == 0
    # 13.45/666 = 2.0195 %: the paper's number, to show which length it implies
    assert "tip error: 13.45 mm = 2.02 % of the reference length 666.0 mm" in capsys.readouterr().out


def test_a_curve_taken_from_the_prediction_compares_without_error(tmp_path: Path, capsys) -> None:
    from softlimb.measured import response_of

    response = response_of(scenes.load_scene("elongation-proximal"), "elongation")
    rows = [f"{p:g},{float(1e3 * response(1e3 * p))!r}" for p in (5.0, 22.0, 41.0)]
    path, table, picture = tmp_path / "a.csv", tmp_path / "b.csv", tmp_path / "a.png"
    path.write_text("\n".join(["P,elongation_mm", *rows]), encoding="utf-8")
    arguments = ["compare", "elongation-proximal", str(path), "--column", "pressure_kPa=P", "--table", str(table)]
    assert main([*arguments, "--output", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "pressure MAE at equal elongation: 0.0000 kPa" in said
    assert "R^2 of the elongation: 1.0000" in said
    assert columns_of(table)["pressure_kPa"] == ["5.00", "22.00", "41.00"]
    assert is_picture(picture)


def test_sweeps_and_measured_tips_have_the_same_columns(tmp_path: Path, capsys) -> None:
    table = tmp_path / "sweep.csv"
    assert main(["sweep", "bend-2", "--table", str(table), "--no-progress"]) == 0
    capsys.readouterr()
    assert main(["compare", "bend-2", str(table)]) == 0
    assert "mean tip error: 0.00 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["postur", "x"], "invalid choice: 'postur'"),
        (["posture"], "the following arguments are required: SCENE"),
        (["posture", "comlex-posture"], "did you mean `complex-posture`?"),
        (["posture", "nowhere.toml"], "there is no file nowhere.toml"),
        (["posture", "complex-posture", "--pressures-kPa", "1"], "--pressures-kPa has 1 numbers"),
        (["posture", "complex-posture", "--pressures-kPa", *["nan"] * 9], "--pressures-kPa must be finite"),
        (["posture", "complex-posture", "--tolerance", "0"], "--tolerance must be within 1e-12 and 0.1"),
        (["posture", "complex-posture", "--output", "nowhere/at/all.png"], "nowhere/at/all.png"),
        (["sweep", "bend-1", "--threads", "0"], "threads must be a whole number of at least 1"),
        (["sweep", "bend-1", "--threads", "1.5"], "--threads: invalid int value: '1.5'"),
        (["sweep", "bend-1", "--file", "."], "--file: expected the name of a file, '.' is a folder"),
        (["sweep", "bend-1", "--file", "nowhere/rows"], "there is no folder nowhere"),
        (["sweep", "bend-1", "--file", __file__], "is no sweep of softlimb"),
        (["compare", "complex-posture", "nowhere.csv"], "there is no file nowhere.csv"),
        (["compare", "complex-posture", "x.csv", "--column", "a"], "--column must be NAME=THEIRS"),
    ],
)
def test_a_users_mistake_is_one_line_and_exit_code_two(arguments: list[str], message: str, capsys) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("softlimb: error: ")
    assert said.count("\n") == 1
    assert message in said


def test_a_comparison_that_the_scene_cannot_answer_says_so(tmp_path: Path, capsys) -> None:
    path = tmp_path / "a.csv"
    path.write_text("pressure_kPa,bending_deg\n1,2\n", encoding="utf-8")
    assert main(["compare", "complex-posture", str(path)]) == 2
    assert "exactly one [[scene.sweep]] of pressures" in capsys.readouterr().err
    path.write_text("pressure_1_1_kPa,tip_x_mm,tip_y_mm,tip_z_mm\n1,2,3,4\n", encoding="utf-8")
    assert main(["compare", "complex-posture", str(path)]) == 2
    assert "pressures of 1 actuators, the limb has 9" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [*([subcommand.__name__.rpartition(".")[2]] for subcommand in SUBCOMMANDS), ["design", "radius-ratio"]],
    ids=" ".join,
)
def test_every_subcommand_prints_its_help(words: list[str], capsys) -> None:
    # argparse fills in % only when it prints: a bare one breaks the help alone.
    assert main([*words, "--help"]) == 0
    assert f"usage: softlimb {' '.join(words)}" in capsys.readouterr().out


def test_version_and_help_exit_with_zero(capsys) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("softlimb ")
    assert main(["compare", "--help"]) == 0
    assert "pressure_1_1_kPa" in capsys.readouterr().out


def test_the_command_does_not_load_matplotlib_without_a_picture() -> None:
    code = "import sys; from softlimb.cli import main; main(['--version']); sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_where_there_is_no_equilibrium_nothing_looks_like_an_answer(tmp_path: Path, capsys) -> None:
    # Far beyond the ballooning of the proximal actuator at 1692 kPa.
    overblown = ["complex-posture", "--pressures-kPa", "5000", *["0"] * 8]
    files = {name: tmp_path / f"{name}.{'png' if name == 'output' else 'csv'}" for name in FILES}
    assert main(["posture", *overblown, *(part for name in FILES for part in (f"--{name}", str(files[name])))]) == 1
    said = capsys.readouterr().out
    assert "status: limit_point after 0 iterations: not an equilibrium" in said
    assert "5000 kPa" in said
    assert not any(word in said for word in ("plate x", "ground on base", "smallest gap"))
    for path in files.values():
        assert f"not written, there is no equilibrium to show: {path}" in said
        assert not path.exists()
    line = tmp_path / "measured.csv"
    line.write_text("x_mm,y_mm,z_mm\n0,0,0\n0,0,650\n", encoding="utf-8")
    assert main(["compare", *overblown[:1], str(line), *overblown[1:], "--output", str(files["output"])]) == 1
    said = capsys.readouterr().out
    assert "tip error: - mm" in said
    assert "status: limit_point" in said


FILES = ("table", "centreline", "output")


def test_a_mistake_that_shows_when_solving_names_the_file(tmp_path: Path, capsys) -> None:
    path = tmp_path / "silent.toml"
    path.write_text('[limb]\npreset = "reference-limb"\n', encoding="utf-8")
    for command in ("posture", "sweep"):
        assert main([command, str(path)]) == 2
        assert "silent.toml: the scene has no " in capsys.readouterr().err


def scene_file(folder: Path, text: str) -> str:
    path = folder / "scene.toml"
    path.write_text('[limb]\npreset = "reference-limb"\nsegments = ["proximal"]\n' + text, encoding="utf-8")
    return str(path)


HUGE = """
[[scene.sweep]]
actuators = [[1, 1]]
from_kPa = 0
to_kPa = 1
points = 1000000
[[scene.sweep]]
actuators = [[1, 2]]
from_kPa = 0
to_kPa = 1
points = 100000
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[scene]\npressures_kPa = " + "[" * 3000 + "1" + "]" * 3000, "nested too deeply"),
        ("[scene]\npressures_kPa = " + "[" * 30 + "1" + "]" * 30, "nested too deeply"),
        (HUGE, "1000000 x 100000 = 100000000000 rows: at most 1000000"),
        ("[scene]\npressures_kPa = [1" + "0" * 400 + ", 1, 1]", "`pressures_kPa`"),
    ],
)
def test_a_file_too_deep_or_too_large_is_one_line(tmp_path: Path, text: str, message: str, capsys) -> None:
    for command in ("posture", "sweep"):
        assert main([command, scene_file(tmp_path, text)]) == 2
        said = capsys.readouterr().err
        assert said.startswith("softlimb: error: ")
        assert said.count("\n") == 1
        assert message in said


@pytest.mark.parametrize("error", [RecursionError("deep"), MemoryError(), OverflowError("int too large")])
def test_what_runs_out_ends_in_one_line(error: Exception, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    from softlimb.cli import posture

    def run(_: object) -> int:
        raise error

    monkeypatch.setattr(posture, "run", run)
    assert main(["posture", "complex-posture"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("softlimb: error: ")
    assert said.count("\n") == 1


@pytest.mark.parametrize("command", ["posture", "sweep", "compare", "fit"])
@pytest.mark.parametrize(
    ("name", "message"),
    [
        (".", "is a folder"),
        ("", "empty"),
        ("a.txt", "must end in one of .png"),
        ("nowhere/a.png", "there is no folder"),
    ],
)
def test_a_picture_that_cannot_be_written_is_refused_before_the_work(command, name, message, capsys) -> None:
    given = {"compare": ["complex-posture", "x.csv"], "fit": ["x.csv"]}.get(command, ["complex-posture"])
    assert main([command, *given, "--output", name]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""


def test_long_sweeps_are_shortened_on_the_terminal_and_whole_in_the_file(tmp_path: Path, capsys) -> None:
    text = "[[scene.sweep]]\nactuators = [[1, 1]]\nfrom_kPa = 0\nto_kPa = 9.9\npoints = 100\n"
    table = tmp_path / "a.csv"
    assert main(["sweep", scene_file(tmp_path, text), "--no-progress", "--table", str(table)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) < 50
    rows = [line.split()[0] for line in said if " converged" in line or "..." in line]
    assert rows == [*map(str, range(1, 21)), "...", *map(str, range(96, 101))]
    assert "75 rows are not shown (--table writes all)" in said
    assert len(columns_of(table)["status"]) == 100


THOUSAND = "[[scene.sweep]]\nactuators = [[1, 1]]\nfrom_kPa = 1\nto_kPa = 11\npoints = 1000\n"


def test_an_interrupted_sweep_says_so_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setattr(rows, "solve_rows", KnownRows(stop_at=float(np.linspace(1e3, 11e3, 1000)[3])))
    table = tmp_path / "a.csv"
    assert main(["sweep", scene_file(tmp_path, THOUSAND), "--no-progress", "--table", str(table)]) == 130
    said = capsys.readouterr().out
    assert "interrupted: 997 of 1000 rows were not run" in said
    assert said.count("\n") < 50
    assert columns_of(table)["status"][2:4] == ["converged", "not_run"]  # what is done is kept


def test_the_same_command_goes_on_with_the_file_of_an_interrupted_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    solver = KnownRows(stop_at=float(np.linspace(1e3, 11e3, 1000)[300]))
    monkeypatch.setattr(rows, "solve_rows", solver)
    file, scene = tmp_path / "rows", scene_file(tmp_path, THOUSAND)
    command = ["sweep", scene, "--no-progress", "--threads", "2", "--ordered", "--file", str(file)]
    assert main(command) == 130
    said = capsys.readouterr().out
    assert f"file: {file} (the same command goes on with it)" in said
    assert "interrupted: 700 of 1000 rows were not run" in said
    solver.stop_at, solver.solved = None, []
    assert main(command) == 0
    said = capsys.readouterr().out
    assert said.endswith(f"file: {file}\n") and "1000 postures, 1000 successful" in said
    assert len(solver.solved) == 712  # from row 288 on, where a group starts
    assert Batch.load(file).build in said
    assert main([*command, "--tolerance", "1e-4"]) == 2
    assert f"file {file} holds a sweep with tolerance 1e-06, not 0.0001" in capsys.readouterr().err
    assert main(["sweep", scene, "--no-progress", "--file", str(file)]) == 2
    assert "holds a sweep with ordered True, not False" in capsys.readouterr().err


def test_a_reader_that_leaves_early_gets_no_complaint(tmp_path: Path) -> None:
    import os

    read, write = os.pipe()
    os.close(read)
    code = "import sys; from softlimb.cli import main; sys.exit(main(['posture', 'complex-posture']))"
    try:
        done = subprocess.run([sys.executable, "-c", code], stdout=write, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(write)
    assert done.stderr == b""
    assert done.returncode == 141  # as a shell reports SIGPIPE


def test_a_negative_pressure_may_have_an_exponent(capsys) -> None:
    assert main(["posture", "elongation-proximal", "--pressures-kPa", "-1e-3", "0", "-1.5e-3"]) == 0
    assert "0.0 0.0 0.0" in capsys.readouterr().out


def test_reach_prints_target_pressures_and_posture_and_draws_them(tmp_path: Path, capsys) -> None:
    picture, table = tmp_path / "reach.png", tmp_path / "plates.csv"
    arguments = ["reach", "complex-posture", "--position-mm", "150", "50", "720", "--max-pressure-kPa", "80"]
    assert main([*arguments, "--output", str(picture), "--table", str(table)]) == 0
    said = capsys.readouterr().out
    assert "target: reached" in said and "stable" in said
    assert is_picture(picture)
    columns = columns_of(table)
    # a millionth of 650 mm, and twelve digits in the file
    assert_allclose([float(columns[f"{axis}_mm"][-1]) for axis in "xyz"], [150.0, 50.0, 720.0], atol=1e-3)
    pressures = [float(columns[f"pressure_{i}_kPa"][j]) for j in range(3) for i in (1, 2, 3)]
    again = scenes.load_scene("complex-posture").solve(np.array(pressures) * 1e3)
    assert_allclose(again.tip[:3, 3], [0.15, 0.05, 0.72], atol=1.3e-6)  # both tolerances


def test_reach_out_of_reach_is_answered_with_code_one(tmp_path: Path, capsys) -> None:
    picture = tmp_path / "missed.png"
    arguments = ["reach", "bend-2", "--position-mm", "100", "0", "400", "--rotation-deg", "0", "170", "0"]
    assert main([*arguments, "--max-pressure-kPa", "40", "--prefer-kPa", "20", "--output", str(picture)]) == 1
    said = capsys.readouterr().out
    assert "out of reach" in said and "rotation y [deg]" in said and "(max)" in said
    assert is_picture(picture)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--position-mm", "0", "nan", "700"], "--position-mm must be finite"),
        (["--position-mm", "0", "0", "700", "--rotation-deg", "0", "inf", "0"], "--rotation-deg must be finite"),
        (["--position-mm", "0", "0", "700", "--min-pressure-kPa", "200"], "min_pressure must not exceed max_pressure"),
        (["--position-mm", "0", "0", "700", "--max-pressure-kPa", "80", "80"], "max_pressure has shape"),
        (["--position-mm", "0", "0"], "expected 3 arguments"),
        ([], "--position-mm"),
    ],
)
def test_mistakes_of_reach_are_one_line(given: list[str], message: str, capsys) -> None:
    assert main(["reach", "complex-posture", *given]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
