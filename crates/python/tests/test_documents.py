"""What the README and the guide show is true."""

import doctest
import re
from pathlib import Path

import punctual3d
import pytest

ROOT = Path(__file__).resolve().parents[3]


def test_readme():
    text = re.sub("^```.*$", "", (ROOT / "crates/python/README.md").read_text(), flags=re.MULTILINE)
    test = doctest.DocTestParser().get_doctest(text, {}, "README.md", "README.md", 0)
    ran = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL).run(test)
    assert ran.failed == 0 and ran.attempted > 15


def test_package():
    ran = doctest.testmod(punctual3d)
    assert ran.failed == 0 and ran.attempted == 4


def test_guide(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(
        "^```python\n(.*?)^```$", (ROOT / "docs/guide/python.md").read_text(), flags=re.MULTILINE | re.DOTALL
    )
    names = {}
    for block in blocks:
        exec(block, names)
    assert len(blocks) == 6 and (tmp_path / "deadline.png").stat().st_size > 5_000
    assert (tmp_path / "stopped.html").stat().st_size > 50_000
    shares = [(part.found / names["whole"].found).mean() for part in names["parts"]]
    assert shares[0] < shares[-1] and shares[-1] > 0.9
