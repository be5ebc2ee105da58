"""The prior of what a layout has: the site's extent and the list of categories.

The paper noises categories as it noises positions, though c is in {1..C}: a Gaussian leaves
nothing to read of a one-hot vector long before positions are settled, so that a network places
objects without knowing what they are. It also says that categories condition the network, as soft
embeddings. So they do here, and a small recurrent network draws the list.
"""
