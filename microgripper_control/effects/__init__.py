"""The links of the signal chain, one a file, in the folder of their stage."""
