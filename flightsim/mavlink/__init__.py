"""MAVLink as a vehicle speaks it: links, one module for each microservice, a client."""
