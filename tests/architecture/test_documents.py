"""Figures in documents: what stands between markers is what the results files say."""

import json
import re
import shutil
from pathlib import Path

import pytest

from lexstack.errors import ConfigurationError
from lexstack_experiments.benches import BENCHES
from lexstack_experiments.commands import documents
from lexstack_experiments.documents.fields import fields_of
from lexstack_experiments.documents.markers import filled, names_in
from lexstack_experiments.documents.store import Store
from lexstack_experiments.experiments import EXPERIMENTS

ROOT = Path(__file__).resolve().parents[2]
RESULTS = sorted((ROOT / "docs" / "results").glob("*.json"))


def test_every_figure_between_markers_is_the_one_of_its_results_file():
    changed = documents.changes(ROOT, Store(ROOT))
    assert not changed, "./scripts/documents writes them"


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_every_results_file_says_how_it_was_made_and_is_shown_somewhere(path):
    content = json.loads(path.read_text(encoding="utf-8"))
    known = {**EXPERIMENTS, **BENCHES}
    assert content["name"] == path.stem
    assert content["cases"] == known[path.stem].cases, "a whole run, not a shortened one"
    assert re.fullmatch(r"[0-9a-f]{10}\+?", content["commit"])
    assert {"cores", "python", "versions"} <= set(content["machine"])
    pages = [page.read_text(encoding="utf-8") for page in documents.documents(ROOT)]
    shown = {name for page in pages for name in names_in(page)}
    assert any(name.startswith(f"{path.stem}.") for name in shown)


def test_every_field_of_a_results_file_is_shown_by_some_document():
    pages = [page.read_text(encoding="utf-8") for page in documents.documents(ROOT)]
    shown = {name for page in pages for name in names_in(page)}
    counts = {f"{name}.cases" for name in EXPERIMENTS}
    assert set(fields_of(Store(ROOT))) - counts <= shown


def test_the_numbers_that_the_demo_prints_on_the_page_are_those_of_the_experiment():
    """The printed block cannot hold markers; it shows the run of ``transition-sequence``."""
    text = (ROOT / "docs/first-run.md").read_text(encoding="utf-8")
    results = Store(ROOT)["transition-sequence"]
    told = {
        "Base error after (A)": f"{results.figure('Base error after (A)')['value']:.4g} mm",
        "Peak acceleration of the command / limit": "{:.4g}".format(
            results.figure("Peak acceleration of the command / limit")["value"]
        ),
    }
    for name, value in told.items():
        (line,) = re.findall(rf"^{re.escape(name)} .*$", text, flags=re.MULTILINE)
        assert re.search(rf" {re.escape(value)}  reached$", line), line
    for switch in "ABC":
        row = results.row("switch", f"({switch})")
        pattern = rf"^{row['to']} +{row['start s']:.2f} +{row['settled s']:.2f} .*$"
        (line,) = re.findall(pattern, text, flags=re.MULTILINE)
        assert line.endswith(f" {row['acc. ratio']:.3f}"), line


def test_figures_of_the_system_bench_agree_between_the_pages():
    """Their run was not kept: docs/status.md must say what docs/experiments.md does."""
    page = (ROOT / "docs/experiments.md").read_text(encoding="utf-8")
    (rate,) = re.findall(
        r"^\| lockstep \| the controller follows the HTMPC \| (\d+) ", page, re.MULTILINE
    )
    assert f"reach {rate} ticks/s in lockstep with the MPC" in (ROOT / "docs/status.md").read_text(
        "utf-8"
    )


def test_comments_of_commands_name_the_number_of_cases_of_the_code():
    text = (ROOT / "docs/faults.md").read_text(encoding="utf-8")
    (count,) = re.findall(r"experiment faults +# (\d+) cases", text)
    assert int(count) == EXPERIMENTS["faults"].cases


# ---- these checks can fail


def copy(tmp_path):
    """Return a copy of the documents."""
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("images"))
    shutil.copy(ROOT / "README.md", tmp_path)
    return tmp_path


def test_a_figure_that_differs_is_seen_and_mended(tmp_path, monkeypatch, capsys):
    root = copy(tmp_path)
    monkeypatch.setenv("LEXSTACK_ROOT", str(root))
    page = root / "docs/experiments.md"
    right = page.read_text(encoding="utf-8")
    page.write_text(right.replace("| encoders | ", "| encoders | 7"), encoding="utf-8")
    assert documents.main(["--check"]) == 1
    assert capsys.readouterr().out == "differs docs/experiments.md\n"
    assert documents.main([]) == 0
    assert page.read_text(encoding="utf-8") == right
    assert documents.main(["--check"]) == 0


def test_the_results_of_a_run_are_taken_and_shown(tmp_path, monkeypatch):
    root = copy(tmp_path)
    monkeypatch.setenv("LEXSTACK_ROOT", str(root))
    run = root / "runs/experiment-realism-1"
    run.mkdir(parents=True)
    content = json.loads((root / "docs/results/realism.json").read_text(encoding="utf-8"))
    content["tables"][0]["rows"][0]["peak EE mm"] = 123.4123456
    content["notes"] = ["none of the documents quotes this"]
    (run / "results.json").write_text(json.dumps(content), encoding="utf-8")
    assert documents.main(["--take", str(run)]) == 0
    kept = json.loads((root / "docs/results/realism.json").read_text(encoding="utf-8"))
    assert kept["tables"][0]["rows"][0]["peak EE mm"] == 123.412
    assert "notes" not in kept
    assert "| 123 |" in (root / "docs/experiments.md").read_text(encoding="utf-8")


def test_a_run_without_results_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("LEXSTACK_ROOT", str(copy(tmp_path)))
    assert documents.main(["--take", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<!-- from no.such -->1<!-- / -->", "page: no field 'no.such'; known: a.b"),
        ("<!-- from a.b -->1", "has no '<!-- / -->'"),
        ("<!-- from a.b -->1 <!-- from a.b -->2<!-- / -->", "has no '<!-- / -->'"),
    ],
)
def test_a_wrong_marker_is_refused(text, message):
    with pytest.raises(ConfigurationError) as error:
        filled(text, {"a.b": lambda: "2"}, "page")
    assert message in str(error.value)
