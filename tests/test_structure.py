"""One direction for includes and imports; a light import; stubs and types that are current."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import softlimb

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "python" / "softlimb"

# What each folder of the C++ core may include besides itself and the headers beside the folders.
CPP_MAY_USE = {
    "materials": set(),
    "solve": set(),
    "actuator": {"materials", "solve"},
    "rod": {"solve"},
    "limb": {"rod", "solve"},
    "sweep": {"actuator", "limb", "materials", "rod", "solve"},
    "control": set(),
    "bench": set(),
}

# Python, from left to right: a module may import what stands to its left, at any depth of its code.
PYTHON_ORDER = [
    ["_core", "arguments", "text_tables", "units"],
    ["quantities", "materials"],
    ["tube"],
    ["changed"],
    ["derivatives"],
    ["posture"],
    ["paper"],
    ["path"],
    ["limb"],
    ["presets"],
    ["scenes"],
    ["rows"],
    ["payload", "reach", "sweep"],
    ["control", "paper_reach", "sense", "workspace"],
    ["measured"],
    ["design"],
    ["identify"],
    ["validate"],
    ["plot"],
    ["bench"],
    ["report"],
    ["cli"],
]
# Doors: methods that hand over to a module further right, so that users find them on the object. Imported when called.
# The same inside the package of sweeps.
SWEEP_ORDER = [
    *("pose_angles", "row_table", "record", "message_blocks", "file_layout", "sweep_file", "batch", "chunks", "run"),
    "__init__",
]
SWEEP_DOORS = {("batch", "run")}  # Batch.resume

DOORS = {
    ("tube", "limb"),  # Tube.rod
    ("limb", "scenes"),  # Limb.from_toml, Limb.to_toml
    ("limb", "payload"),  # Limb.payload
    ("limb", "reach"),  # Limb.reach
    ("limb", "sense"),  # Limb.sense
    ("limb", "paper_reach"),  # Limb.reach with method="paper"
    ("limb", "sweep"),  # Limb.sweep
    ("limb", "workspace"),  # Limb.workspace
    ("scenes", "sweep"),  # Scene.sweep
    ("materials", "plot"),  # the picture of a fit
}


def test_includes_point_one_way():
    wrong = []
    for path in [*ROOT.glob("cpp/include/softlimb/*/**/*.hpp"), *ROOT.glob("cpp/src/*/**/*.cpp")]:
        parts = path.relative_to(ROOT / "cpp").parts
        folder = parts[2] if parts[0] == "include" else parts[1]
        for included in re.findall(r'#include "softlimb/(\w+)/', path.read_text(encoding="utf-8")):
            if included != folder and included not in CPP_MAY_USE[folder]:
                wrong.append(f"{path.relative_to(ROOT)} includes {included}/")
    assert not wrong


def test_headers_beside_the_folders_include_no_folder():
    wrong = [
        str(path.relative_to(ROOT))
        for path in ROOT.glob("cpp/include/softlimb/*.hpp")
        if re.search(r'#include "softlimb/\w+/', path.read_text(encoding="utf-8"))
    ]
    assert not wrong


def test_the_core_knows_nothing_of_python():
    sources = [*ROOT.glob("cpp/include/**/*.hpp"), *ROOT.glob("cpp/src/**/*.cpp")]
    assert sources
    assert not [str(path) for path in sources if "pybind11" in path.read_text(encoding="utf-8")]


def imported_modules(tree, with_functions):
    """Names of softlimb modules that a syntax tree imports; those under TYPE_CHECKING do not count."""
    found = set()

    def visit(node):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.FunctionDef) and not with_functions:
            return
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "softlimb":
            parts = node.module.split(".")
            found.update([parts[1]] if len(parts) > 1 else [alias.name for alias in node.names])
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(tree)
    return found


def test_imports_point_one_way():
    rank = {name: place for place, names in enumerate(PYTHON_ORDER) for name in names}
    wrong = []
    for path in PACKAGE.rglob("*.py"):
        module = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if module == "__init__":
            continue
        assert module in rank, f"{module} has no place in PYTHON_ORDER"
        tree = ast.parse(path.read_text(encoding="utf-8"))
        at_import = imported_modules(tree, with_functions=False)
        anywhere = imported_modules(tree, with_functions=True)
        for used in anywhere & rank.keys():
            if used == module or rank[used] < rank[module]:
                continue
            if used in at_import or (module, used) not in DOORS:
                wrong.append(f"{path.relative_to(ROOT)} imports {used}")
    assert not wrong


def test_imports_point_one_way_inside_the_package_of_sweeps():
    rank = {name: place for place, name in enumerate(SWEEP_ORDER)}
    assert sorted(path.stem for path in PACKAGE.glob("sweep/*.py")) == sorted(SWEEP_ORDER)
    for path in PACKAGE.glob("sweep/*.py"):
        text = path.read_text(encoding="utf-8")
        for used in re.findall(r"^\s*from softlimb\.sweep\.(\w+) import", text, re.MULTILINE):
            assert rank[used] < rank[path.stem] or (path.stem, used) in SWEEP_DOORS, f"{path.name} imports {used}"
        assert not re.search(r"^\s*from softlimb\.sweep import", text, re.MULTILINE), path.name


def test_importing_the_package_loads_no_heavy_library():
    heavy = ["matplotlib", "scipy", "xarray", "pandas", "tqdm", "netCDF4", "distributed", "nlopt"]
    code = f"import softlimb, sys; print([name for name in {heavy} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_public_name_exists_and_has_a_docstring():
    for name in softlimb.__all__:
        assert getattr(softlimb, name).__doc__, name


def test_the_stubs_of_the_core_are_current(tmp_path):
    pytest.importorskip("pybind11_stubgen")
    command = [sys.executable, "-m", "pybind11_stubgen", "softlimb._core", "--output-dir", str(tmp_path)]
    subprocess.run(command, capture_output=True, text=True, check=True)
    fresh = (tmp_path / "softlimb" / "_core.pyi").read_text(encoding="utf-8")
    committed = (PACKAGE / "_core.pyi").read_text(encoding="utf-8")
    assert fresh == committed, "run: python -m pybind11_stubgen softlimb._core --output-dir python"


@pytest.mark.slow  # mypy reads numpy's stubs: tens of seconds without a cache
def test_mypy_finds_nothing(tmp_path):
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), str(PACKAGE)]
    found = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert found.returncode == 0, found.stdout


def test_ruff_finds_nothing():
    pytest.importorskip("ruff")
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "python", "tests"]
    found = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert found.returncode == 0, found.stdout
