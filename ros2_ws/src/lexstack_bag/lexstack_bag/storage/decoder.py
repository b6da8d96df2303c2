"""From CDR to messages, by the definitions that a bag carries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mcap.records import Schema
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack_bag.errors import BagError
from lexstack_bag.storage.container import RawMessage


class Decoder:
    """From CDR to messages, by the definitions that a bag carries."""

    def __init__(self) -> None:
        """Know no type yet."""
        self._decoders: dict[str, Callable[[bytes], Any]] = {}

    def __call__(self, message: RawMessage) -> Any:
        """Return a message's content; raises BagError."""
        name = message.schema.name
        if name not in self._decoders:
            self._decoders[name] = _decoder(message.schema)
        try:
            return self._decoders[name](message.data)
        except Exception as error:  # the decoder is generated and raises whatever it meets
            raise BagError(f"{message.topic}: a message cannot be decoded: {error}") from error


def _decoder(schema: Schema) -> Callable[[bytes], Any]:
    """Return a function from CDR to a message of a bag's own definition."""
    if schema.encoding != "ros2msg":
        raise BagError(f"{schema.name}: definitions in {schema.encoding!r} are not supported")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    return lambda data: store.deserialize_cdr(data, schema.name)
