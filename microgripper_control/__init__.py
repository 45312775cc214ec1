"""Simulate, control, identify and diagnose a piezo microgripper."""

import os

# Vectors here are short and work in parallel is one process a core: BLAS threads would only spin
# against each other and against the control loop. Read by numpy's BLAS when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
