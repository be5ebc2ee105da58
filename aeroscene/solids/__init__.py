"""The solids of a scene: what they are made of, their voxels, and the free space between them."""
