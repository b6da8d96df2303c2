"""The site of documents: its links, equations and docstrings, and that a wrong one ends the build.

`./scripts/docs`, one of the checks of `./scripts/test`, builds the whole site.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

from support.code_blocks import ROOT, all_blocks
from website import docstrings, examples, fences, figures, links, network

EQUATIONS = [pytest.param(b.text, id=b.name) for b in all_blocks() if b.language == "math"]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


@pytest.mark.parametrize(
    ("path", "text", "moved"),
    [
        (
            "README.md",
            "[a](docs/hqp.md#x) ![b](docs/images/b.png)",
            "[a](hqp.md#x) ![b](images/b.png)",
        ),
        ("docs/report.md", "[a](../README.md#papers)", "[a](index.md#papers)"),
        ("docs/decisions/0005-x.md", "[a](../hqp.md)", "[a](../hqp.md)"),
        ("docs/licences.md", "[a](../LICENSE)", "[a](LICENSE.txt)"),
        ("README.md", "[a](https://x.org/docs/b) [c](#d)", "[a](https://x.org/docs/b) [c](#d)"),
        ("README.md", "```sh\n[a](docs/b.md)\n```\n", "```sh\n[a](docs/b.md)\n```\n"),
        ("README.md", "<!-- from a.b-c -->2<!-- / --> times", "2 times"),
        ("docs/examples.md", "[a](../examples/own_arm.py)", "[a](examples/own_arm.py)"),
    ],
)
def test_links_and_markers_of_a_document_become_those_of_its_page(path, text, moved):
    assert links.page(text, path) == moved


def test_the_page_of_examples_shows_every_program_with_its_picture():
    shown = links.page((ROOT / "docs/examples.md").read_text(encoding="utf-8"), "docs/examples.md")
    for path in links.EXAMPLES:
        assert f"```python\n{path.read_text(encoding='utf-8').rstrip()}\n```" in shown
        assert f"](images/examples/{path.stem}.png)" in shown
    pictures = {path.stem for path in (ROOT / "docs/images/examples").iterdir()}
    assert pictures == {path.stem for path in links.EXAMPLES} == set(examples.DRAWINGS)


@pytest.mark.parametrize("text", EQUATIONS)
def test_every_equation_becomes_mathml(text):
    assert fences.equation(text).startswith('<div class="equation"><math')


@pytest.mark.parametrize("text", [r"\left( a", r"\foo{a}", r"\begin{aligned} a &= b \end{aligned}"])
def test_a_wrong_equation_is_refused(text):
    with pytest.raises(fences.FenceError, match="LaTeX"):
        fences.equation(text)


def test_a_wrong_diagram_is_refused():
    with pytest.raises(fences.FenceError, match="no diagram"):
        fences.diagram("sequenceDiagram\n    A->>the solver: one; two\n")


def test_every_figure_of_the_equations_can_be_drawn_and_has_its_place():
    assert {path.stem for path in figures.FOLDER.iterdir()} == set(figures.FIGURES)
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name, draw in figures.FIGURES.items():
        assert f"images/equations/{name}.png" in text
        assert draw().axes


def test_a_public_name_without_a_docstring_is_found(tmp_path):
    package = tmp_path / "some"
    package.mkdir()
    (package / "__init__.py").write_text(
        '"""One."""\nfrom some.inner import shown\n\n__all__ = ["LEVEL", "shown"]\nLEVEL = 1\n'
    )
    (package / "inner.py").write_text(
        '"""Two."""\n\ndef shown():\n    pass\n\nclass Told:\n    """Three."""\n    field: int\n'
        "    def bare(self):\n        pass\n    def _hidden(self):\n        pass\n"
    )
    found = docstrings.missing(docstrings.ApiList(("some", "some.inner"), (tmp_path,)))
    assert found == ["some.LEVEL", "some.inner.Told.bare", "some.inner.shown"]


def test_a_function_with_the_name_of_its_module_is_found(tmp_path):
    package = tmp_path / "some"
    package.mkdir()
    (package / "__init__.py").write_text(
        '"""One."""\nfrom some.shown import shown\n\n__all__ = ["shown"]\n'
    )
    (package / "shown.py").write_text('"""Two."""\n\ndef shown():\n    pass\n')
    api = docstrings.ApiList(("some",), (tmp_path,))
    assert docstrings.hidden(docstrings.load(api)["some"]) == ["some.shown.shown"]
    assert docstrings.missing(api) == ["some.shown.shown"]


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://cdn.example.org/x.js">',
        '<link rel="stylesheet" href="//fonts.example.org/x">',
        "@font-face { src: url(https://fonts.example.org/x.woff2) }",
        '<img alt="x" src=http://example.org/x.png>',
    ],
)
def test_what_a_page_would_fetch_is_seen(text):
    assert len(network.fetched(text)) == 1


@pytest.mark.parametrize(
    "text", ['<a href="https://example.org">', '<script src="assets/x.js">', "url(../x.png)"]
)
def test_what_a_page_does_not_fetch_is_left_alone(text):
    assert not network.fetched(text)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_list_begins_after_an_empty_line(page):
    """Else the site shows it as a part of the paragraph before, unlike other readers."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    assert not re.findall(r"^(?!- |\* |[#>|]|\d+\. |\s|$).*\n(?:- |1\. ).*", text, flags=re.M)


def test_a_broken_link_ends_the_build(tmp_path):
    (tmp_path / "examples").mkdir()
    for name in ("mkdocs.yml", *links.PAGES, *links.FILES):
        shutil.copy(ROOT / name, tmp_path / name)
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    for folder in ("scripts/website", "ros2_ws/src"):
        (tmp_path / folder).parent.mkdir(exist_ok=True)
        (tmp_path / folder).symlink_to(ROOT / folder)
    page = tmp_path / "docs/bags.md"
    page.write_text(page.read_text(encoding="utf-8") + "\n[no](hqp.md#such-head)\n", "utf-8")
    config = tmp_path / "mkdocs.yml"
    text = re.sub(r"packages: \[[^]]*\]", "packages: [errors]", config.read_text(encoding="utf-8"))
    config.write_text(text, encoding="utf-8")
    program = (
        "import sys, pathlib; from website.build import build; "
        "sys.exit(build(pathlib.Path(sys.argv[1])))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, tmp_path],
        env={**os.environ, "PYTHONPATH": f"{ROOT / 'scripts'}:{os.environ.get('PYTHONPATH', '')}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "does not contain an anchor '#such-head'" in done.stdout + done.stderr
    assert "Aborted with 1 warnings" in done.stdout + done.stderr, "and nothing else is wrong"
