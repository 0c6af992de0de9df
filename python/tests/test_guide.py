"""The code of docs/guide/python.md prints the output shown there ("..." stands for any lines)."""

import os
import re
import subprocess
import sys

GUIDE = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "guide", "python.md")


def matches(expected, printed):
    pattern = "".join(r"(?:.*\n)*" if line == "..." else re.escape(line) + r"\n" for line in expected)
    return re.fullmatch(pattern, printed)


def test_guide(tmp_path):
    with open(GUIDE, encoding="utf-8") as file:
        text = file.read()
    for name, code in re.findall(r"<!-- file: (\S+) -->\n```python\n(.*?)```", text, re.S):
        (tmp_path / name).write_text(code)
    ran = 0
    for block in re.findall(r"```console\n(.*?)```", text, re.S):
        command, *expected = block.splitlines()
        if not command.startswith("$ python3 "):
            continue
        done = subprocess.run([sys.executable, command.split()[-1]], cwd=tmp_path, capture_output=True, text=True,
                              env={**os.environ, "MPLBACKEND": "Agg"}, timeout=120)
        assert done.returncode == 0 and matches(expected, done.stdout), (command, done.stdout, done.stderr)
        ran += 1
    assert ran >= 6


def test_the_ball_of_the_readme(tmp_path):
    """In at most 15 lines what the programs in C, C++ and Fortran beside it print."""
    with open(os.path.join(os.path.dirname(GUIDE), "..", "..", "README.md"), encoding="utf-8") as file:
        text = file.read()
    (code,) = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(code.splitlines()) <= 15
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True,
                          env={**os.environ, "MPLBACKEND": "Agg"}, timeout=120)
    assert done.stdout.strip() == re.search(r"prints `(t 3 s, .*?)`", text).group(1)
