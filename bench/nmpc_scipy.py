# The controller of bench/nmpc.cpp with scipy: the same network, cost, limits and plant. Prints the seconds of the loop and the sum of
# the squares of its outputs, or nothing where there is no scipy.
import sys
import time

try:
    import numpy as np
    from scipy.optimize import minimize
except ImportError:
    sys.exit(0)

W1 = np.array([[-0.5588, -2.0621, -1.953], [0.5155, 0.0499, -0.867], [-1.5149, 0.319, 0.4768], [0.3366, -1.2029, 1.8379],
               [0.8411, 1.3841, 1.7123]])
W2, BIAS = np.array([1.2054, 1.7784, 0.081, 1.1704, 1.4048]), -0.058
HORIZON, MOVES, BETA = 8, 3, 0.02
WY, WU, WB = W1[:, 0].copy(), W1[:, 1].copy(), W1[:, 2].copy()


def cost_and_gradient(v, y, error, w, before):
    steps = np.diff(np.concatenate(([before], v)))
    cost = BETA * np.dot(steps, steps)
    gradient = 2 * BETA * (steps - np.append(steps[1:], 0))
    slope = np.zeros(MOVES)
    for j in range(HORIZON):
        move = min(j, MOVES - 1)
        h = np.tanh(WY * y + WU * v[move] + WB)
        d = W2 * (1 - h * h)
        slope = np.dot(d, WY) * slope
        slope[move] += np.dot(d, WU)
        y = np.dot(W2, h) + BIAS
        miss = y + error - w
        cost += miss * miss
        gradient = gradient + 2 * miss * slope
    return cost, gradient


samples = int(sys.argv[1])
y = model = total = 0.0
before = -0.7
plan = np.full(MOVES, before)
began = time.perf_counter()
for k in range(samples):
    w = (0.4, 0.7, 0.2, 0.5)[k // 20 % 4]
    total += y * y
    plan = np.append(plan[1:], plan[-1])
    arguments = (model, y - model, w, before)

    def search(start):
        return minimize(cost_and_gradient, start, arguments, "SLSQP", True, bounds=[(-1.5, 1.5)] * MOVES, options={"ftol": 1e-14})

    found = search(plan)
    candidates = [np.full(MOVES, -1.5 + 3 * c / 10) for c in range(11)]
    best = min(candidates, key=lambda v: cost_and_gradient(v, *arguments)[0])
    if cost_and_gradient(best, *arguments)[0] < found.fun:
        found = min(found, search(best), key=lambda r: r.fun)
    plan = found.x
    u = before = plan[0]
    model = np.dot(W2, np.tanh(WY * model + WU * u + WB)) + BIAS
    y = y - 0.5 * np.tanh(y + u**3)
print(time.perf_counter() - began, total)
