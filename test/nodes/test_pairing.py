from __future__ import annotations

import math

from microgripper_control.nodes.pairing import Paired, Pairing


def test_in_lockstep_a_sample_waits_for_its_setpoint() -> None:
    pairing = Pairing(5.0, lockstep=True)
    assert not pairing.sample(1.0, 2.0, now=10.0)
    assert pairing.deadline == 15.0
    assert pairing.setpoint(3.0)
    assert pairing.take() == Paired(1.0, 2.0, 3.0)
    assert pairing.deadline == math.inf


def test_in_lockstep_a_setpoint_may_come_before_its_sample() -> None:
    pairing = Pairing(5.0, lockstep=True)
    assert not pairing.setpoint(3.0)
    assert pairing.sample(1.0, 2.0, now=0.0)
    assert pairing.take() == Paired(1.0, 2.0, 3.0)


def test_in_lockstep_without_a_reference_nothing_is_waited_for() -> None:
    pairing = Pairing(5.0, lockstep=True, awaits=False)
    assert pairing.sample(1.0, 2.0, now=0.0)
    assert pairing.take().setpoint is None


def test_two_setpoints_for_one_sample_are_noticed() -> None:
    pairing = Pairing(5.0, lockstep=True)
    pairing.setpoint(3.0)
    pairing.setpoint(4.0)
    assert pairing.surplus == 1


def test_in_wall_time_setpoints_set_by_hand_are_not_waited_for() -> None:
    pairing = Pairing(0.0005, lockstep=False)
    assert pairing.sample(1.0, 2.0, now=0.0)
    pairing.take()
    assert not pairing.setpoint(3.0)
    assert not pairing.sample(1.0, 2.0, now=0.001)  # the next might be on its way
    assert pairing.deadline == 0.0015
    assert pairing.take().setpoint == 3.0
    assert pairing.sample(1.0, 2.0, now=0.002)


def test_in_wall_time_a_late_setpoint_does_not_make_all_that_follow_late() -> None:
    pairing = Pairing(0.0005, lockstep=False)
    pairing.sample(0.0, 0.0, now=0.0)
    pairing.take()
    pairing.setpoint(10.0)  # of sample 0, too late
    assert not pairing.sample(0.0, 0.0, now=0.001)
    assert pairing.setpoint(11.0)  # of sample 1, in time
    assert pairing.take().setpoint == 11.0


def test_a_setpoint_that_was_forgotten_is_not_taken() -> None:
    pairing = Pairing(0.0, lockstep=False)
    pairing.setpoint(20.0)
    pairing.forget_setpoint()
    pairing.sample(1.0, 2.0, now=0.0)
    assert pairing.take().setpoint is None


def test_a_setpoint_that_was_refused_does_not_take_the_place_of_a_good_one() -> None:
    pairing = Pairing(1e-3, lockstep=False)
    pairing.setpoint(5e-6)
    pairing.setpoint(math.nan)
    pairing.sample(0.0, 1.0, 0.0)
    assert pairing.take().setpoint == 5e-6
