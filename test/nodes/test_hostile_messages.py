"""A controller that is fed by hand, in this process, on a clock that the test moves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ros_arguments import ros_arguments
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.control.limits import VoltageLimits
from microgripper_control.nodes.controller import ControllerNode
from microgripper_control.nodes.health import Health, Level
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.rig import Rig

pytestmark = pytest.mark.ros

T = 1e-3
LIMITS = VoltageLimits()
MAKE = Callable[..., "Bench"]


class Bench:
    """The node, a rig of the test's own, and everything the node publishes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.time = 1000.0
        self.sent: list[tuple[float, float]] = []
        monkeypatch.setattr(time, "monotonic", self.now)
        self.node = ControllerNode()
        self.node.begin()
        self.node._output.publisher, self._publisher = self, self.node._output.publisher
        self.rig = Rig(nominal_model(), T)
        self.obeys = True

    def now(self) -> float:
        return self.time

    def publish(self, message: Float64) -> None:
        """Take what the node publishes."""
        self.sent.append((self.now(), message.data))
        if self.obeys:
            self.rig.command(message.data)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        return getattr(self._publisher, name)

    def sample(self, **changes: object) -> None:
        """A sample a tick later, as the rig would send it but for the changes."""
        self.time += T
        self.rig.tick()
        fields: dict[str, Any] = {
            "name": ["finger"],
            "position": [self.rig.position],
            "effort": [self.rig.voltage],
        }
        message = JointState(**{**fields, **changes})
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(
            round(self.now() * 1e9), 10**9
        )
        self.hear(message)

    def hear(self, message: JointState) -> None:
        self.node._on_sample(message)
        self.node.work(self.now())

    def run(self, count: int, setpoint: float | None = None) -> None:
        for _ in range(count):
            if setpoint is not None:
                self.node._on_setpoint(Float64(data=setpoint))
            self.sample()

    def wait(self, length: float) -> None:
        """Let time pass, in which the node looks and nothing comes."""
        end = self.now() + length
        while self.now() < end:
            self.time += T
            self.node.work(self.now())

    def health(self) -> Health:
        return self.node.health(1.0)

    @property
    def voltage(self) -> float:
        return self.sent[-1][1]


@pytest.fixture
def bench(ros: Callable[..., None]) -> Iterator[MAKE]:
    """`bench(setpoint_out_of_reach="refuse")` makes one."""
    made: list[Bench] = []
    patches = pytest.MonkeyPatch()

    def make(**parameters: object) -> Bench:
        for one in made:
            one.node.destroy_node()
        made.clear()
        ros(*ros_arguments(parameters))
        made.append(Bench(patches))
        return made[-1]

    yield make
    patches.undo()  # on the way down time has to pass by itself
    for one in made:
        one.node.leave()
        one.node.destroy_node()


def holds(sent: list[tuple[float, float]]) -> bool:
    """Whether voltages are finite, in range and in rate."""
    in_range = all(LIMITS.low <= voltage <= LIMITS.high for _, voltage in sent)
    return in_range and all(
        abs(voltage - before) <= LIMITS.rate * max(at - then, T) + 1e-6
        for (then, before), (at, voltage) in pairwise(sent)
    )


values = st.floats() | st.floats(-10.0, 200.0) | st.floats(0.0, 2e-5)
messages = st.builds(
    JointState,
    name=st.sampled_from([[], ["finger"], ["thumb"], ["thumb", "finger"]]),
    position=st.lists(values, max_size=2),
    effort=st.lists(values, max_size=2),
)
stamps = st.builds(Time, sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 2**32 - 1))
steps = st.one_of(
    st.tuples(st.just("stamped"), messages, stamps),
    st.tuples(st.just("now"), messages, st.just(None)),
    st.tuples(st.just("setpoint"), values, st.just(None)),
    st.tuples(st.just("honest"), st.integers(1, 30), st.just(None)),
    st.tuples(st.just("time"), st.floats(0.0, 0.2), st.just(None)),
    st.tuples(st.just("asleep"), st.floats(0.0, 2.0), st.just(None)),
)


def test_whatever_comes_the_voltage_is_sane_and_afterwards_the_setpoint_is_tracked(
    bench: MAKE,
) -> None:
    made = bench()

    @settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    @given(st.lists(steps, max_size=30))
    def check(script: list[tuple[str, Any, Any]]) -> None:
        for kind, what, stamp in script:
            if kind == "stamped":
                what.header.stamp = stamp
                made.hear(what)
            elif kind == "now":
                made.sample(name=what.name, position=what.position, effort=what.effort)
            elif kind == "setpoint":
                made.node._on_setpoint(Float64(data=what))
            elif kind == "honest":
                made.run(what)
            elif kind == "time":
                made.wait(what)
            else:
                made.time += what
        assert holds(made.sent)
        made.run(400, 8e-6)
        assert made.rig.position == pytest.approx(8e-6, abs=0.1e-6)

    check()


def test_lost_feedback_brings_the_voltage_down_and_the_next_sample_up_again(bench: MAKE) -> None:
    made = bench()
    made.run(300, 8e-6)
    made.wait(0.001)  # for a setpoint that does not come
    up = made.voltage
    count = len(made.sent)
    made.wait(0.058)
    assert len(made.sent) == count
    made.wait(0.2)
    assert holds(made.sent)
    assert made.voltage == 0.0
    down = [voltage for _, voltage in made.sent[count:]]
    assert down[0] == pytest.approx(up - 2.0)
    health = made.health()
    assert (health.level, health.message) == (
        Level.ERROR,
        "feedback lost: none comes; safe voltage",
    )
    made.run(300)  # by the setpoint that it has
    assert made.rig.position == pytest.approx(8e-6, abs=0.05e-6)
    made.run(20, 8e-6)
    assert made.health().level is Level.OK


def test_a_sample_repeated_is_not_answered_and_becomes_a_loss(bench: MAKE) -> None:
    made = bench()
    made.run(300, 8e-6)
    stale = JointState(name=["finger"], position=[0.0], effort=[0.0])
    stamp = round(made.now() * 1e9)
    stale.header.stamp.sec, stale.header.stamp.nanosec = divmod(stamp, 10**9)
    made.hear(stale)
    count = len(made.sent)
    for _ in range(200):
        made.time += T
        made.hear(stale)
    assert made.voltage == 0.0
    assert count < len(made.sent) < count + 100
    assert "lost: a stale sample repeated" in made.health().message


@pytest.mark.parametrize(
    "wild",
    [
        {"position": []},
        {"effort": []},
        {"name": ["thumb"]},
        {"position": [math.nan]},
        {"effort": [math.inf]},
    ],
)
def test_samples_that_say_nothing_are_survived_for_a_while(
    bench: MAKE, wild: dict[str, Any]
) -> None:
    made = bench()
    made.run(300, 8e-6)
    up = made.voltage
    for _ in range(50):
        made.sample(**wild)
    assert made.voltage == pytest.approx(up, abs=1.0)
    assert made.health().message.startswith("joint_states: no finite position and effort")
    for _ in range(200):
        made.sample(**wild)
    assert made.voltage == 0.0


def test_setpoints_out_of_reach_are_clamped_or_refused(bench: MAKE) -> None:
    clamps = bench()
    clamps.run(400, 8e-6)
    clamps.run(400, 1.0)
    assert clamps.rig.position > 15e-6
    assert clamps.health().message == "setpoints not finite or out of reach"
    refuses = bench(setpoint_out_of_reach="refuse")
    refuses.run(400, 8e-6)
    refuses.run(400, 1.0)
    assert refuses.rig.position == pytest.approx(8e-6, abs=0.05e-6)
    assert refuses.health().message == "setpoints not finite or out of reach"


def test_a_stream_of_setpoints_that_stops_returns_the_voltage_where_that_is_asked(
    bench: MAKE,
) -> None:
    made = bench(setpoint_loss="return")
    made.run(300, 8e-6)
    made.run(190)
    assert made.voltage > 50.0
    made.run(100)
    assert made.voltage == 0.0
    assert made.health().message == "the stream of setpoints stopped: returned to safe"
    made.run(300, 8e-6)
    assert made.rig.position == pytest.approx(8e-6, abs=0.05e-6)
    assert holds(made.sent)


def test_a_rig_that_does_not_listen_finds_no_voltage_wound_up(bench: MAKE) -> None:
    made = bench()
    made.obeys = False
    made.run(2000, 8e-6)
    assert max(voltage for _, voltage in made.sent) < 60.0
    assert made.health().message == "the plant does not apply voltage_command"
    made.obeys = True
    made.run(300, 8e-6)
    assert made.rig.position == pytest.approx(8e-6, abs=0.05e-6)
    assert holds(made.sent)


def test_samples_that_come_too_fast_do_not_make_the_voltage_fast(bench: MAKE) -> None:
    made = bench()
    made.run(100, 3e-6)
    start, before = made.now(), made.voltage
    for _ in range(200):  # ten times as fast
        made.time -= 0.9 * T
        made.run(1, 15e-6)
    assert abs(made.voltage - before) <= LIMITS.rate * (made.now() - start) + 1e-6
