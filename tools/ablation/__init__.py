"""The rows of the ablation: what is switched, trained, measured and written down."""
