"""Log marginal likelihood and gradient of the process in a file, by scikit-learn: seconds, value, gradient.

The gradient is by the logarithms of w1 ... wD = 1/length^2, v1 and v0, as bench_identify computes it.
"""

import sys
import time

import numpy
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

with open(sys.argv[1]) as file:
    n, d, w, v1, v0, calls = (float(word) for word in file.readline().split())
    rows = numpy.loadtxt(file)
x, y = rows[:, :-1], rows[:, -1]
kernel = ConstantKernel(v1) * RBF([w**-0.5] * int(d)) + WhiteKernel(v0)
process = GaussianProcessRegressor(kernel, alpha=0, optimizer=None).fit(x, y)
least = float("inf")
for _ in range(int(calls)):
    began = time.process_time()
    value, gradient = process.log_marginal_likelihood(kernel.theta, eval_gradient=True)
    least = min(least, time.process_time() - began)
lengths = -0.5 * gradient[1:-1]
print(least, repr(float(value)), *(repr(float(g)) for g in [*lengths, gradient[0], gradient[-1]]))
