"""What the source of a dataclass says of its fields: units and meaning, in their comments."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import io
import textwrap
import tokenize


def notes_of(kind: type) -> dict[str, str]:
    """Return the comment of every field that has one, inherited fields too.

    It stands at the end of the field's lines, or in lines of its own right above the field.
    """
    notes: dict[str, str] = {}
    for each in filter(dataclasses.is_dataclass, reversed(kind.__mro__)):
        notes |= _own_notes(each)
    return notes


def _own_notes(kind: type) -> dict[str, str]:
    """Return the comments of the fields that stand in a class itself."""
    source = textwrap.dedent(inspect.getsource(kind))
    comments = _comments(source)
    (tree,) = ast.parse(source).body
    assert isinstance(tree, ast.ClassDef)
    notes, last = {}, tree.lineno
    for node in tree.body:
        end = node.end_lineno or node.lineno
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            # A comment between two fields belongs to the one below it.
            lines = [comments[line] for line in range(last + 1, end + 1) if line in comments]
            notes[node.target.id] = " ".join(lines)
        last = end
    return {name: note for name, note in notes.items() if note}


def _comments(source: str) -> dict[int, str]:
    """Return the text of every comment, by the number of its line."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return {
        token.start[0]: token.string.removeprefix("#").strip()
        for token in tokens
        if token.type == tokenize.COMMENT
    }
