"""Ground plans: one file for each family, which lays streets and leaves parcels."""

from aeroscene.corpus.curation.sites.plan import PLANS, Scale, lay_out_site

__all__ = ["PLANS", "Scale", "lay_out_site"]
