"""The paper's guidance: collision avoidance, coarse-to-fine and semantic objectives."""
