"""The solids of a scene: their primitives, their voxels, and the free space between them."""
