"""What the README promises is run: its example, its commands, the files that it names."""

import re
import shlex
from pathlib import Path

import softlimb
from softlimb.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def command_after(marker):
    found = re.search(rf"<!-- {marker} -->\n```sh\n(.+?)\n```", README, re.DOTALL)
    assert found, f"README has no command after the marker {marker!r}"
    return found.group(1)


def test_the_example_runs_as_printed_and_its_posture_is_right(capsys):
    scope = {}
    exec(re.search(r"```python\n(.+?)```", README, re.DOTALL).group(1), scope)
    posture = scope["posture"]
    assert posture.success and posture.stable and posture.verify().success
    assert capsys.readouterr().out


def test_the_example_is_ten_lines_of_code():
    code = re.search(r"```python\n(.+?)```", README, re.DOTALL).group(1)
    assert len([line for line in code.splitlines() if line.strip()]) <= 10


def test_the_main_command_solves_and_draws(tmp_path, monkeypatch, capsys):
    command = command_after("main job")
    assert "\n" not in command
    words = shlex.split(command.split("&&")[-1])
    assert words[0].endswith("softlimb")
    monkeypatch.chdir(tmp_path)
    assert main(words[1:]) == 0
    assert "converged" in capsys.readouterr().out
    assert (tmp_path / words[words.index("--output") + 1]).stat().st_size > 0


def test_each_command_is_one_line_that_makes_its_own_environment():
    for marker in ("main job", "tests"):
        command = command_after(marker)
        assert "\n" not in command and "venv" in command and "pip install" in command


def test_the_files_and_names_that_it_mentions_exist():
    for path in re.findall(r"`((?:cpp|python|notebooks|tests)/[\w./-]+?)`", README):
        assert (ROOT / path).exists(), path
    for name in set(re.findall(r"\bsl\.(\w+)", README)):
        assert hasattr(softlimb, name), name
