"""The learned model of skeletons: which objects a scene has, of which kind, child of whom."""
