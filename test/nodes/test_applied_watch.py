from __future__ import annotations

from microgripper_control.nodes.applied_watch import IN_ROW, AppliedWatch

T = 1e-3


class Drive:
    """Sends voltages and hears what is applied, `lag` samples later."""

    def __init__(self, lag: int = 2) -> None:
        self.watch = AppliedWatch(0.02, 1.0)
        self.watch.begin(0.0)
        self.sent = [0.0] * lag
        self.watch.sent(0.0, 0.0)
        self.lag = lag

    def send(self, voltage: float, applied: float | None = None) -> bool:
        self.sent.append(voltage)
        self.watch.sent(voltage, len(self.sent) * T)
        return self.watch.follows(self.sent[-self.lag] if applied is None else applied)


def test_a_plant_that_does_as_it_is_told_a_little_later_is_proved_once_it_has_moved() -> None:
    drive = Drive()
    assert all(drive.send(0.0) for _ in range(50))
    assert not drive.watch.proved
    assert all(drive.send(20.0 * k) for k in range(1, 8))
    assert drive.watch.proved
    assert all(drive.send(140.0) for _ in range(50))
    assert drive.watch.refusals == 0


def test_one_that_stays_where_it_is_does_not_follow() -> None:
    drive = Drive()
    answers = [drive.send(2.0 * k, applied=0.0) for k in range(1, 100)]
    first = answers.index(False)
    assert first <= 20 + IN_ROW  # the first voltages are no longer on their way
    assert not any(answers[first:])
    assert not drive.watch.proved


def test_one_on_a_ramp_of_its_own_does_not_follow_and_is_not_proved() -> None:
    drive = Drive()
    for _ in range(30):
        drive.send(90.0, applied=0.0)
    answers = [drive.send(90.0, applied=2.0 * k) for k in range(1, 40)]
    assert not all(answers)
    assert not drive.watch.proved


def test_one_on_a_ramp_beside_that_of_the_voltages_sent_is_not_proved() -> None:
    drive = Drive()
    answers = [drive.send(2.0 * k, applied=max(0.0, 2.0 * (k - 18))) for k in range(1, 50)]
    assert all(answers)
    assert not drive.watch.proved


def test_a_few_samples_of_another_sender_are_forgiven() -> None:
    drive = Drive()
    assert all(drive.send(float(k)) for k in range(20))
    assert all(drive.send(20.0, applied=150.0) for _ in range(IN_ROW - 1))
    assert drive.send(20.0)
    assert all(drive.send(20.0, applied=150.0) for _ in range(IN_ROW - 1))
