from __future__ import annotations

from types import SimpleNamespace

from microgripper_control.nodes.rivals import LEASE, Rivals


class Graph:
    """Stands in for a node: what it says of a topic's publishers."""

    def __init__(self) -> None:
        self.listed: dict[int, str] = {}

    def resolve_topic_name(self, topic: str) -> str:
        return f"/microgripper/{topic}"

    def get_publishers_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        return [
            SimpleNamespace(endpoint_gid=list(gid.to_bytes(16, "big")), node_name=name)
            for gid, name in self.listed.items()
        ]


def test_two_that_stay_are_reported_by_name_and_the_report_ends_with_them() -> None:
    graph = Graph()
    rivals = Rivals(graph, "setpoint")
    graph.listed = {1: "reference", 2: "intruder"}
    assert not rivals.look(0.0)
    assert not rivals.look(LEASE)
    assert rivals.look(LEASE + 1.0)
    assert rivals.state == "2 publishers: intruder, reference"
    del graph.listed[2]
    assert not rivals.look(LEASE + 2.0)
    assert rivals.state == "ok"


def test_a_publisher_killed_and_started_again_and_again_is_no_rival_of_itself() -> None:
    graph = Graph()
    rivals = Rivals(graph, "setpoint")
    gone: dict[int, float] = {}  # until when the killed ones stay listed
    for second in range(300):
        if second % 7 == 0:
            gone |= {gid: second + 20.0 for gid in graph.listed if gid not in gone}
            graph.listed[second] = "reference"
        graph.listed = {
            gid: name for gid, name in graph.listed.items() if gone.get(gid, 1e9) > second
        }
        assert not rivals.look(float(second), per_sample=1.0)


def test_more_messages_than_one_would_send_are_proof_at_once() -> None:
    graph = Graph()
    rivals = Rivals(graph, "setpoint")
    graph.listed = {1: "reference"}
    assert not rivals.look(0.0, per_sample=2.0)  # one that sends too much
    graph.listed[2] = "reference"
    assert not rivals.look(1.0, per_sample=1.0)
    assert rivals.look(2.0, per_sample=2.0)
