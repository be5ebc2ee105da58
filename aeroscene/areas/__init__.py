"""Parts of finding where a drone may land or perch; `aeroscene.areas.landing` joins them."""
