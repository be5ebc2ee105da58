"""Parts of finding where a drone may land or perch; `aeroscene.landing` joins them."""
