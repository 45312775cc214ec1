"""A ROS domain that is nobody else's: in a shared one, each controller would hear two plants."""

from __future__ import annotations

import itertools
import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from microgripper_control.core.errors import MicrogripperError

DOMAINS = 101  # 1 .. 101: beyond, DDS uses ports that Linux hands out to anyone
DISCOVERY_VARIABLES = (  # of the person at this machine; they would lead out of the domain
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "ROS_DISCOVERY_SERVER",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
)

# Two processes begin in different places. Each domain follows the last one, because a node that was
# killed stays visible in its domain for the middleware's lease.
_domains = itertools.count(os.getpid())


@contextmanager
def unused_domain() -> Iterator[int]:
    """A ROS domain that nobody on this machine uses, kept from others like this for the while.

    DDS gives domain d the UDP ports from 7400 + 250 d on: the first participant listens at + 10,
    and nothing at + 249. Holding that last one is the claim; the process's end ends it, too. Raises
    MicrogripperError if there is none.
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
    raise MicrogripperError(f"every ROS domain from 1 to {DOMAINS} is in use on this machine")


def on_this_machine(domain: int) -> dict[str, str]:
    """This process's environment for nodes in a domain that does not leave the machine."""
    own = {name: value for name, value in os.environ.items() if name not in DISCOVERY_VARIABLES}
    return own | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(domain)}
