"""Controllers, without ROS: inverse feedforward, PID, both in cascade, and what they follow.

The loop's timing: at tick k the controller gets x[k] and the setpoint r[k]; its answer becomes
u[k+1], held from t[k+1] to t[k+2], so that x[k+2] is the first sample to show it.
"""

LOOP_DELAY = 2  # ticks from a displacement or setpoint read to the first displacement it moves
