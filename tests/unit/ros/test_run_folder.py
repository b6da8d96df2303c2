"""The folder of a run: what is said where it cannot be made."""

import os
from pathlib import Path

import pytest

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands.demo import run_folder


def test_a_folder_of_another_account_is_told_with_its_owner_and_what_to_do(tmp_path, monkeypatch):
    """As docker makes one for -v where there is none: it is root's."""

    def refuse(path, *_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(ConfigurationError) as error:
        run_folder(tmp_path, None, "short")
    text = str(error.value)
    assert text.startswith(f"--out: {tmp_path}/runs/short-")
    assert "Permission denied" in text
    assert f"{tmp_path} is user {tmp_path.stat().st_uid}'s" in text, "the folder that is there"
    assert f"this process is user {os.geteuid()}'s" in text
    assert "mkdir it before docker run" in text
    assert "\n" not in text


def test_a_folder_that_holds_something_is_refused(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a").touch()
    with pytest.raises(ConfigurationError, match="is not empty; name another folder"):
        run_folder(tmp_path, tmp_path / "out", "short")
