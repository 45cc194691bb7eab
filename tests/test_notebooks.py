"""Notebooks run from start to end and are stored without output."""

from __future__ import annotations

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
# A cell that takes longer than a notebook may take in all (20 s on a quiet machine) is stuck.
LONGEST_CELL = 60


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_output(path: Path) -> None:
    for number, cell in enumerate(nbformat.read(path, as_version=4).cells):
        if cell.cell_type == "code":
            assert not cell.outputs and cell.execution_count is None, f"cell {number} of {path.name} keeps its output"


# nbclient, zmq and the start of the kernel warn of their own affairs (event loop policies, debugger).
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_start_to_end(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The notebook runs elsewhere, so a folder beside the checkout needs its full name.
    monkeypatch.setenv("SOFTLIMB_SHARED", os.environ.get("SOFTLIMB_SHARED") or str(FOLDER.parents[1] / "shared"))
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=LONGEST_CELL, resources={"metadata": {"path": str(tmp_path)}}).execute()
