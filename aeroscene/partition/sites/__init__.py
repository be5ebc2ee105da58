"""The ground of a site as a partition."""
