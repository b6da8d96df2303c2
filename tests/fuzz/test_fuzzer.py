"""A short run of the fuzzer with a fixed seed, and proof that the fuzzer can fail."""

import importlib.util
from pathlib import Path

import pytest

from support import fuzz_config, fuzz_messages

_SPEC = importlib.util.spec_from_file_location("fuzz_run", Path(__file__).with_name("run.py"))
run = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(run)


@pytest.mark.parametrize(
    ("module", "runs"), [(fuzz_config, 1500), (fuzz_messages, 4000)], ids=["config", "messages"]
)
def test_no_input_of_a_short_run_does_harm(module, runs):
    tried, taken = run.plain_run(module.seeds(), module.one, runs, seed=1)
    assert tried == runs
    assert 0 < taken < runs, "some inputs fit, some do not"


@pytest.mark.parametrize("module", [fuzz_config, fuzz_messages], ids=["config", "messages"])
def test_every_seed_is_taken(module):
    for data in module.seeds():
        assert module.one(data), data[:80]


def test_a_crash_is_found_and_its_input_shown(capsys):
    def fragile(data):
        assert b"\xff" not in data
        return True

    with pytest.raises(AssertionError):
        run.plain_run([b"good input"], fragile, 5000, seed=1)
    assert "the input that failed: b'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "line", ["other.yaml: wrong", "file.yaml: two\nlines", "file.yaml: " + "x" * 5000]
)
def test_a_refusal_that_is_not_one_clear_line_is_a_crash(line):
    with pytest.raises(AssertionError):
        fuzz_config.check_line(line)
