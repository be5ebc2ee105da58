"""Parts of `measure_loss.py`: a proxy that loses datagrams, and a client that asks again."""
