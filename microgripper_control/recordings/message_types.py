"""What the types of messages are made of: the bag says it, or ROS 2 Jazzy does."""

from __future__ import annotations

from functools import lru_cache

from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore


@lru_cache(maxsize=1)
def _jazzy_types() -> Typesdict:
    return get_typestore(Stores.ROS2_JAZZY).fielddefs


def types_with(kind: str, definition: str) -> Typesdict:
    """The fields of a type and of those it is made of: the bag's definition, else Jazzy's own.

    Types of one name differ between releases of ROS 2. Raises TypesysError if there is neither, or
    the bag's is not understood and there is no other.
    """
    known = _jazzy_types()
    if definition:
        try:
            return {**known, **get_types_from_msg(definition, kind)}
        except (TypesysError, ValueError, LookupError, RecursionError):
            if kind not in known:
                problem = "has a type whose definition in the bag is not understood"
                raise TypesysError(problem) from None
    if kind not in known:
        raise TypesysError("has a type that neither ROS 2 Jazzy nor the bag defines")
    return known
