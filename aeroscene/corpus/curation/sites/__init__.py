"""Ground plans: one file a family, each lays streets and leaves parcels."""

from aeroscene.corpus.curation.sites.plan import PLANS, Scale, lay_out_site

__all__ = ["PLANS", "Scale", "lay_out_site"]
