"""What the paper does not state, and what is taken instead."""

ASSUMPTIONS = (
    "The paper's measurements are not available. A simulated actuator with the parameters of "
    "Table 1 stands in for the real one, so the reproduction checks the paper's computations "
    "against each other, not its model against reality.",
    "Course, rate and sampling of the 0 to 160 V experiment: five cycles of a sine at 1 Hz, read "
    "at 1 kHz, on an actuator that was never driven before. The hysteresis does not depend on the "
    "rate; where something else does, its dependence is shown.",
    "The sensor's zero lies on its grid of 1 µm. Elsewhere between two of its steps its resolution "
    "moves the inverse model's parameters by less, or by up to twice as much.",
    "The flexure's COMSOL model: a linear elastic stand-in with the printed stiffness.",
    "The linearisation's drive frequency: 1 Hz, and a sweep.",
    "Sampling and delay of the control loop: 1 kHz, held, each answer applied one tick after the "
    "sample it answers.",
    "The setpoints: sines within what every plant compared can reach in cycling. What an error is: "
    "setpoint minus true displacement, % of the setpoint's peak to peak, rms and largest.",
    "No compensation means the straight line through zero that fits the experiment best.",
)
