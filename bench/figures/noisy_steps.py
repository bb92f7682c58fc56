# The reference figure by matplotlib: python3 noisy_steps.py FILE...
import sys
import numpy as np
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

t = np.linspace(0, 10, 10000)
noise = np.random.default_rng(1)
plt.figure(figsize=(12, 8), dpi=100)
for zeta in (0.1, 0.2, 0.4, 0.7, 0.9):
    wd = 2 * np.sqrt(1 - zeta**2)
    y = 1 - np.exp(-2 * zeta * t) * (np.cos(wd * t) + 2 * zeta / wd * np.sin(wd * t))
    plt.plot(t, y + noise.uniform(-0.03, 0.03, t.size), label=f"ζ = {zeta}")
plt.title("Step responses for five dampings, with sensor noise")
plt.xlabel("time t [s]")
plt.ylabel("output y [m]")
plt.grid()
plt.legend()
for path in sys.argv[1:]:
    plt.savefig(path)
