"""Numbers by which compiled code tells the force laws apart."""

HERTZ = 1
STICKY = 2
ELASTO_PLASTIC = 3
MAXWELL_SLIP = 4
TENSION = 5
RELEASE = 6
IWAN = 7
GRAESSER = 8
FINGER = 9
