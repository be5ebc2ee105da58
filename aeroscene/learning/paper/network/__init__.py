"""The paper's network: embed, route, extract, fuse, and condition a UNet on the result."""
