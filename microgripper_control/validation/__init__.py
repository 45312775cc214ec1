"""A rig of its own, for checks on data whose effect is withheld from the diagnosis.

It imports nothing of the effects, the plant or the diagnosis, and its laws differ from theirs.
`make_case` (case.py) makes recordings of which the truth is known, and `write_case` (case_files.py)
writes them as the diagnosing process gets them, with the truth in a sealed file elsewhere.

The seed decides everything. Seeds 0 .. 9999 are for development and calibration and give the forms
"a" alone; seeds from 100000 on are for the report, and only they give the forms "b", at which no
one looks while a method is developed.
"""
