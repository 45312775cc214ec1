"""The policy for SROS 2 is what the nodes need, and no more.

The wheels of ROS 2 are built without security: that the middleware enforces it is not tested here.
"""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from running_nodes import PATIENCE, Start, Watcher
from sros2_policy import (
    EVERYTHING_IN,
    INCLUDE,
    RIGHTS,
    ROOT,
    Enclave,
    enclaves,
    expanded,
    policy_root,
)

from microgripper_control.core.recording import Recording
from microgripper_control.recordings.write import write_bag

NAMESPACE = "/microgripper"
OPERATOR = "operator"  # a person, no node
NAME = re.compile(r"(~/|/)?[a-z_]+(/[a-z_]+)*|\*")

# Allowed and not there in every run: simulated time, the setpoints that a run has none of.
AT_TIMES = {
    ("subscribe", "/clock"),
    ("publish", f"{NAMESPACE}/setpoint"),
    ("publish", f"{NAMESPACE}/voltage_setpoint"),
    ("subscribe", f"{NAMESPACE}/voltage_setpoint"),
}


def test_it_is_as_the_schema_says() -> None:
    """Written out here after sros2/policy/schemas/policy.xsd, version 0.2.0."""
    policy = policy_root()
    assert (policy.tag, policy.attrib) == ("policy", {"version": "0.2.0"})
    assert [child.tag for child in policy] == ["enclaves"]
    for enclave in policy[0]:
        assert enclave.tag == "enclave"
        assert set(enclave.attrib) == {"path"}
        (profiles,) = enclave
        assert (profiles.tag, profiles.attrib) == ("profiles", {})
        for profile in profiles:
            assert profile.tag == "profile"
            assert set(profile.attrib) == {"ns", "node"}
            for child in profile:
                assert child.tag in {INCLUDE, *RIGHTS}
            for kind in expanded(profile):
                assert set(kind.attrib) <= RIGHTS[kind.tag]
                assert set(kind.attrib.values()) == {"ALLOW"}
                assert len(kind) > 0
                for one in kind:
                    assert (one.tag, one.attrib) == (kind.tag.removesuffix("s"), {})
                    assert NAME.fullmatch(one.text or "")


def test_no_comment_stands_where_sros2_expects_an_enclave() -> None:
    """It takes everything below `enclaves` for one, comments included."""
    text = (ROOT / "config" / "sros2" / "policy.xml").read_text(encoding="utf-8")
    within = text[text.index("<enclaves>") : text.index("</enclaves>")]
    outside = re.sub(r"<enclave .*?</enclave>", "", within, flags=re.DOTALL)
    assert "<!--" not in outside
    assert EVERYTHING_IN in text


def test_every_node_has_an_enclave_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(
        sys.modules,
        "setuptools",
        SimpleNamespace(setup=lambda **given: None, find_packages=lambda **given: []),
    )
    monkeypatch.chdir(ROOT)
    nodes = runpy.run_path("setup.py")["NODES"]
    assert set(enclaves()) == {f"{NAMESPACE}/{node}" for node in [*nodes, OPERATOR]}
    assert all(path == f"{NAMESPACE}/{one.node}" for path, one in enclaves().items())


@pytest.mark.parametrize(
    ("right", "name", "nodes"),
    [
        ("publish", "voltage_command", {"controller"}),
        ("publish", "joint_states", {"plant_simulator"}),
        ("publish", "setpoint", {"reference", "player", OPERATOR}),
        ("subscribe", "voltage_command", {"plant_simulator", "recorder", OPERATOR}),
        ("request", "controller/set_parameters", {"identifier", OPERATOR}),
        ("request", "controller/change_state", {OPERATOR}),
        ("reply", "controller/change_state", {"controller"}),
    ],
)
def test_who_may(right: str, name: str, nodes: set[str]) -> None:
    found = enclaves().values()
    assert {e.node for e in found if e.may(right, f"{NAMESPACE}/{name}")} == nodes


@pytest.mark.ros
def test_it_allows_what_the_nodes_do_and_no_more(
    start: Start, watcher: Watcher, tmp_path: Path
) -> None:
    recording = Recording(
        "made", 1e-3, 50.0 - 50.0 * np.cos(6.0e-3 * np.arange(2000)), setpoint=np.zeros(2000)
    )
    write_bag(tmp_path / "bag", recording)
    measured = Recording("made", 1e-3, recording.voltage, 1e-7 * recording.voltage)
    write_bag(tmp_path / "run", measured)
    settings: dict[str, dict[str, object]] = {
        "plant_simulator": {},
        "controller": {},
        "reference": {},
        "diagnoser": {},
        "recorder": {"out": "new"},
        # Both wait for somebody who never comes, and stay.
        "player": {"recording": "bag", "topics": ["setpoint"], "partners": ["nobody"]},
        "identifier": {"recordings": ["run"], "controller": "nobody", "timeout": PATIENCE},
    }
    for name, given in settings.items():
        start(name, **given)
    for enclave in enclaves().values():
        if enclave.node != OPERATOR:
            check(watcher, enclave)


def check(watcher: Watcher, enclave: Enclave) -> None:
    """What the node has must be what it may."""
    allowed = {(right, name) for right, names in enclave.names.items() for name in names}
    found: set[tuple[str, str]] = set()

    def complete() -> bool:
        found.update(rights_used(watcher, enclave.node))
        return allowed - AT_TIMES <= found

    try:
        watcher.until(complete, f"all that {enclave.node} may")
    except AssertionError:
        pytest.fail(f"{enclave.path}: allowed, never used: {sorted(allowed - AT_TIMES - found)}")
    assert found <= allowed, f"{enclave.path}: used, not allowed: {sorted(found - allowed)}"


def rights_used(watcher: Watcher, node: str) -> set[tuple[str, str]]:
    """What the node has in the graph right now."""
    graph = watcher.node
    if node not in graph.get_node_names():
        return set()
    listed = {
        "publish": graph.get_publisher_names_and_types_by_node,
        "subscribe": graph.get_subscriber_names_and_types_by_node,
        "reply": graph.get_service_names_and_types_by_node,
        "request": graph.get_client_names_and_types_by_node,
    }
    rights = {
        (right, name) for right, names in listed.items() for name, _ in names(node, NAMESPACE)
    }
    # The identifier here asks a controller that is not there, under another name.
    return {(right, name.replace("/nobody/", "/controller/")) for right, name in rights}
