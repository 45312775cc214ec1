"""What the SROS 2 policy allows, read as sros2 reads it."""

from __future__ import annotations

import fnmatch
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
POLICY = ROOT / "config" / "sros2" / "policy.xml"
INCLUDE = "{http://www.w3.org/2001/XInclude}include"
EVERYTHING_IN = "xpointer(/profile/*)"

# The rights of each kind of name, as in sros2's schema.
RIGHTS = {"topics": {"publish", "subscribe"}, "services": {"reply", "request"}}


@dataclass
class Enclave:
    """A node's rights: the full names that it may publish, subscribe, reply and request."""

    path: str
    node: str
    names: dict[str, set[str]] = field(
        default_factory=lambda: {right: set() for rights in RIGHTS.values() for right in rights}
    )

    def may(self, right: str, name: str) -> bool:
        """As DDS matches names, with the wildcards of fnmatch."""
        return any(fnmatch.fnmatchcase(name, allowed) for allowed in self.names[right])


def policy_root() -> ElementTree.Element:
    return ElementTree.parse(POLICY).getroot()


def enclaves() -> dict[str, Enclave]:
    """Those of the policy by their paths."""
    found = {}
    for given in policy_root().iterfind("enclaves/enclave"):
        (profile,) = given.iterfind("profiles/profile")
        namespace, node = profile.attrib["ns"], profile.attrib["node"]
        enclave = Enclave(given.attrib["path"], node)
        for kind in expanded(profile):
            names = {full_name(one.text or "", namespace, node) for one in kind}
            for right in kind.attrib:
                enclave.names[right] |= names
        assert enclave.path not in found
        found[enclave.path] = enclave
    return found


def expanded(profile: ElementTree.Element) -> Iterator[ElementTree.Element]:
    """The topics and services of a profile, those of its includes among them."""
    for child in profile:
        if child.tag == INCLUDE:
            assert child.attrib["xpointer"] == EVERYTHING_IN
            yield from ElementTree.parse(POLICY.parent / child.attrib["href"]).getroot()
        else:
            yield child


def full_name(name: str, namespace: str, node: str) -> str:
    if name.startswith("/"):
        return name
    return f"{namespace}/{node}{name[1:]}" if name.startswith("~") else f"{namespace}/{name}"
