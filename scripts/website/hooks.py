"""Hooks of mkdocs: pages from documents that lie elsewhere, the API's pages, the navigation."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

# mkdocs reads this file as a module of no package.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from website import docstrings, fences, links

_HEADED = "{show_root_heading: true, show_root_toc_entry: true}"


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Draw equations and diagrams, and put what a list or folder gives into the navigation."""
    config.mdx_configs.setdefault("pymdownx.superfences", {})["custom_fences"] = fences.FENCES
    api = [{name: api_page(name)} for name in docstrings.packages(config.extra)]
    decisions = sorted(path.name for path in Path(config.docs_dir, "decisions").glob("[0-9]*.md"))
    filled = {
        "API": ["api/index.md", *api],
        "Decisions": ["decisions/README.md", *(f"decisions/{name}" for name in decisions)],
    }
    for section in config.nav or []:
        section.update({name: filled[name] for name in section if name in filled})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the documents beside ``docs/``, the files that they link to, and the API's pages."""
    for source, target in {**links.PAGES, **links.FILES}.items():
        files.append(File.generated(config, target, abs_src_path=str(root(config) / source)))
    for name, package in docstrings.load(docstrings.api_list(root(config))).items():
        text = f"# {name}\n\n::: {name}\n"
        for path in docstrings.hidden(package):
            text += f"\n::: {path}\n    options: {_HEADED}\n"
        files.append(File.generated(config, api_page(name), content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, **_: Any) -> str:
    """Make the links of a document those of its page; API pages have none."""
    source = page.file.abs_src_path
    if source is None:
        return markdown
    return links.page(markdown, Path(source).relative_to(root(config)).as_posix())


def root(config: MkDocsConfig) -> Path:
    """Return the folder of the configuration file: the root of the clone."""
    return Path(config.config_file_path).parent


def api_page(name: str) -> str:
    """Return where the page of a package lies."""
    return f"api/{re.sub(r'^[^.]+[.]?', '', name) or 'library'}.md"
