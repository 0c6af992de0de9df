"""The program of the site's front page: a pendulum of bodies and joints in at most 20 lines."""

import os
import re
import subprocess
import sys

PAGE = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "index.md")


def test_front_page(tmp_path):
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    (code,) = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(code.splitlines()) <= 20
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True,
                          env={**os.environ, "MPLBACKEND": "Agg"}, timeout=120)
    assert done.stdout == re.search(r"```console\n(.*?)```", text, re.S)[1]
    assert (tmp_path / "pendulum.png").stat().st_size > 10000 and (tmp_path / "pendulum.gif").stat().st_size > 10000
