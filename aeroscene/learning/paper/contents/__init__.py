"""The prior of a layout's contents: the site's extent and the list of categories.

The paper noises categories as it noises positions, though c is in {1..C}. A Gaussian hides a
one-hot vector long before positions are settled, so the network would place objects without knowing
their categories. The paper also says that categories condition the network, as soft embeddings. We
follow the latter: a small recurrent network draws the list, and diffusion draws the boxes for it.
"""
