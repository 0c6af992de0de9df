"""The code of the pages about Python prints what they show ("..." stands for any lines)."""

import os
import re
import subprocess
import sys

import pytest

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
BALL = "t 3 s, height -1.2e-04 m, velocity 0.0e+00 m/s"  # of the programs in C and C++ too


def matches(expected, printed):
    pattern = "".join(r"(?:.*\n)*" if line == "..." else re.escape(line) + r"\n" for line in expected)
    return re.fullmatch(pattern, printed)


@pytest.mark.parametrize("page, programs", [("README.md", 1), ("docs/guide/first-program.md", 1),
                                            ("docs/guide/coming-from.md", 1), ("docs/guide/scenes.md", 1),
                                            ("docs/guide/python.md", 7)])
def test_guide(tmp_path, page, programs):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        text = file.read()
    for name, code in re.findall(r"<!-- file: (\S+) -->\n```python\n(.*?)```", text, re.S):
        (tmp_path / name).write_text(code)
    for folder in ("data", "docs"):
        (tmp_path / folder).symlink_to(os.path.abspath(os.path.join(ROOT, folder)))
    ran = 0
    for block in re.findall(r"```console\n(.*?)```", text, re.S):
        command, *expected = block.splitlines()
        if not re.fullmatch(r"\$ python3 \S+", command):
            continue
        script = command.split()[-1]
        if "import nsdae" not in (tmp_path / script).read_text():
            continue  # a program of another package
        done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True,
                              env={**os.environ, "MPLBACKEND": "Agg"}, timeout=120)
        assert done.returncode == 0 and matches(expected, done.stdout), (command, done.stdout, done.stderr)
        ran += 1
    assert ran >= programs


def test_first_program():
    """In at most 15 lines what the programs in C, C++ and Fortran beside it print."""
    with open(os.path.join(ROOT, "docs", "guide", "first-program.md"), encoding="utf-8") as file:
        text = file.read()
    (code,) = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(code.splitlines()) <= 15
    assert text.count(BALL) >= 3 and f"$ python3 ball.py\n{BALL}\n" in text
