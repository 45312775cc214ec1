from __future__ import annotations

import socket
from contextlib import ExitStack

import pytest

from microgripper_control.demo.domain import (
    DISCOVERY_VARIABLES,
    DOMAINS,
    on_this_machine,
    unused_domain,
)


def test_nobody_gets_the_domain_of_another() -> None:
    with ExitStack() as held:
        domains = [held.enter_context(unused_domain()) for _ in range(5)]
    assert len(set(domains)) == 5
    assert set(domains) <= set(range(1, DOMAINS + 1))


def test_a_domain_with_a_participant_in_it_is_passed_over() -> None:
    with unused_domain() as domain:
        following = 1 + domain % DOMAINS
    with ExitStack() as participant:
        first = participant.enter_context(socket.socket(type=socket.SOCK_DGRAM))
        first.bind(("", 7400 + 250 * following + 10))
        with unused_domain() as domain:
            assert domain != following


def test_nothing_leads_out_of_the_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in DISCOVERY_VARIABLES:
        monkeypatch.setenv(variable, "elsewhere")
    environment = on_this_machine(7)
    assert not set(DISCOVERY_VARIABLES) & set(environment)
    assert environment["ROS_DOMAIN_ID"] == "7"
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
