"""JSON Schemas of configuration files, for editors, made from the dataclasses that files become.

They are of draft 7, which editors know best. A schema knows keys, types, ranges and names. What
compares values or needs other files is beyond it, and not a number too; the loader checks it all.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable
from typing import Annotated, Any

from lexstack.options import OLD_NAMES, NotEmpty, Pattern, Range, hints
from lexstack.tasks import TASKS, TaskConfig
from lexstack_config.field_notes import notes_of
from lexstack_config.reader import plain

Schema = dict[str, Any]
"""A JSON Schema, or a part of one."""

_SCALARS = {str: "string", bool: "boolean", int: "integer", float: "number", types.NoneType: "null"}
_DRAFT = "http://json-schema.org/draft-07/schema#"


def json_schema(kind: type, title: str) -> Schema:
    """Return the schema of the files that become the dataclass ``kind``."""
    maker = _Maker()
    root = maker.mapping(kind)
    parts = dict(sorted(maker.definitions.items()))
    return {"$schema": _DRAFT, "title": title, **root, "definitions": parts}


class _Maker:
    """Makes the schemas of types; those of dataclasses are kept by name, to be referred to."""

    def __init__(self) -> None:
        """Begin without any."""
        self.definitions: dict[str, Schema] = {}

    def mapping(self, kind: type) -> Schema:
        """Return the schema of a dataclass."""
        notes, kinds = notes_of(kind), hints(kind)
        properties: dict[str, Schema] = {}
        required = []
        for field in dataclasses.fields(kind):
            note = {"description": notes[field.name]} if field.name in notes else {}
            properties[field.name] = note | self._of(kinds[field.name])
            if field.default is not dataclasses.MISSING:
                properties[field.name]["default"] = plain(field.default)
            elif field.default_factory is dataclasses.MISSING:
                required.append(field.name)
        schema: Schema = {
            "description": " ".join((kind.__doc__ or "").partition("\n\n")[0].split()),
            "type": "object",
            "additionalProperties": False,
            "properties": properties,
            "required": required,
        }
        if kind is TaskConfig:
            self._by_type(schema)
        return _with_old_names(schema, OLD_NAMES.get(kind.__name__, {}))

    def _of(self, hint: Any) -> Schema:
        """Return the schema of a field's type."""
        if dataclasses.is_dataclass(hint):
            return self._reference(typing.cast("type", hint))
        makers: dict[Any, Callable[..., Schema]] = {
            Annotated: self._ruled,
            types.UnionType: self._either,
            typing.Union: self._either,
            tuple: self._list,
            dict: self._names,
            typing.Literal: lambda *choices: {"enum": list(choices)},
        }
        origin = typing.get_origin(hint)
        if origin is None:
            return {} if hint is Any else {"type": _SCALARS[hint]}
        return makers[origin](*typing.get_args(hint))

    def _reference(self, kind: type) -> Schema:
        """Return a reference to the schema of a dataclass, beside which other words may stand."""
        if kind.__name__ not in self.definitions:
            self.definitions[kind.__name__] = {}  # keeps its place while it is made
            self.definitions[kind.__name__] = self.mapping(kind)
        return {"allOf": [{"$ref": f"#/definitions/{kind.__name__}"}]}

    def _ruled(self, kind: Any, *rules: object) -> Schema:
        """Return the schema of a type with rules."""
        schema = self._of(kind)
        for rule in rules:
            schema |= _keywords(rule, schema)
        return schema

    def _either(self, *kinds: Any) -> Schema:
        """Return the schema of several types of which one is needed.

        Of several dataclasses the first may do without its key ``type``, which tells them apart.
        """
        schemas = [self._of(kind) for kind in kinds]
        for i in [i for i, kind in enumerate(kinds) if dataclasses.is_dataclass(kind)][1:]:
            schemas[i] = schemas[i] | {"required": ["type"]}
        return {"anyOf": schemas}

    def _list(self, first: Any, *others: Any) -> Schema:
        """Return the schema of a list of equal entries: any number, or as many as types."""
        schema = {"type": "array", "items": self._of(first)}
        number = 1 + len(others)
        return schema if others == (...,) else schema | {"minItems": number, "maxItems": number}

    def _names(self, name: Any, value: Any) -> Schema:
        """Return the schema of a mapping of names."""
        schema = {"type": "object", "additionalProperties": self._of(value)}
        return schema if name is str else schema | {"propertyNames": self._of(name)}

    def _by_type(self, schema: Schema) -> None:
        """Put into a task's schema which types there are, and the parameters of each."""
        older = {new: old for old, new in OLD_NAMES["TaskConfig.type"].items()}
        kinds, checks = [], []
        for name, factory in sorted(TASKS.items()):
            task = factory.__self__  # type: ignore[attr-defined]  # of its class method from_config
            kinds.append({"const": name, "description": task.__doc__.partition("\n")[0]})
            if name in older:
                kinds.append({"const": older[name], "deprecationMessage": f"now {name}"})
            given = typing.get_type_hints(task.__init__).get("parameters")
            parameters = given or task.parameters
            part = self._reference(parameters)
            needed = ["parameters"] * bool(self.definitions[parameters.__name__]["required"])
            names = [name, *filter(None, [older.get(name)])]
            checks.append(
                {
                    "if": {"properties": {"type": {"enum": names}}, "required": ["type"]},
                    "then": {"properties": {"parameters": part}, "required": needed},
                }
            )
        schema["properties"]["type"] |= {"anyOf": kinds}
        schema["allOf"] = checks


def _keywords(rule: object, schema: Schema) -> Schema:
    """Return a rule of a type as keywords of a schema."""
    if isinstance(rule, Range):
        exclusive = "exclusiveM" if rule.open else "m"
        ends = {f"{exclusive}inimum": rule.least, f"{exclusive}aximum": rule.most}
        return {name: end for name, end in ends.items() if math.isfinite(end)}
    if isinstance(rule, Pattern):
        return {"pattern": f"^{rule.form}$"}
    if isinstance(rule, NotEmpty):
        return {"minItems" if schema["type"] == "array" else "minProperties": 1}
    raise TypeError(f"no schema for {rule!r}")


def _with_old_names(schema: Schema, old_names: dict[str, str]) -> Schema:
    """Return a mapping's schema that takes each of its keys under one of two names."""
    properties = dict(schema["properties"])
    checks = list(schema.get("allOf", ()))
    for old, new in old_names.items():
        properties[old] = properties[new] | {"deprecationMessage": f"now {new}"}
        checks.append({"oneOf": [{"required": [name]} for name in (new, old)]})
    required = [name for name in schema["required"] if name not in old_names.values()]
    more = {"allOf": checks} if checks else {}
    return schema | {"properties": properties, "required": required} | more
