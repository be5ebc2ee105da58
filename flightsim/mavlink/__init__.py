"""MAVLink as a vehicle speaks it: links, one module for each microservice, and a client.

A link moves bytes, a channel is the conversation with one partner, and services answer messages.
The autopilot behind them knows nothing of MAVLink. Clients must not be able to stop or slow down a
flight, so every queue, count and memory of a partner is bounded.
"""
