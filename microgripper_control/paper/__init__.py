"""The paper's tables and figures recomputed, each from the inputs that the paper states.

One module a section of the paper; `reproduction` runs them all. What the paper prints is in
`printed` and is compared with, never computed from.
"""
