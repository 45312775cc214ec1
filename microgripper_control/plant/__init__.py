"""The plant: the chain of links, its model file, batch and streaming simulation."""
