import sys, cProfile, pstats

sys.path.insert(0, "/work/wt/clients/tools")
import fuzz_mavlink

siege = fuzz_mavlink.Siege("hover", sys.argv[1], 21, 4, "px4")
p = cProfile.Profile()
import time

for _ in range(20):
    siege.tick()
n0 = siege.n_frames
t = time.process_time()
while siege.n_frames < n0 + 15000:
    siege.tick()
print("us/frame", 1e6 * (time.process_time() - t) / 15000)
p.enable()
n0 = siege.n_frames
while siege.n_frames < n0 + 15000:
    siege.tick()
p.disable()
s = pstats.Stats(p)
s.sort_stats("tottime").print_stats(38)
