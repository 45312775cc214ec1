"""A lifecycle node that starts by itself unless its parameter `autostart` is false."""

from __future__ import annotations

import traceback
from collections.abc import Callable

from lifecycle_msgs.srv import ChangeState
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes.parameters import declare_flag, follow_changes, parameter_names
from microgripper_control.nodes.shell import Shell
from microgripper_control.nodes.topics import NAMESPACE

RCLError = rclpy_implementation.RCLError
SUCCESS = TransitionCallbackReturn.SUCCESS


class ManagedShell(LifecycleNode, Shell):
    """Says in `configure`, `activate`, `deactivate` and `cleanup` what its transitions do.

    A MicrogripperError in one of them refuses the transition with that reason. Parameters that are
    not `live` are refused while it is configured: they would have no effect.
    """

    live: frozenset[str] = frozenset()

    def __init__(self, name: str) -> None:
        LifecycleNode.__init__(self, name, namespace=NAMESPACE)
        self._equip()
        self._answer_impossible_requests()
        self.configured = self.active = False
        self._fault: Exception | None = None
        self._starting = False
        self._autostart = declare_flag(
            self, "autostart", True, "configure and activate at start", read_only=True
        )

    def _answer_impossible_requests(self) -> None:
        """Refuse a change of state that is none from here: rclpy 7 would end the node instead."""
        service = self._service_change_state
        change = service.callback

        def answer(
            request: ChangeState.Request, response: ChangeState.Response
        ) -> ChangeState.Response:
            try:
                return change(request, response)
            except RCLError as error:
                self.get_logger().error(f"change_state: {' '.join(str(error).split())}")
                response.success = False
                return response

        service.callback = answer

    def begin(self) -> None:
        """Configure and activate; raises what stands in the way."""
        fixed = set(parameter_names(self)) - self.live - {"use_sim_time"}
        follow_changes(self, fixed, self._refuse_if_configured, lambda nothing: None)
        if self._autostart:
            self._starting = True  # who started the node is told, not the log
            for trigger in (self.trigger_configure, self.trigger_activate):
                if trigger() != SUCCESS:
                    assert self._fault is not None
                    raise self._fault
            self._starting = False

    def _refuse_if_configured(self, changes: dict[str, object]) -> None:
        if self.configured:
            name = next(iter(changes))
            raise MicrogripperError(f"{name} is read when the node is configured; clean up first")

    def leave(self) -> None:
        """Deactivate, wherever the node stands."""
        if self.active:
            self.trigger_deactivate()

    def configure(self) -> None:
        """Read the parameters and make everything ready."""

    def activate(self) -> None:
        """Begin to publish."""

    def deactivate(self) -> None:
        """Stop publishing."""

    def cleanup(self) -> None:
        """Undo `configure`."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As rclpy says."""
        result = self._transition(self.configure)
        self.configured = result == SUCCESS
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As rclpy says."""
        result = self._transition(self.activate)
        self.active = result == SUCCESS
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As rclpy says."""
        self.active = False
        return self._transition(self.deactivate)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As rclpy says."""
        self.configured = False
        return self._transition(self.cleanup)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As rclpy says: what is active is deactivated first."""
        return self.on_deactivate(state) if self.active else SUCCESS

    def _transition(self, action: Callable[[], None]) -> TransitionCallbackReturn:
        # rclpy would swallow the exception and say nothing.
        try:
            action()
        except MicrogripperError as error:
            self._fault = error
            if not self._starting:
                self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        except Exception as error:
            self._fault = error
            if not self._starting:
                self.get_logger().error(traceback.format_exc())
            return TransitionCallbackReturn.ERROR
        return SUCCESS
