"""What the tests share."""

from __future__ import annotations

import itertools
import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

DOMAINS = 101  # 1 .. 101: beyond, DDS uses ports that Linux hands out to anyone
DISCOVERY_VARIABLES = (  # of the person who runs the tests; they would lead out of the domain
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "ROS_DISCOVERY_SERVER",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
)

# Two test runs at a time begin in different places; one test after the other moves on, because a
# process that was killed stays visible in its domain for the middleware's lease.
_domains = itertools.count(os.getpid())


@contextmanager
def unused_domain() -> Iterator[int]:
    """A ROS domain that nobody on this machine uses, kept from other test runs for the while.

    DDS gives domain d the UDP ports from 7400 + 250 d on: the first participant listens at + 10,
    and nothing at + 249. Holding that last one is the claim; the process's end ends it, too.
    """
    for domain in (1 + number % DOMAINS for number in itertools.islice(_domains, DOMAINS)):
        first_port = 7400 + 250 * domain
        with ExitStack() as claims:
            try:
                for port in (first_port + 249, first_port + 10):
                    claim = claims.enter_context(socket.socket(type=socket.SOCK_DGRAM))
                    claim.bind(("", port))
                claim.close()  # the first participant will want it
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError("every ROS domain from 1 to 101 is in use on this machine")


@pytest.fixture
def ros_domain(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[dict[str, str]]:
    """Put this test into a ROS domain of its own, on this machine alone.

    The environment for the test's processes; rclpy in the test's own process sees it as well.
    """
    with unused_domain() as domain:
        for variable in DISCOVERY_VARIABLES:
            monkeypatch.delenv(variable, raising=False)
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "ros_log"))
        yield dict(os.environ)
