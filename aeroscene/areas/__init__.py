"""Search for places where a drone may land or perch; `aeroscene.areas.landing` joins the parts."""
