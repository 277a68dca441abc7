"""The types of the stubs are those that a caller needs."""

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

SAMPLE = Path(__file__).with_name("typed_sample.py")


def test_the_sample_runs():
    runpy.run_path(str(SAMPLE))


@pytest.mark.parametrize(
    "module, options", [("mypy", ["--strict", "--disable-error-code=func-returns-value"]), ("pyright", [])]
)
def test_the_sample_is_typed(module, options, tmp_path):
    pytest.importorskip(module)
    command = [sys.executable, "-m", module, *options, str(SAMPLE)]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_the_package_is_typed(tmp_path):
    pytest.importorskip("mypy")
    for options in (["-p", "punctual3d"],):
        command = [sys.executable, "-m", "mypy", "--strict", *options]
        checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
        assert checked.returncode == 0, checked.stdout + checked.stderr
