"""OpenUSD: each module is made at run time from C++."""
