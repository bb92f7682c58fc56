-- What does a small network learn of a nonlinear first-order system, one step ahead and in free run?
--
-- Figures 3.1, 3.8 to 3.19 and 4.11 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023): equation (3.9), y(k) = y(k-1) - 0.5 tanh(y(k-1) + u(k-1)^3), sampled every 0.5 s, with and without equation noise of
-- 0.02, and networks of tanh neurons. The weights in figure 3.13 are the book's.
-- plantloop script scripts/book/first_order_network.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_3_%s.%s"):format(number, format)) end

local function tanh(x)
  local e = math.exp(2 * x)
  return (e - 1) / (e + 1)
end
local function next_output(y, u) return y - 0.5 * tanh(y + u ^ 3) end

local function record(samples, hold, seed, deviation)
  local u = identify.staircase{samples = samples, hold = hold, lower = -1.2, upper = 1.2, seed = seed}
  local noise = identify.white_noise{samples = samples, deviation = math.max(deviation, 1e-300), seed = seed + 1000}
  local y = pl.zeros(samples)
  for k = 2, samples do y[k] = next_output(y[k - 1], u[k - 1]) + (deviation > 0 and noise[k] or 0) end
  return identify.data{u = u, y = y, Ts = 0.5}
end
local clean, clean_fresh = record(500, 4, 11, 0), record(300, 6, 12, 0)
local noisy, noisy_fresh = record(500, 4, 13, 0.02), record(300, 6, 14, 0.02)

local function matrix_of(xs, ys, f)
  local rows = {}
  for j = 1, #ys do
    rows[j] = {}
    for i = 1, #xs do rows[j][i] = f(xs[i], ys[j]) end
  end
  return pl.matrix(rows)
end
local us, ys = pl.linspace(-1.2, 1.2, 31), pl.linspace(-1.7, 1.7, 31)
local surface = matrix_of(us, ys, function(u, y) return next_output(y, u) end)

local figure = pl.figure{title = "The system: the next output over input and output", x = "u(k-1)", y = "y(k-1)"}
figure:surface(surface, us, ys)
save(figure, 8)

for number, data in pairs{[9] = noisy, [10] = noisy_fresh} do
  figure = pl.figure{title = number == 9 and "Identification data" or "Validation data", x = "time t [s]"}
  figure:panel{y = "y"}:line(data.time, data.y, {color = "blue"})
  figure:panel{y = "u", height = 0.5}:stairs(data.time, data.u, {color = "grey"})
  save(figure, number)
end
figure = pl.figure{title = "How often the input takes its values: identification (left) and validation (right)", columns = 2}
for _, data in ipairs{noisy, noisy_fresh} do figure:panel{x = "u", y = "samples"}:histogram(data.u, {bins = 12}) end
save(figure, 11)
local n = noisy.samples
figure = pl.figure{title = "The data on the surface of the system", x = "u(k-1)", y = "y(k-1)"}
figure:surface(surface, us, ys, {points_x = noisy.u:slice(1, n - 1), points_y = noisy.y:slice(1, n - 1), points_z = noisy.y:slice(2, n)})
save(figure, 12)

-- The size: with more neurons the training error falls on, that of other data does not (figure 3.1).
local function fit(data, neurons, starts, iterations)
  return identify.mlp(data, {regressors = "y(k-1), u(k-1)", hidden = neurons, starts = starts, iterations = iterations, seed = 1})
end
local function one_step(model, data) return identify.metrics(data.y, model:predict(data, 1), {skip = 1}).RMSE end
local function free_run(model, data) return identify.metrics(data.y, model:simulate(data), {skip = 1}).RMSE end
local short = noisy:part(1, 150)
local sizes, training, validation = pl.range(1, 12, 1), pl.zeros(12), pl.zeros(12)
for neurons = 1, 12 do
  local model = fit(short, neurons, 6, 150)
  training[neurons], validation[neurons] = one_step(model, short), one_step(model, noisy_fresh)
end
figure = pl.figure{title = "Error over the size of the network, 150 samples to learn from", x = "neurons", y = {label = "one-step RMSE", scale = "log"}}
figure:line(sizes, training, {label = "training", style = "line_points", color = "blue"})
figure:line(sizes, validation, {label = "validation", style = "line_points", color = "vermillion"})
save(figure, 1)

local exact = fit(clean, 5, 16, 500)
print(("no noise, 5 neurons: one step %s, free run %s"):format(
  one_step(exact, clean_fresh) < 0.015 and "below 0.015" or one_step(exact, clean_fresh),
  free_run(exact, clean_fresh) < 0.03 and "below 0.03" or free_run(exact, clean_fresh)))

-- The network that the book prints: W1 has columns for y(k-1), u(k-1) and 1.
local w1 = {{-0.5588, -2.0621, -1.9530}, {0.5155, 0.0499, -0.8670}, {-1.5149, 0.3190, 0.4768}, {0.3366, -1.2029, 1.8379}, {0.8411, 1.3841, 1.7123}}
local w2, bias = {1.2054, 1.7784, 0.0810, 1.1704, 1.4048}, -0.0580
local function printed(y, u)
  local sum = bias
  for i, w in ipairs(w1) do sum = sum + w2[i] * tanh(w[1] * y + w[2] * u + w[3]) end
  return sum
end
local weights = {}
for _, w in ipairs(w1) do weights[#weights + 1], weights[#weights + 2] = w[1], w[2] end
for _, w in ipairs(w2) do weights[#weights + 1] = w end
figure = pl.figure{title = "The book's network"}
figure:network(pl.vector{2, 5, 1}, {weights = pl.vector(weights), inputs = {"y(k-1)", "u(k-1)"}, outputs = {"y(k)"}})
save(figure, 13)

figure = pl.figure{title = "The next output: system (left) and the book's network (right)", columns = 2}
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(surface, us, ys)
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(matrix_of(us, ys, function(u, y) return printed(y, u) end), us, ys)
save(figure, 14)
figure = pl.figure{title = "What it is off the system", x = "u(k-1)", y = "y(k-1)"}
figure:surface(matrix_of(us, ys, function(u, y) return printed(y, u) - next_output(y, u) end), us, ys)
save(figure, 15)
-- The same as lines of equal error (figure 4.11): where a controller may trust the network.
figure = pl.figure{title = "One-step error of the book's network", x = "u(k-1)", y = "y(k-1)"}
local error_of = matrix_of(us, ys, function(u, y) return printed(y, u) - next_output(y, u) end)
figure:contour(error_of, us, ys, {filled = true})
figure:markers(noisy.u, noisy.y, {marker = "dot", color = "black", size = 2})
figure:save(("out/figure_4_11.%s"):format(format))
-- Over the plane, and where samples are: a network is right where its data were.
local within, squares = 0, 0
for k = 2, noisy.samples do
  squares = squares + (printed(noisy.y[k - 1], noisy.u[k - 1]) - next_output(noisy.y[k - 1], noisy.u[k - 1])) ^ 2
end
for j = 1, 31 do
  for i = 1, 31 do within = within + (math.abs(error_of(j, i)) < 0.05 and 1 or 0) end
end
local at_data, at_all = math.sqrt(squares / (noisy.samples - 1)), 0
for j = 1, 31 do
  for i = 1, 31 do at_all = at_all + error_of(j, i) ^ 2 end
end
at_all = math.sqrt(at_all) / 31
print(("the book's network is off by %.3f where data are, by %.3f over the plane, of which %.0f %% are within 0.05"):format(at_data, at_all, 100 * within / 31 ^ 2))

-- On data that it has not seen; the residuals of a network that was trained with noise are white.
local model = fit(noisy, 5, 16, 300)
local e = (noisy_fresh.y - model:predict(noisy_fresh, 1)):slice(2, noisy_fresh.samples)
local u = noisy_fresh.u:slice(1, noisy_fresh.samples - 1)
figure = pl.figure{title = "One-step residuals of validation", x = "e", y = "samples"}
figure:histogram(e, {bins = 20})
save(figure, 16)
figure = pl.figure{title = "Residuals with themselves"}
figure:correlation(e)
save(figure, 17)
figure = pl.figure{title = "Residuals with the input"}
figure:correlation(e, {with = u})
save(figure, 18)
local tests = identify.residual_tests(e, u)
print(("noise 0.02, 5 neurons: training %s; %s"):format(
  one_step(model, noisy) > 0.0185 and one_step(model, noisy) < 0.024 and "between 0.0185 and 0.024" or one_step(model, noisy), tests[1].meaning))

local long = record(1000, 5, 15, 0)
local run, ahead = pl.zeros(1000), pl.zeros(1000)
for k = 2, 1000 do
  run[k], ahead[k] = printed(run[k - 1], long.u[k - 1]), printed(long.y[k - 1], long.u[k - 1])
end
figure = pl.figure{title = "The book's network in free run", x = {label = "time t [s]", limits = {0, 150}}, y = "y"}
figure:line(long.time, long.y, {color = "grey", label = "system"})
figure:line(long.time, run, {color = "blue", label = "network"})
save(figure, 19)
local function near(x, expected, tolerance)
  return math.abs(x - expected) < tolerance and ("%.3f within %g"):format(expected, tolerance) or tostring(x)
end
print(("the book's network: one step %s, free run %s"):format(near(identify.metrics(long.y, ahead, {skip = 1}).RMSE, 0.022, 0.004),
                                                              near(identify.metrics(long.y, run).RMSE, 0.038, 0.008)))
